use std::time::Duration;

use super::tile_intake::{Taken, TileIntake};
use super::{CachePlan, Placement, TileCache};
use crate::tiling::TileId;

/// One layer on its way from disk to the cache: what is loaded, what waits, what could not be had.
pub(crate) struct LayerStream<T: Send + 'static> {
    cache: TileCache,
    intake: TileIntake<T>,
    missing: usize,
}

/// What one frame moves in a layer.
pub(crate) struct LayerUpdate<T> {
    /// Tiles to upload now, and where to.
    pub uploads: Vec<(Placement, T)>,
    /// Bytes read from disk since the last frame.
    pub disk_bytes: u64,
    /// Failures since the last frame, in words.
    pub failures: Vec<String>,
}

impl<T: Send + 'static> LayerStream<T> {
    /// A stream of what the intake takes in, into a cache of `columns` x `rows` slots.
    pub fn new((columns, rows): (u32, u32), intake: TileIntake<T>) -> Self {
        Self { cache: TileCache::new(columns, rows), intake, missing: 0 }
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

    /// Takes what has been loaded, plans the frame and asks for what is missing. Never waits.
    ///
    /// `wanted` is in order of priority; `frame` never falls.
    pub fn update(&mut self, wanted: &[TileId], budget_bytes: u64, frame: u64) -> LayerUpdate<T> {
        let Taken { disk_bytes, failures } = self.intake.take_loaded();
        let wanted = wanted
            .iter()
            .copied()
            .filter(|&tile| !self.intake.has_failed(tile))
            .collect::<Vec<_>>();
        let ready = |tile| self.intake.ready_bytes(tile);
        let plan = self.cache.plan(&wanted, &ready, budget_bytes, frame);
        LayerUpdate { uploads: self.carry_out(&plan), disk_bytes, failures }
    }

    /// Waits until everything asked for is loaded, at most for `timeout`.
    pub fn wait(&self, timeout: Duration) {
        self.intake.wait(timeout);
    }

    fn carry_out(&mut self, plan: &CachePlan) -> Vec<(Placement, T)> {
        // The cache places only tiles it was told are ready.
        let upload = |&placement: &Placement| Some((placement, self.intake.take(placement.tile)?));
        let uploads = plan.uploads.iter().filter_map(upload).collect();
        // What is loaded but no longer wanted is dropped; what waits for budget stays.
        self.intake.ask(&plan.requests, |tile| plan.deferred.contains(&tile));
        self.missing = plan.missing;
        uploads
    }
}
