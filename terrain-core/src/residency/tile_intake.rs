use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;
use std::time::Duration;

use super::{Loading, TileLoader};
use crate::dataset::{LoadError, Loaded};
use crate::tiling::TileId;

/// The tiles of one layer between the disk and their upload: what is being loaded, what waits, what
/// could not be had.
pub(crate) struct TileIntake<T: Send + 'static> {
    loader: TileLoader<Result<Loaded<T>, LoadError>>,
    /// Loaded tiles that wait for their upload.
    ready: HashMap<TileId, T>,
    /// Tiles that cannot be loaded, and why. They are not asked for again: a coarser one shows.
    failed: BTreeMap<TileId, String>,
    upload_bytes: fn(&T) -> u64,
}

/// What has come since the last look.
#[derive(Default)]
pub(crate) struct Taken {
    /// Bytes read from disk.
    pub disk_bytes: u64,
    /// Failures in words.
    pub failures: Vec<String>,
}

impl<T: Send + 'static> TileIntake<T> {
    /// An intake. `upload_bytes` tells how many bytes a tile's upload moves.
    ///
    /// # Errors
    /// Where the system gives no thread.
    pub fn new(
        loading: Loading,
        load: Arc<dyn Fn(TileId) -> Result<Loaded<T>, LoadError> + Send + Sync>,
        upload_bytes: fn(&T) -> u64,
    ) -> std::io::Result<Self> {
        let loader = TileLoader::new(loading, load)?;
        Ok(Self { loader, ready: HashMap::new(), failed: BTreeMap::new(), upload_bytes })
    }

    /// Takes a tile that was loaded elsewhere.
    pub fn supply(&mut self, tile: TileId, payload: T) {
        self.ready.insert(tile, payload);
    }

    /// Takes what has been loaded. Never waits.
    pub fn take_loaded(&mut self) -> Taken {
        let mut taken = Taken::default();
        for (tile, result) in self.loader.poll() {
            match result {
                Ok(loaded) => {
                    taken.disk_bytes += loaded.disk_bytes;
                    self.ready.insert(tile, loaded.tile);
                }
                Err(error) => self.give_up(tile, error.to_string(), &mut taken),
            }
        }
        for panic in self.loader.take_panics() {
            self.give_up(panic.tile, panic.to_string(), &mut taken);
        }
        taken
    }

    fn give_up(&mut self, tile: TileId, reason: String, taken: &mut Taken) {
        taken.failures.push(reason.clone());
        self.failed.insert(tile, reason);
    }

    /// Whether the tile cannot be had.
    pub fn has_failed(&self, tile: TileId) -> bool {
        self.failed.contains_key(&tile)
    }

    /// The bytes a tile's upload moves, if it is loaded and waiting.
    pub fn ready_bytes(&self, tile: TileId) -> Option<u64> {
        self.ready.get(&tile).map(self.upload_bytes)
    }

    /// Hands out a waiting tile.
    pub fn take(&mut self, tile: TileId) -> Option<T> {
        self.ready.remove(&tile)
    }

    /// Hands out all waiting tiles, in order of their ids.
    pub fn take_all(&mut self) -> BTreeMap<TileId, T> {
        self.ready.drain().collect()
    }

    /// Drops the waiting tiles that are not to be kept, and asks for these instead of what was asked
    /// for before, most urgent first.
    pub fn ask(&mut self, requests: &[TileId], is_kept: impl Fn(TileId) -> bool) {
        self.ready.retain(|&tile, _| is_kept(tile));
        self.loader.set_wanted(requests);
    }

    /// Waits until everything asked for is loaded, at most for `timeout`.
    pub fn wait(&self, timeout: Duration) {
        self.loader.wait_all(timeout);
    }
}
