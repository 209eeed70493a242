use std::cmp::Reverse;

use crate::tiling::{FixedPosition, TileId};

/// The table that finds the finest resident tile at a point.
///
/// The tile offset table of Liu Hao et al., "Dynamic Scheduling and Real-time Rendering Method for
/// Large-Scale Terrain", section 3.2: the resident tiles, finest level first, searched from the top;
/// the first tile that contains the point is the finest. [`OffsetTable::find_linear`] is that search.
///
/// Beside it stands a quadtree over the same tiles for [`OffsetTable::find_descend`], which takes a
/// step a level instead of one a tile. Four words a node, for the children in the order north-west,
/// north-east, south-west, south-east; a word holds
/// * in its low 16 bits the index of the child's own node, 0 where no finer tile is resident (node 0
///   is the root's, and nobody's child);
/// * in its high 16 bits the child's index in `entries` plus 1, 0 where it is not resident itself.
///
/// Positions are fixed-point integers, so CPU and GPU find the same tile, bit for bit.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct OffsetTable {
    /// Resident tiles, finest level first, within a level by row and column.
    pub entries: Vec<OffsetEntry>,
    /// The quadtree: node `n` is `nodes[4 * n..4 * n + 4]`. Node 0 always exists.
    pub nodes: Vec<u32>,
    /// The root's own word: like a child's, with node 0 as its node.
    pub root_word: u32,
}

/// A resident tile and where it lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OffsetEntry {
    /// The tile: by the tiling scheme its position and extent, formula (1) of the paper.
    pub tile: TileId,
    /// Its slot, counted row by row from 0: with [`slot_origin_texels`] formula (2) of the paper.
    pub slot: u32,
}

/// Entries and nodes a table can hold at the most: 16 bits less the value that stands for none.
const COUNT_MAX: usize = u16::MAX as usize;

impl OffsetTable {
    /// Builds the table of these tiles and their slots, in any order.
    ///
    /// Indices have 16 bits: of more tiles than fit (65,535 of them, or of nodes above them) the
    /// finest are left out, and their ground shows the next coarser tile. Of a tile named twice the
    /// lower slot counts.
    pub fn build(residents: impl IntoIterator<Item = (TileId, u32)>) -> Self {
        let mut entries: Vec<_> =
            residents.into_iter().map(|(tile, slot)| OffsetEntry { tile, slot }).collect();
        entries.sort_unstable_by_key(|entry| (entry.tile, entry.slot));
        entries.dedup_by_key(|entry| entry.tile);
        let mut table = Self { entries: Vec::new(), nodes: vec![0; 4], root_word: 0 };
        // Coarsest first, so that what does not fit is the finest.
        entries.retain(|entry| table.reserve_path(entry.tile));
        entries.truncate(COUNT_MAX);
        entries.sort_by_key(|entry| (Reverse(entry.tile.level), entry.tile));
        for (number, entry) in (1_u32..).zip(&entries) {
            *table.word_mut(entry.tile) |= number << 16;
        }
        table.entries = entries;
        table
    }

    /// The finest resident tile at the point, by the paper's search from the top of the table.
    /// `None` outside the root, or where no resident tile covers the point.
    pub fn find_linear(&self, position: FixedPosition) -> Option<usize> {
        self.entries.iter().position(|entry| position.tile_at(entry.tile.level) == Some(entry.tile))
    }

    /// The same tile as [`OffsetTable::find_linear`], found by descending the quadtree.
    pub fn find_descend(&self, position: FixedPosition) -> Option<usize> {
        if !position.is_in_root() {
            return None;
        }
        let mut found = self.root_word >> 16;
        let mut node = 0;
        // A node exists only above a tile, and none is finer than 30 levels.
        for shift in (0..30).rev() {
            let quadrant = ((position.y >> shift) & 1) * 2 + ((position.x >> shift) & 1);
            let word = self.nodes[4 * node + quadrant as usize];
            if word >> 16 != 0 {
                found = word >> 16;
            }
            node = (word & 0xffff) as usize;
            if node == 0 {
                break;
            }
        }
        (found as usize).checked_sub(1)
    }

