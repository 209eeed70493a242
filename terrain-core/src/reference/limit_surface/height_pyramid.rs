use super::LimitGrid;

/// Lowest and highest height of ever larger blocks of a grid's cells, so that rays skip what they
/// cannot meet. Level 1 holds blocks of 2 x 2 cells, each level after it blocks of twice the side, the
/// last a single block. Blocks without heights hold an empty range.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightPyramid {
    levels: Vec<Level>,
    /// Lowest and highest of all; row-major, level after level.
    ranges: Vec<[f32; 2]>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Level {
    start: usize,
    columns: usize,
    rows: usize,
}

const EMPTY: [f32; 2] = [f32::INFINITY, f32::NEG_INFINITY];

impl HeightPyramid {
    /// Of a grid's heights, one a node, NaN where there is none.
    pub fn new(grid: &LimitGrid, heights_m: &[f32]) -> Self {
        let (mut columns, mut rows) = (grid.columns as usize, grid.rows as usize);
        let mut pyramid = Self { levels: Vec::new(), ranges: Vec::new() };
        while pyramid.levels.is_empty() || columns > 1 || rows > 1 {
            (columns, rows) = (columns.div_ceil(2), rows.div_ceil(2));
            let level = Level { start: pyramid.ranges.len(), columns, rows };
            for index in 0..columns * rows {
                let (row, column) = (index / columns, index % columns);
                let range = match pyramid.levels.last() {
                    None => range_of_nodes(grid, heights_m, row, column),
                    Some(finer) => pyramid.range_of_blocks(finer, row, column),
                };
                pyramid.ranges.push(range);
            }
            pyramid.levels.push(level);
        }
        pyramid
    }

    fn range_of_blocks(&self, finer: &Level, row: usize, column: usize) -> [f32; 2] {
        let mut range = EMPTY;
        for (down, right) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let (row, column) = (2 * row + down, 2 * column + right);
            if row < finer.rows && column < finer.columns {
                range = union(range, self.ranges[finer.start + row * finer.columns + column]);
            }
        }
        range
    }

    /// The coarsest level: one block over everything.
    pub fn top_level(&self) -> u32 {
        self.levels.len() as u32
    }

    /// Lowest and highest height of the block of a level (from 1) that holds a cell.
    pub fn range(&self, level: u32, cell_row: i32, cell_column: i32) -> [f32; 2] {
        let found = &self.levels[level as usize - 1];
        let (row, column) = ((cell_row >> level) as usize, (cell_column >> level) as usize);
        self.ranges[found.start + row * found.columns + column]
    }

    /// Lowest and highest height of all; an empty range where there is none.
    pub fn whole(&self) -> [f32; 2] {
        self.ranges.last().copied().unwrap_or(EMPTY)
    }

    /// Bytes in memory of the ranges of a grid.
    pub fn byte_len_of(grid: &LimitGrid) -> u64 {
        let (mut columns, mut rows) = (u64::from(grid.columns), u64::from(grid.rows));
        let mut ranges = 0;
        while ranges == 0 || columns > 1 || rows > 1 {
            (columns, rows) = (columns.div_ceil(2), rows.div_ceil(2));
            ranges += columns * rows;
        }
        8 * ranges
    }

    /// Bytes in memory.
    pub fn byte_len(&self) -> u64 {
        8 * self.ranges.len() as u64
    }

    /// All ranges, and where each level starts among them with its number of columns, as they go to
    /// the GPU.
    pub fn as_parts(&self) -> (&[[f32; 2]], Vec<[u32; 2]>) {
        let levels = self.levels.iter().map(|level| [level.start as u32, level.columns as u32]);
        (&self.ranges, levels.collect())
    }
}

fn union(a: [f32; 2], b: [f32; 2]) -> [f32; 2] {
    [a[0].min(b[0]), a[1].max(b[1])]
}

/// Range of the nodes around a block of 2 x 2 cells.
fn range_of_nodes(grid: &LimitGrid, heights_m: &[f32], row: usize, column: usize) -> [f32; 2] {
    let last_row = (2 * row + 2).min(grid.rows as usize);
    let last_column = (2 * column + 2).min(grid.columns as usize);
    let mut range = EMPTY;
    for row in 2 * row..=last_row {
        for column in 2 * column..=last_column {
            let height_m = heights_m[grid.node_index(row as u32, column as u32)];
            // `min` and `max` pass over NaN.
            range = [range[0].min(height_m), range[1].max(height_m)];
        }
    }
    range
}
