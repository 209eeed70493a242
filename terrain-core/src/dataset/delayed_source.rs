use std::sync::Arc;

use super::{ColourTile, HeightTile, LoadError, Loaded, Manifest, TileSource};
use crate::tiling::{TileId, TileSet};

/// A source whose tiles come so many frames after they were asked for, as from a slow disk or over a
/// network: what that costs, the same on every run.
pub struct DelayedSource {
    /// Where the tiles come from.
    pub source: Arc<dyn TileSource>,
    /// Frames a tile takes.
    pub delay_frames: u32,
}

impl TileSource for DelayedSource {
    fn manifest(&self) -> &Manifest {
        self.source.manifest()
    }

    fn heights_present(&self) -> &TileSet {
        self.source.heights_present()
    }

    fn colours_present(&self) -> &TileSet {
        self.source.colours_present()
    }

    fn load_heights(&self, tile: TileId) -> Result<Loaded<HeightTile>, LoadError> {
        self.source.load_heights(tile)
    }

    fn load_colours(&self, tile: TileId) -> Result<Loaded<ColourTile>, LoadError> {
        self.source.load_colours(tile)
    }

    fn delay_frames(&self) -> u32 {
        self.delay_frames
    }
}
