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
