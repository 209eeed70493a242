use std::collections::HashSet;

use super::{
    LayerTree, SelectionConfig, TileTree, VisibleRegion, merge_farthest, regularize, subdivide,
};
use crate::CameraView;
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

/// Counts of the stages of a selection.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SelectionStatistics {
    /// Tiles on the list after subdivision.
    pub subdivided: usize,
    /// Tiles the first regularisation took off the list.
    pub regularized_away: usize,
    /// Merges of a farthest tile.
    pub merges: usize,
    /// Finest level of the selection.
    pub finest_level: u8,
}

/// Steps 2 to 4 of the paper's tile selection, in its order: subdivision, regularisation, merging.
///
/// The region comes from [`visible_region()`](super::visible_region()), and may be that of a view some
/// frames old; without one (an empty view) the selection is level 0. See [`subdivide()`],
/// [`regularize()`] and [`merge_farthest()`] for what each does and where it departs from the paper.
pub fn select(
    tree: &TileTree,
    region: Option<&VisibleRegion>,
    view: &CameraView,
    config: &SelectionConfig,
) -> Selection {
    let mut list = subdivide(tree, region, view, config);
    let subdivided = list.len();
    let regularized_away = regularize(&mut list);
    let merges = merge_farthest(&mut list, config.max_tiles);
    let tiles = list.by_priority();
    let finest_level = tiles.last().map_or(0, |tile| tile.level);
    let statistics = SelectionStatistics { subdivided, regularized_away, merges, finest_level };
    Selection { tiles, statistics }
}

impl Selection {
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
