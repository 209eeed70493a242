use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

use terrain_core::dataset::{ColourTile, HeightTile, LoadError, Loaded, Manifest, TileSource};
use terrain_core::tiling::{TileId, TileSet};

/// A source that makes each tile of another once: for cases that draw the same ground again and again.
pub struct Remembering<S> {
    inner: S,
    heights: Memory<HeightTile>,
    colours: Memory<ColourTile>,
}

impl<S: TileSource> Remembering<S> {
    /// The same tiles as `inner` has.
    pub fn new(inner: S) -> Self {
        Self { inner, heights: Memory::default(), colours: Memory::default() }
    }
}

impl<S: TileSource> TileSource for Remembering<S> {
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
        self.heights.tile(tile, || self.inner.load_heights(tile))
    }

    fn load_colours(&self, tile: TileId) -> Result<Loaded<ColourTile>, LoadError> {
        self.colours.tile(tile, || self.inner.load_colours(tile))
    }
}

/// The tiles of a layer that have been made.
struct Memory<T>(Mutex<HashMap<TileId, Loaded<T>>>);

impl<T> Default for Memory<T> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<T: Clone> Memory<T> {
    fn tile(
        &self,
        tile: TileId,
        make: impl FnOnce() -> Result<Loaded<T>, LoadError>,
    ) -> Result<Loaded<T>, LoadError> {
        // A failed case must not fail the others: what the map holds is whole at any time.
        let tiles = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = tiles().get(&tile) {
            return Ok(known.clone());
        }
        let made = make()?;
        tiles().insert(tile, made.clone());
        Ok(made)
    }
}
