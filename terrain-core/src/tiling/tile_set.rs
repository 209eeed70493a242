use std::collections::BTreeMap;

use super::TileId;

/// Which tiles exist: a set of ids kept as runs of columns per row, so that full rows cost one entry.
///
/// Memory is proportional to the number of *runs*, not of tiles: a dense level costs one run a row.
/// The coarse levels are kept as bits as well (at most 2.8 MB), since selection asks for them most.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TileSet {
    /// (level, row) -> disjoint, sorted, non-adjacent column runs `first..=last`.
    rows: BTreeMap<(u8, u32), Vec<(u32, u32)>>,
    /// Of each level up to [`BIT_LEVEL_MAX`] a bit a tile, row by row; empty where the level is.
    bits: Vec<Vec<u64>>,
    len: u64,
}

/// The finest level kept as bits: 2^24 tiles, 2 MB; with tiles of 128 texels, 2^19 texels a side.
const BIT_LEVEL_MAX: u8 = 12;

/// Word and bit of a tile within its level.
fn bit_of(tile: TileId) -> (usize, u64) {
    let index = ((tile.row as usize) << tile.level) + tile.column as usize;
    (index / 64, 1 << (index % 64))
}

impl TileSet {
    /// An empty set.
    pub fn new() -> Self {
        Self::default()
    }

    /// Every tile of levels `0..level_count`: what a raster that fills its root has. Takes time and memory
    /// by the rows, not by the tiles.
    pub fn full(level_count: u8) -> Self {
        let mut set = Self::new();
        for level in 0..level_count {
            let side = 1_u32 << level;
            set.rows.extend((0..side).map(|row| ((level, row), vec![(0, side - 1)])));
            let tiles = u64::from(side) * u64::from(side);
            set.len += tiles;
            if level <= BIT_LEVEL_MAX {
                let last_word = if tiles < 64 { (1 << tiles) - 1 } else { u64::MAX };
                set.bits.push(vec![last_word; tiles.div_ceil(64) as usize]);
            }
        }
        set
    }

    /// Number of tiles in the set.
    pub fn len(&self) -> u64 {
        self.len
    }

    /// Whether the set holds no tile.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Whether the tile is in the set.
    pub fn contains(&self, tile: TileId) -> bool {
        if tile.level <= BIT_LEVEL_MAX {
            let (word, bit) = bit_of(tile);
            let words = self.bits.get(usize::from(tile.level));
            return words.and_then(|words| words.get(word)).is_some_and(|word| word & bit != 0);
        }
        self.rows.get(&(tile.level, tile.row)).is_some_and(|runs| {
            let after = runs.partition_point(|run| run.0 <= tile.column);
            after > 0 && runs[after - 1].1 >= tile.column
        })
    }

    /// Adds the tile; returns whether it was new.
    pub fn insert(&mut self, tile: TileId) -> bool {
        let runs = self.rows.entry((tile.level, tile.row)).or_default();
        let column = tile.column;
        let after = runs.partition_point(|run| run.0 <= column);
        if after > 0 && runs[after - 1].1 >= column {
            return false;
        }
        let joins_left = after > 0 && runs[after - 1].1 + 1 == column;
        let joins_right = after < runs.len() && column + 1 == runs[after].0;
        match (joins_left, joins_right) {
            (true, true) => {
                runs[after - 1].1 = runs[after].1;
                runs.remove(after);
            }
            (true, false) => runs[after - 1].1 = column,
            (false, true) => runs[after].0 = column,
            (false, false) => runs.insert(after, (column, column)),
        }
        self.len += 1;
        self.set_bit(tile);
        true
    }

    /// Adds all tiles of a row from the first to the last column.
    pub fn insert_run(&mut self, level: u8, row: u32, (first, last): (u32, u32)) {
        let runs = self.rows.entry((level, row)).or_default();
        let start = runs.partition_point(|run| run.1.saturating_add(1) < first);
        let end = runs.partition_point(|run| run.0 <= last.saturating_add(1)).max(start);
        let tiles = |run: (u32, u32)| u64::from(run.1 - run.0) + 1;
        let joined = runs[start..end]
            .iter()
            .fold((first, last), |joined, run| (joined.0.min(run.0), joined.1.max(run.1)));
        let before: u64 = runs[start..end].iter().copied().map(tiles).sum();
        runs.splice(start..end, [joined]);
        self.len += tiles(joined) - before;
        if level <= BIT_LEVEL_MAX {
            (first..=last).for_each(|column| self.set_bit(TileId::new(level, row, column)));
        }
    }

