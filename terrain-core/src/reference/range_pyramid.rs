//! The lowest and highest heights of the cells of a tile, in blocks of 2, 4, 8 .. cells a side.
//!
//! After Art Tevs, Ivo Ihrke and Hans-Peter Seidel, "Maximum Mipmaps for Fast, Accurate, and
//! Scalable Dynamic Height Field Rendering", 2008; with minima, so that rays below pass as well.

/// Heights of a block of cells: `[lowest, highest]` metres; inverted where it holds no data.
pub(super) type BlockRange = [f32; 2];

const NO_DATA: BlockRange = [f32::INFINITY, f32::NEG_INFINITY];

/// Ranges of the blocks of a square of cells.
pub(super) struct RangePyramid {
    /// All levels, finest first, each row by row.
    blocks: Vec<BlockRange>,
    /// Of each level from 1 on: where it begins, and its blocks a side.
    levels: Vec<(usize, usize)>,
}

impl RangePyramid {
    /// Of a square of `cells` cells a side, at least 2, given the range of each by row and column.
    pub fn new(cells: usize, cell_range: impl Fn(usize, usize) -> BlockRange) -> Self {
        let mut side = cells.div_ceil(2);
        let mut blocks = halved(cells, cell_range);
        let mut levels = vec![(0, side)];
        while side > 1 {
            let first = blocks.len() - side * side;
            let coarser = halved(side, |row, column| blocks[first + row * side + column]);
            side = side.div_ceil(2);
            levels.push((blocks.len(), side));
            blocks.extend(coarser);
        }
        Self { blocks, levels }
    }

    /// The level whose one block holds all cells.
    pub fn top(&self) -> u32 {
        self.levels.len() as u32
    }

    /// The range of the block of 2^`level` cells a side that holds the cell; `level` from 1 to the
    /// top.
    pub fn range(&self, level: u32, [column, row]: [i32; 2]) -> BlockRange {
        let (first, side) = self.levels[level as usize - 1];
        self.blocks[first + (row >> level) as usize * side + (column >> level) as usize]
    }

    /// Bytes it takes.
    pub fn byte_len(&self) -> u64 {
        size_of_val(self.blocks.as_slice()) as u64
    }
}

/// The ranges of 2 x 2 blocks of a square of `side` a side.
fn halved(side: usize, range: impl Fn(usize, usize) -> BlockRange) -> Vec<BlockRange> {
    let half = side.div_ceil(2);
    let mut blocks = Vec::with_capacity(half * half);
    for (row, column) in (0..half).flat_map(|row| (0..half).map(move |column| (row, column))) {
        let mut block = NO_DATA;
        for (y, x) in [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(y, x)| (2 * row + y, 2 * column + x)) {
            if y < side && x < side {
                block = union(block, range(y, x));
            }
        }
        blocks.push(block);
    }
    blocks
}

/// The range that holds both.
fn union(a: BlockRange, b: BlockRange) -> BlockRange {
    [a[0].min(b[0]), a[1].max(b[1])]
}

/// The range of these heights; those that are NaN hold no data.
pub(super) fn range_of(heights_m: [f32; 4]) -> BlockRange {
    // `min` and `max` leave NaN out.
    heights_m
        .into_iter()
        .fold(NO_DATA, |range, height| [range[0].min(height), range[1].max(height)])
}
