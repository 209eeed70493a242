use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;
use std::time::Duration;

use super::{CachePlan, Placement, TileCache, TileLoader};
use crate::dataset::{LoadError, Loaded};
use crate::tiling::TileId;

/// One layer on its way from disk to the cache: what is loaded, what waits, what could not be had.
pub struct LayerStream<T: Send + 'static> {
    cache: TileCache,
    loader: TileLoader<Result<Loaded<T>, LoadError>>,
    /// Loaded tiles that wait for their upload.
    ready: HashMap<TileId, T>,
    /// Tiles that cannot be loaded, and why. They are not asked for again: a coarser one shows.
    failed: BTreeMap<TileId, String>,
    upload_bytes: fn(&T) -> u64,
    missing: usize,
}

/// What one frame moves in a layer.
pub struct LayerUpdate<T> {
    /// Tiles to upload now, and where to.
    pub uploads: Vec<(Placement, T)>,
    /// Bytes read from disk since the last frame.
    pub disk_bytes: u64,
    /// Failures since the last frame, in words.
    pub failures: Vec<String>,
}

impl<T: Send + 'static> LayerStream<T> {
    /// A stream into a cache of `columns` x `rows` slots, loading with `threads` workers.
    /// `upload_bytes` tells how many bytes a tile's upload moves.
    ///
    /// # Errors
    /// Where the system gives no thread.
    pub fn new(
        (columns, rows): (u32, u32),
        threads: usize,
        load: Arc<dyn Fn(TileId) -> Result<Loaded<T>, LoadError> + Send + Sync>,
        upload_bytes: fn(&T) -> u64,
    ) -> std::io::Result<Self> {
        Ok(Self {
            cache: TileCache::new(columns, rows),
            loader: TileLoader::new(threads, load)?,
            ready: HashMap::new(),
            failed: BTreeMap::new(),
            upload_bytes,
            missing: 0,
        })
    }

    /// The cache.
    pub fn cache(&self) -> &TileCache {
        &self.cache
    }

    /// Wanted tiles that are not resident yet but will be.
    pub fn missing(&self) -> usize {
        self.missing
    }

    /// The tiles to draw with, and their slots: of each wanted tile itself or, until it is resident,
    /// its finest resident ancestor, and level 0. Other tiles that happen to be resident are left
    /// out: the picture then depends on the view alone, not on the way there, and ground far away
    /// is not drawn from tiles far too fine for it.
    pub fn shown(&self, wanted: &[TileId]) -> Vec<(TileId, u32)> {
        let stand_in = |&tile: &TileId| {
            std::iter::successors(Some(tile), |tile| tile.parent())
                .find_map(|tile| Some((tile, self.cache.slot_of(tile)?)))
        };
        let mut shown =
            wanted.iter().chain([&TileId::ROOT]).filter_map(stand_in).collect::<Vec<_>>();
        shown.sort_unstable();
        shown.dedup();
        shown
    }

    /// Gives the stream a tile that was loaded elsewhere; it waits for its upload.
    pub fn supply(&mut self, tile: TileId, payload: T) {
        self.ready.insert(tile, payload);
    }

    /// Takes what has been loaded, plans the frame and asks for what is missing. Never waits.
    ///
    /// `wanted` is in order of priority; `frame` never falls.
    pub fn update(&mut self, wanted: &[TileId], budget_bytes: u64, frame: u64) -> LayerUpdate<T> {
        let mut update = LayerUpdate { uploads: Vec::new(), disk_bytes: 0, failures: Vec::new() };
        self.take_loaded(&mut update);
        let wanted = wanted
            .iter()
            .copied()
            .filter(|tile| !self.failed.contains_key(tile))
            .collect::<Vec<_>>();
        let (ready, upload_bytes) = (&self.ready, self.upload_bytes);
        let plan = self.cache.plan(
            &wanted,
            &|tile| ready.get(&tile).map(upload_bytes),
            budget_bytes,
            frame,
        );
        self.carry_out(&plan, &mut update);
        update
    }

    /// Waits until everything asked for is loaded, at most for `timeout`.
    pub fn wait(&self, timeout: Duration) {
        self.loader.wait_all(timeout);
    }

    fn take_loaded(&mut self, update: &mut LayerUpdate<T>) {
        for (tile, result) in self.loader.poll() {
            match result {
                Ok(loaded) => {
                    update.disk_bytes += loaded.disk_bytes;
                    self.ready.insert(tile, loaded.tile);
                }
                Err(error) => self.give_up(tile, error.to_string(), update),
            }
        }
        for panic in self.loader.take_panics() {
            self.give_up(panic.tile, panic.to_string(), update);
        }
    }

    fn give_up(&mut self, tile: TileId, reason: String, update: &mut LayerUpdate<T>) {
        update.failures.push(reason.clone());
        self.failed.insert(tile, reason);
    }

    fn carry_out(&mut self, plan: &CachePlan, update: &mut LayerUpdate<T>) {
        for &placement in &plan.uploads {
            // The cache places only tiles it was told are ready.
            if let Some(payload) = self.ready.remove(&placement.tile) {
                update.uploads.push((placement, payload));
            }
        }
        // What is loaded but no longer wanted is dropped; what waits for budget stays.
        self.ready.retain(|tile, _| plan.deferred.contains(tile));
        self.loader.set_wanted(&plan.requests);
        self.missing = plan.missing;
    }
}
