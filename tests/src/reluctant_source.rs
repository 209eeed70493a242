use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use terrain_core::dataset::{ColourTile, HeightTile, LoadError, Loaded, Manifest, TileSource};
use terrain_core::tiling::{TileId, TileSet};

/// A source whose finer tiles come late, or never.
pub struct Reluctant {
    inner: Arc<dyn TileSource>,
    refuses: bool,
    released: AtomicBool,
}

impl Reluctant {
    /// Tiles below level 0 come once they are released, or never where it refuses.
    pub fn new(inner: Arc<dyn TileSource>, refuses: bool) -> Arc<Self> {
        Arc::new(Self { inner, refuses, released: AtomicBool::new(false) })
    }

    /// Lets all tiles go.
    pub fn release(&self) {
        self.released.store(true, Ordering::Release);
    }

    fn hold(&self, tile: TileId) -> Result<(), LoadError> {
        if tile == TileId::ROOT {
            return Ok(());
        }
        if self.refuses {
            let reason = "the disk has failed".to_owned();
            return Err(LoadError::Unreadable { path: "reluctant".into(), tile, reason });
        }
        while !self.released.load(Ordering::Acquire) {
            std::thread::sleep(Duration::from_millis(1));
        }
        Ok(())
    }
}

impl TileSource for Reluctant {
    fn manifest(&self) -> &Manifest {
        self.inner.manifest()
    }

    fn heights_present(&self) -> &TileSet {
        self.inner.heights_present()
    }

    fn colours_present(&self) -> &TileSet {
        self.inner.colours_present()
    }

    fn load_heights(&self, tile: TileId) -> Result<Loaded<HeightTile>, LoadError> {
        self.hold(tile)?;
        self.inner.load_heights(tile)
    }

    fn load_colours(&self, tile: TileId) -> Result<Loaded<ColourTile>, LoadError> {
        self.hold(tile)?;
        self.inner.load_colours(tile)
    }
}
