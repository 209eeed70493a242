//! What is known of the ground's height in memory. No GPU.

use std::collections::HashMap;

use glam::{DVec2, DVec3};

use crate::dataset::HeightTile;
use crate::residency::Placement;
use crate::selection::TileTree;
use crate::tiling::TileId;

/// The height tiles that are on the GPU, for questions about the ground.
#[derive(Default)]
pub(crate) struct GroundHeights {
    tiles: HashMap<TileId, HeightTile>,
}

impl GroundHeights {
    /// Keeps the height tiles that have been uploaded, and drops those that made way.
    pub fn keep(&mut self, heights: Vec<(Placement, HeightTile)>) {
        for (placement, tile) in heights {
            if let Some(evicted) = placement.evicted {
                self.tiles.remove(&evicted);
            }
            self.tiles.insert(placement.tile, tile);
        }
    }

    /// Height of the ground in metres above the datum, without exaggeration, from the finest tile that
    /// has data there. `None` outside the data.
    pub fn height_m(&self, tree: &TileTree, point: DVec2) -> Option<f64> {
        let layout = &tree.heights.layout;
        (0..=layout.finest_level()).rev().find_map(|level| {
            let tile = tree.scheme.tile_at(level, point)?;
            self.tiles.get(&tile)?.height_at_m(&tree.scheme, layout, point)
        })
    }

    /// Distance in metres from the eye to the ground below it, heights exaggerated; to the nearest
    /// ground where the eye is not over the data.
    pub fn clearance_m(&self, tree: &TileTree, eye: DVec3, vertical_exaggeration: f64) -> f64 {
        let extent = &tree.data_extent;
        let below = eye.truncate().clamp(extent.min, extent.max);
        let lowest_m = tree.height_ranges.range(TileId::ROOT).map(|r| f64::from(r.min_m));
        let ground_m = self.height_m(tree, below).or(lowest_m).unwrap_or(0.0);
        (eye.z - ground_m * vertical_exaggeration).hypot(eye.truncate().distance(below))
    }
}

/// Lowest and highest ground of the tree in metres, heights exaggerated.
pub(crate) fn height_range_m(tree: &TileTree, vertical_exaggeration: f64) -> [f64; 2] {
    let range = tree.height_ranges.range(TileId::ROOT);
    range
        .map_or([0.0; 2], |range| [range.min_m, range.max_m])
        .map(|height_m| f64::from(height_m) * vertical_exaggeration)
}
