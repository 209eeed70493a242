use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;
use serde::Serialize;

use super::{Dataset, LoadError, TileSource};
use crate::progress::Progress;
use crate::tiling::{TileId, TileSet};

/// What a dataset's archives hold, counted tile by tile.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Inspection {
    /// The height layer's levels, coarsest first.
    pub heights: Vec<LevelInspection>,
    /// The colour layer's levels; empty without a colour layer.
    pub colours: Vec<LevelInspection>,
    /// Whether every tile was read and decoded.
    pub verified: bool,
    /// One line for each tile that could not be read or decoded.
    pub faults: Vec<String>,
}

/// The tiles of one level.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct LevelInspection {
    /// The level.
    pub level: u8,
    /// Tiles stored.
    pub tiles: u64,
    /// Bytes of their payloads, identical ones counted each time.
    pub disk_bytes: u64,
}

impl Dataset {
    /// Counts tiles and bytes by level. With `verify` every tile is decoded as well, which checks
    /// its checksum and its form. `progress` hears of the tiles of each layer.
    pub fn inspect(&self, verify: bool, progress: &dyn Progress) -> Inspection {
        let mut faults = Vec::new();
        let layer = ("heights", self.heights_present());
        let heights = inspect_layer(layer, progress, &mut faults, |tile| match verify {
            true => self.load_heights(tile).map(|loaded| loaded.disk_bytes),
            false => self.height_payload_len(tile),
        });
        let layer = ("colours", self.colours_present());
        let colours = inspect_layer(layer, progress, &mut faults, |tile| match verify {
            true => self.load_colours(tile).map(|loaded| loaded.disk_bytes),
            false => self.colour_payload_len(tile),
        });
        Inspection { heights, colours, verified: verify, faults }
    }
}

fn inspect_layer(
    (name, present): (&str, &TileSet),
    progress: &dyn Progress,
    faults: &mut Vec<String>,
    bytes_of: impl Fn(TileId) -> Result<u64, LoadError> + Sync,
) -> Vec<LevelInspection> {
    let tiles: Vec<_> = present.iter().collect();
    let done = AtomicU64::new(0);
    let look_at = |&tile: &TileId| {
        let bytes = bytes_of(tile);
        progress.advanced(name, done.fetch_add(1, Ordering::Relaxed) + 1, present.len());
        (tile, bytes)
    };
    let found: Vec<_> = tiles.par_iter().map(look_at).collect();
    let mut levels: Vec<LevelInspection> = Vec::new();
    for (tile, bytes) in found {
        if levels.last().is_none_or(|last| last.level != tile.level) {
            levels.push(LevelInspection { level: tile.level, tiles: 0, disk_bytes: 0 });
        }
        match (bytes, levels.last_mut()) {
            (Ok(bytes), Some(last)) => {
                last.tiles += 1;
                last.disk_bytes += bytes;
            }
            (Err(error), _) => faults.push(error.to_string()),
            (Ok(_), None) => {}
        }
    }
    levels
}