    fn set_bit(&mut self, tile: TileId) {
        let level = usize::from(tile.level);
        if tile.level > BIT_LEVEL_MAX {
            return;
        }
        if self.bits.len() <= level {
            self.bits.resize(level + 1, Vec::new());
        }
        let words = &mut self.bits[level];
        if words.is_empty() {
            words.resize((1_usize << (2 * level)).div_ceil(64), 0);
        }
        let (word, bit) = bit_of(tile);
        words[word] |= bit;
    }

    /// The set as runs of neighbouring tiles: level, row, and the first and last column of each run, in
    /// the order of the tiles.
    pub fn runs(&self) -> impl Iterator<Item = (u8, u32, (u32, u32))> + '_ {
        self.rows
            .iter()
            .flat_map(|(&(level, row), runs)| runs.iter().map(move |&run| (level, row, run)))
    }

    /// Every tile, coarsest level first, then by row and column.
    pub fn iter(&self) -> impl Iterator<Item = TileId> + '_ {
        self.rows.iter().flat_map(|(&(level, row), runs)| {
            runs.iter().flat_map(move |&(first, last)| {
                (first..=last).map(move |column| TileId::new(level, row, column))
            })
        })
    }
}

impl FromIterator<TileId> for TileSet {
    fn from_iter<I: IntoIterator<Item = TileId>>(tiles: I) -> Self {
        let mut set = Self::new();
        for tile in tiles {
            set.insert(tile);
        }
        set
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use proptest::prelude::*;

    use super::*;

    #[test]
    fn a_full_set_holds_every_tile() {
        let count = BIT_LEVEL_MAX - 4;
        let tiles = (0..count).flat_map(|level| {
            let side = 1_u32 << level;
            (0..side * side).map(move |i| TileId::new(level, i / side, i % side))
        });
        assert_eq!(TileSet::full(count), tiles.collect());
        assert_eq!(TileSet::full(0), TileSet::new());
        let deep = TileSet::full(BIT_LEVEL_MAX + 2);
        assert_eq!(deep.len(), (4_u64.pow(u32::from(BIT_LEVEL_MAX) + 2) - 1) / 3);
        let last = (1 << (BIT_LEVEL_MAX + 1)) - 1;
        assert!(deep.contains(TileId::new(BIT_LEVEL_MAX + 1, last, last)));
        assert!(!deep.contains(TileId::new(BIT_LEVEL_MAX + 2, 0, 0)));
    }

    proptest! {
        #[test]
        fn behaves_like_a_plain_set(
            ids in prop::collection::vec((0u32..4, 0u32..16), 0..120),
            level in prop_oneof![Just(4u8), Just(BIT_LEVEL_MAX), Just(BIT_LEVEL_MAX + 1)],
        ) {
            let plain: BTreeSet<_> = ids.iter().map(|&(r, c)| TileId::new(level, r, c)).collect();
            let set: TileSet = ids.iter().map(|&(r, c)| TileId::new(level, r, c)).collect();
            prop_assert_eq!(set.iter().collect::<Vec<_>>(), plain.iter().copied().collect::<Vec<_>>());
            prop_assert_eq!(set.len(), plain.len() as u64);
            let mut by_runs = TileSet::new();
            for (index, tile) in plain.iter().enumerate() {
                // Some runs overlap what is there, some join two.
                let last = (tile.column + 1).min(15);
                if index % 2 == 0 && plain.contains(&TileId { column: last, ..*tile }) {
                    by_runs.insert_run(tile.level, tile.row, (tile.column, last));
                } else {
                    by_runs.insert_run(tile.level, tile.row, (tile.column, tile.column));
                }
            }
            prop_assert_eq!(&by_runs, &set);
            for row in 0..4 {
                for column in 0..16 {
                    let tile = TileId::new(level, row, column);
                    prop_assert_eq!(set.contains(tile), plain.contains(&tile));
                }
            }
        }
    }
}
