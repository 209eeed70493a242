use std::time::Duration;

use super::tile_cache::affordable_uploads;
use super::tile_intake::{Taken, TileIntake};
use super::{Placement, TileInSlot};
use crate::tiling::TileId;

/// One layer on its way from disk into slots that the GPU assigns.
///
/// What the GPU asks for arrives here some frames late, and what is uploaded takes effect there in the
/// frame of the upload. In between the GPU may have given a slot to another tile. That costs an upload
/// at the most and never shows: the GPU takes a tile only if its slot still awaits it, and no slot is
/// written that may show something. The latter holds because a slot awaited its tile in the frame of
/// the list, and only an upload since then can have brought it another; so a list of an earlier frame
/// than a slot's latest upload says nothing about that slot any more.
pub(crate) struct SlotStream<T: Send + 'static> {
    intake: TileIntake<T>,
    /// The latest list of tiles the GPU awaits, most urgent first, and the frame it was made in.
    asked: Vec<TileInSlot>,
    asked_frame: u64,
    missing: usize,
    slots: Vec<SlotUse>,
}

/// What was last brought into a slot, unless it has come into another since, and when.
#[derive(Clone, Copy, Default)]
struct SlotUse {
    tile: Option<TileId>,
    frame: Option<u64>,
}

/// What one frame moves in a layer.
pub(crate) struct SlotUpdate<T> {
    /// Tiles to upload now, and where to.
    pub uploads: Vec<(Placement, T)>,
    /// Tiles the GPU awaits in vain.
    pub failed: Vec<TileInSlot>,
    /// Bytes read from disk since the last frame.
    pub disk_bytes: u64,
    /// Failures since the last frame, in words.
    pub failures: Vec<String>,
}

impl<T: Send + 'static> SlotStream<T> {
    /// A stream of what the intake takes in, into `slot_count` slots. The GPU awaits level 0 in the
    /// first.
    pub fn new(slot_count: u32, intake: TileIntake<T>) -> Self {
        Self {
            intake,
            asked: vec![TileInSlot::new(TileId::ROOT, 0)],
            asked_frame: 0,
            missing: 1,
            slots: vec![SlotUse::default(); slot_count as usize],
        }
    }

    /// Takes the list of the tiles that the GPU awaited in a frame, most urgent first, and how many it
    /// missed in all. Lists come in the order of their frames.
    pub fn receive(&mut self, asked: Vec<TileInSlot>, missing: usize, frame: u64) {
        (self.asked, self.asked_frame, self.missing) = (asked, frame, missing);
    }

    /// Wanted tiles that were not resident in the frame of the latest list but will be.
    pub fn missing(&self) -> usize {
        self.missing
    }

    /// Takes what has been loaded, hands out what is to be uploaded now within the budget (the first
    /// tile whatever its size) and asks for the rest. Never waits. `frame` rises.
    pub fn update(&mut self, budget_bytes: u64, frame: u64) -> SlotUpdate<T> {
        let Taken { disk_bytes, failures } = self.intake.take_loaded();
        let open = self.open();
        let (failed, to_come): (Vec<_>, Vec<_>) =
            open.into_iter().partition(|asked| self.intake.has_failed(asked.tile()));
        let (mut waiting, mut requests) = (Vec::new(), Vec::new());
        for asked in to_come {
            match self.intake.ready_bytes(asked.tile()) {
                Some(bytes) => waiting.push((asked, bytes)),
                None => requests.push(asked.tile()),
            }
        }
        let deferred = waiting.split_off(affordable_uploads(&waiting, budget_bytes));
        let uploads = waiting.into_iter().filter_map(|(asked, _)| self.upload(asked, frame));
        let uploads = uploads.collect();
        for asked in &failed {
            self.slots[asked.slot() as usize].frame = Some(frame);
        }
        self.intake.ask(&requests, |tile| deferred.iter().any(|(asked, _)| asked.tile() == tile));
        SlotUpdate { uploads, failed, disk_bytes, failures }
    }

    /// Waits until everything asked for is loaded, at most for `timeout`.
    pub fn wait(&self, timeout: Duration) {
        self.intake.wait(timeout);
    }

    /// The tiles of the list that are still awaited as far as is known here.
    fn open(&self) -> Vec<TileInSlot> {
        let is_open = |asked: &&TileInSlot| {
            let slot = self.slots.get(asked.slot() as usize);
            slot.is_some_and(|slot| slot.frame.is_none_or(|frame| frame <= self.asked_frame))
        };
        self.asked.iter().filter(is_open).copied().collect()
    }

    fn upload(&mut self, asked: TileInSlot, frame: u64) -> Option<(Placement, T)> {
        let (tile, slot) = (asked.tile(), asked.slot());
        let payload = self.intake.take(tile)?;
        // The tile may have lost a slot before this one.
        for used in self.slots.iter_mut().filter(|used| used.tile == Some(tile)) {
            used.tile = None;
        }
        let used = &mut self.slots[slot as usize];
        let evicted = std::mem::replace(used, SlotUse { tile: Some(tile), frame: Some(frame) });
        Some((Placement { tile, slot, evicted: evicted.tile }, payload))
    }
}
