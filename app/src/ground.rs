//! Heights of the ground straight from a dataset, without a renderer.

use std::cell::RefCell;
use std::collections::HashMap;

use glam::DVec2;
use terrain_core::dataset::{HeightTile, Manifest, TileSource};
use terrain_core::tiling::TileId;

/// Answers questions about the ground at points near one another; keeps the tiles it has read.
pub struct Ground<'a> {
    source: &'a dyn TileSource,
    /// Tiles read so far; `None` for those that cannot be read.
    tiles: RefCell<HashMap<TileId, Option<HeightTile>>>,
}

impl<'a> Ground<'a> {
    /// Heights of the dataset.
    pub fn new(source: &'a dyn TileSource) -> Self {
        Self { source, tiles: RefCell::default() }
    }

    /// Metres above the datum at a point, from the finest tile that has data there; `None` where
    /// there is none, or where the tiles cannot be read.
    pub fn height_m(&self, point: DVec2) -> Option<f64> {
        self.height_about_m(point, 0.0)
    }

    /// The same from samples about so many metres apart: from the coarsest level whose samples are no
    /// farther apart, or the finest there is.
    pub fn height_about_m(&self, point: DVec2, spacing_m: f64) -> Option<f64> {
        let Manifest { scheme, heights, .. } = self.source.manifest();
        let finest = heights.layout.finest_level();
        let is_fine = |level: &u8| heights.layout.texel_size_m(scheme, *level) <= spacing_m;
        let level = (0..finest).find(is_fine).unwrap_or(finest);
        (0..=level).rev().find_map(|level| self.height_at_level_m(level, point))
    }

    fn height_at_level_m(&self, level: u8, point: DVec2) -> Option<f64> {
        let manifest = self.source.manifest();
        let id = manifest.scheme.tile_at(level, point)?;
        if !self.source.heights_present().contains(id) {
            return None;
        }
        let mut tiles = self.tiles.borrow_mut();
        let tile = tiles
            .entry(id)
            .or_insert_with(|| self.source.load_heights(id).ok().map(|loaded| loaded.tile));
        tile.as_ref()?.height_at_m(&manifest.scheme, &manifest.heights.layout, point)
    }
}