    /// Makes the nodes above the tile; returns whether there was room for them.
    fn reserve_path(&mut self, tile: TileId) -> bool {
        let mut node = 0;
        for level in 1..tile.level {
            let index = 4 * node + tile.ancestor_at(level).quadrant() as usize;
            if self.nodes[index] == 0 {
                let new = self.nodes.len() / 4;
                if new > COUNT_MAX {
                    return false;
                }
                self.nodes[index] = new as u32;
                self.nodes.extend([0; 4]);
            }
            node = self.nodes[index] as usize;
        }
        true
    }

    /// The word of a tile whose path is reserved.
    fn word_mut(&mut self, tile: TileId) -> &mut u32 {
        if tile.level == 0 {
            return &mut self.root_word;
        }
        let mut node = 0;
        for level in 1..tile.level {
            let index = 4 * node + tile.ancestor_at(level).quadrant() as usize;
            node = (self.nodes[index] & 0xffff) as usize;
        }
        &mut self.nodes[4 * node + tile.quadrant() as usize]
    }
}

/// First texel (x to the right, y down) of a slot in an atlas of `columns` slots across, each
/// `stored_size_texels` a side. Formula (2) of the paper, in texels instead of fractions. `columns`
/// of 0 is taken as 1.
pub fn slot_origin_texels(slot: u32, columns: u32, stored_size_texels: u32) -> [u32; 2] {
    let columns = columns.max(1);
    [slot % columns * stored_size_texels, slot / columns * stored_size_texels]
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::tiling::{FIXED_UNITS_PER_ROOT, MAX_LEVEL};

    /// The tile of a level that holds the point given by two fractions of the root.
    fn tile_of(level: u8, east: f64, south: f64) -> TileId {
        FixedPosition::from_root_fraction(east, south).tile_at(level).unwrap()
    }

    fn any_tile() -> impl Strategy<Value = TileId> {
        // Half of the tiles crowd round one point, so that many lie within one another.
        let near = (0..=MAX_LEVEL, 0.3..0.3001, 0.7..0.7001);
        let anywhere = (0..=6u8, 0.0..0.999, 0.0..0.999);
        prop_oneof![near, anywhere].prop_map(|(level, east, south)| tile_of(level, east, south))
    }

    /// Points in and around the root, on tile borders and among the crowded tiles.
    fn any_position() -> impl Strategy<Value = FixedPosition> {
        let fraction = |range: std::ops::Range<f64>| (range.clone(), range);
        let grid = (-1i32..=64).prop_map(|i| i << 24);
        prop_oneof![
            fraction(-2.1..2.1).prop_map(|(x, y)| FixedPosition::from_root_fraction(x, y)),
            (0.3..0.3001, 0.7..0.7001).prop_map(|(x, y)| FixedPosition::from_root_fraction(x, y)),
            (grid.clone(), grid).prop_map(|(x, y)| FixedPosition { x, y }),
        ]
    }

    proptest! {
        #[test]
        fn both_searches_find_the_finest_tile_at_a_point(
            tiles in prop::collection::vec(any_tile(), 0..80),
            positions in prop::collection::vec(any_position(), 50),
        ) {
            let table = OffsetTable::build(tiles.iter().copied().zip(0u32..));
            for position in positions {
                let size = |tile: &TileId| FIXED_UNITS_PER_ROOT >> tile.level;
                let holds = |tile: &&TileId| {
                    let (west, north) = (tile.column as i32 * size(tile), tile.row as i32 * size(tile));
                    (west..west + size(tile)).contains(&position.x)
                        && (north..north + size(tile)).contains(&position.y)
                };
                let finest = tiles.iter().filter(holds).max_by_key(|tile| tile.level).copied();
                let found = |index: Option<usize>| index.map(|index| table.entries[index].tile);
                prop_assert_eq!(found(table.find_linear(position)), finest);
                prop_assert_eq!(table.find_linear(position), table.find_descend(position));
            }
        }

        #[test]
        fn entries_are_the_residents_finest_first(
            tiles in prop::collection::btree_set(any_tile(), 0..60),
        ) {
            let table = OffsetTable::build(tiles.iter().copied().zip(100u32..));
            prop_assert_eq!(table.entries.len(), tiles.len());
            prop_assert!(table.entries.is_sorted_by_key(|e| (Reverse(e.tile.level), e.tile)));
            for (tile, slot) in tiles.into_iter().zip(100u32..) {
                let entry = OffsetEntry { tile, slot };
                prop_assert!(table.entries.contains(&entry));
            }
        }
    }

    #[test]
    fn an_empty_table_finds_nothing() {
        let table = OffsetTable::build([]);
        let middle = FixedPosition::from_root_fraction(0.5, 0.5);
        assert_eq!((table.find_linear(middle), table.find_descend(middle)), (None, None));
        assert_eq!(table.nodes, [0; 4]);
    }

    #[test]
    fn the_words_are_laid_out_as_stated() {
        let south_west = TileId::new(1, 1, 0);
        let inner = TileId::new(3, 5, 2);
        let table = OffsetTable::build([(TileId::ROOT, 4), (inner, 7), (south_west, 9)]);
        let slots: Vec<_> = table.entries.iter().map(|entry| entry.slot).collect();
        assert_eq!(slots, [7, 9, 4], "finest first");
        assert_eq!(table.root_word, 3 << 16);
        // Node 0: only the south-west child, the second entry, with node 1. Tile 3/5/2 is the
        // south-west child of 2/2/1, the north-east child of 1/1/0.
        assert_eq!(table.nodes, [0, 0, 2 << 16 | 1, 0, 0, 2, 0, 0, 0, 0, 1 << 16, 0]);
    }

    #[test]
    fn what_does_not_fit_is_left_out_from_the_finest_on() {
        let whole = |level: u8| {
            (0..1_u32 << (2 * level))
                .map(move |i| TileId::new(level, i >> level, i & ((1 << level) - 1)))
        };
        let table = OffsetTable::build(whole(7).chain(whole(8)).chain([TileId::ROOT]).zip(0u32..));
        assert_eq!(table.entries.len(), COUNT_MAX);
        let coarse = table.entries.iter().filter(|entry| entry.tile.level < 8).count();
        assert_eq!(coarse, 1 + 128 * 128);
        check_agreement(&table);

        // Every tile of the finest level needs a path of its own: the nodes run out.
        let lonely = whole(6).map(|tile| {
            TileId::new(MAX_LEVEL, (tile.row << 18) + 12_345, (tile.column << 18) + 54_321)
        });
        let table = OffsetTable::build(whole(6).chain(lonely).zip(0u32..));
        assert!(table.nodes.len() <= 4 * (COUNT_MAX + 1));
        assert_eq!(table.entries.iter().filter(|entry| entry.tile.level == 6).count(), 64 * 64);
        assert!(table.entries.len() > 64 * 64 && table.entries.len() < 2 * 64 * 64);
        check_agreement(&table);
    }

    fn check_agreement(table: &OffsetTable) {
        for entry in table.entries.iter().step_by(97) {
            let size = FIXED_UNITS_PER_ROOT >> entry.tile.level;
            let (x, y) = (entry.tile.column as i32 * size, entry.tile.row as i32 * size);
            let position = FixedPosition { x, y };
            assert_eq!(table.find_linear(position), table.find_descend(position), "{entry:?}");
        }
    }

    #[test]
    fn slots_are_counted_row_by_row() {
        assert_eq!(slot_origin_texels(0, 6, 136), [0, 0]);
        assert_eq!(slot_origin_texels(5, 6, 136), [680, 0]);
        assert_eq!(slot_origin_texels(20, 6, 136), [272, 408]);
        assert_eq!(slot_origin_texels(3, 0, 8), [0, 24]);
    }
}
