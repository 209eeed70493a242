use std::collections::HashSet;

use super::sort_keys::PriorityOrder;
use super::{LayerTree, TileTree};
use crate::tiling::TileId;

/// The tiles a view is to be drawn with.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Selection {
    /// The tiles in order of priority: coarsest level first, within a level nearest first, at equal
    /// distance by row and column. Level 0 is always the first.
    pub tiles: Vec<TileId>,
    /// How the selection came about.
    pub statistics: SelectionStatistics,
}

/// Counts of the stages of a selection; 0 where a strategy has no such stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SelectionStatistics {
    /// Tiles on the list after subdivision.
    pub subdivided: usize,
    /// Tiles the first regularisation took off the list.
    pub regularized_away: usize,
    /// Merges of a farthest tile.
    pub merges: usize,
    /// Tiles subdivision left out because no pixel saw them, though the box round all that was seen
    /// holds them.
    pub hidden: usize,
    /// Finest level of the selection.
    pub finest_level: u8,
}

impl Selection {
    /// The selection of these tiles, each once and level 0 among them: puts them in order and fills
    /// in the finest level.
    pub(super) fn in_order(mut keys: Vec<PriorityOrder>, statistics: SelectionStatistics) -> Self {
        keys.sort_unstable();
        let tiles: Vec<_> = keys.into_iter().map(PriorityOrder::tile).collect();
        let finest_level = tiles.last().map_or(0, |tile| tile.level);
        Self { tiles, statistics: SelectionStatistics { finest_level, ..statistics } }
    }

    /// The height tiles to draw the selection with, in its order; see [`Selection::colour_tiles`].
    pub fn height_tiles(&self, tree: &TileTree) -> Vec<TileId> {
        self.tiles_of_layer(&tree.heights)
    }

    /// The colour tiles to draw the selection with, in its order: for each tile itself or its
    /// finest ancestor that exists in the layer, each once. Empty without a colour layer.
    pub fn colour_tiles(&self, tree: &TileTree) -> Vec<TileId> {
        tree.colours.as_ref().map_or_else(Vec::new, |layer| self.tiles_of_layer(layer))
    }

    fn tiles_of_layer(&self, layer: &LayerTree) -> Vec<TileId> {
        let mut seen = HashSet::with_capacity(self.tiles.len());
        let existing = |&tile: &TileId| {
            let deepest = tile.ancestor_at(layer.layout.finest_level());
            std::iter::successors(Some(deepest), |tile| tile.parent())
                .find(|&ancestor| layer.present.contains(ancestor))
        };
        self.tiles.iter().filter_map(existing).filter(|&tile| seen.insert(tile)).collect()
    }
}
