//! Heights of the ground straight from a dataset, without a renderer.

use std::cell::RefCell;
use std::collections::HashMap;

use glam::DVec2;
use terrain_core::dataset::{HeightTile, TileSource};
use terrain_core::tiling::TileId;

/// Answers questions about the ground at points near one another; keeps the tiles it has read.
pub struct Ground<'a> {
    source: &'a dyn TileSource,
    finest_level: u8,
    /// Tiles read so far; `None` for those that cannot be read.
    tiles: RefCell<HashMap<TileId, Option<HeightTile>>>,
}

impl<'a> Ground<'a> {
    /// Heights of the finest level.
    pub fn finest(source: &'a dyn TileSource) -> Self {
        Self::to_level(source, u8::MAX)
    }

    /// Heights of a level, or of the finest there is.
    pub fn to_level(source: &'a dyn TileSource, level: u8) -> Self {
        let finest_level = source.manifest().heights.layout.finest_level().min(level);
        Self { source, finest_level, tiles: RefCell::default() }
    }

    /// Metres above the datum at a point, from the finest tile that has data there; `None` where
    /// there is none, or where the tiles cannot be read.
    pub fn height_m(&self, point: DVec2) -> Option<f64> {
        (0..=self.finest_level).rev().find_map(|level| self.height_at_level_m(level, point))
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
