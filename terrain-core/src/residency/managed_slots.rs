//! What `manage_tiles.wgsl` does to the slots of one layer, rule by rule, and what holds of it together
//! with [`SlotStream`].

use std::cmp::Reverse;
use std::collections::{HashMap, VecDeque};
use std::sync::Arc;
use std::time::Duration;

use proptest::prelude::*;

use super::{Loading, SlotStream, TileCache, TileInSlot, TileIntake};
use crate::dataset::{LoadError, Loaded};
use crate::tiling::TileId;

/// Tiles that are asked for at a time.
pub(crate) const MOST_ASKED: usize = 32;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SlotState {
    Reserved,
    Failed,
    Resident,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct HeldTile {
    pub tile: TileId,
    pub state: SlotState,
    pub last_wanted: u64,
}

/// The slots of one layer as the GPU manages them.
#[derive(Clone, Debug)]
pub(crate) struct ManagedSlots {
    pub slots: Vec<Option<HeldTile>>,
}

/// What a frame of it comes to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct ManagedFrame {
    pub missing: usize,
    pub resident: usize,
    pub asked: Vec<TileInSlot>,
    /// In the order of slots.
    pub shown: Vec<(TileId, u32)>,
}

impl ManagedSlots {
    pub fn new(slot_count: u32) -> Self {
        let root = HeldTile { tile: TileId::ROOT, state: SlotState::Reserved, last_wanted: 0 };
        let mut slots = vec![None; slot_count as usize];
        slots[0] = Some(root);
        Self { slots }
    }

    pub fn slot_of(&self, tile: TileId) -> Option<u32> {
        let place = self.slots.iter().position(|held| held.is_some_and(|h| h.tile == tile));
        place.map(|place| place as u32)
    }

    pub fn is_resident(&self, tile: TileId) -> bool {
        self.slots.iter().flatten().any(|h| h.tile == tile && h.state == SlotState::Resident)
    }

    fn state_of(&self, tile: TileId) -> Option<SlotState> {
        self.slots.iter().flatten().find(|held| held.tile == tile).map(|held| held.state)
    }

    /// One frame, numbered from 1. `wanted` has each tile once, level 0 first.
    pub fn frame(
        &mut self,
        wanted: &[TileId],
        uploaded: &[TileInSlot],
        failed: &[TileInSlot],
        frame: u64,
    ) -> ManagedFrame {
        self.take(uploaded, SlotState::Resident);
        self.take(failed, SlotState::Failed);
        let wanted = &wanted[..wanted.len().min(self.slots.len())];
        for held in self.slots.iter_mut().flatten().filter(|held| wanted.contains(&held.tile)) {
            held.last_wanted = frame;
        }
        self.reserve(wanted, frame);
        let is_to_come = |tile| self.state_of(tile) == Some(SlotState::Reserved);
        let to_come = wanted.iter().filter(|&&tile| is_to_come(tile));
        let asked = to_come.filter_map(|&tile| Some(TileInSlot::new(tile, self.slot_of(tile)?)));
        let is_missing = |&&tile: &&TileId| self.state_of(tile).is_none() || is_to_come(tile);
        let resident = |held: &&HeldTile| held.state == SlotState::Resident;
        ManagedFrame {
            missing: wanted.iter().filter(is_missing).count(),
            resident: self.slots.iter().flatten().filter(resident).count(),
            asked: asked.take(MOST_ASKED).collect(),
            shown: self.shown(wanted),
        }
    }

    fn take(&mut self, delivered: &[TileInSlot], state: SlotState) {
        for delivery in delivered {
            if let Some(held) = &mut self.slots[delivery.slot() as usize]
                && held.tile == delivery.tile()
                && held.state == SlotState::Reserved
            {
                held.state = state;
            }
        }
    }

    fn reserve(&mut self, wanted: &[TileId], frame: u64) {
        let is_reserved = |&&tile: &&TileId| self.state_of(tile) == Some(SlotState::Reserved);
        let room = MOST_ASKED.saturating_sub(wanted.iter().filter(is_reserved).count());
        let absent = wanted.iter().filter(|&&tile| self.state_of(tile).is_none()).take(room);
        for tile in absent.copied().collect::<Vec<_>>() {
            let may_go = |held: &Option<HeldTile>| {
                held.is_none_or(|held| held.tile.level > 0 && held.last_wanted != frame)
            };
            let order = |slot: &usize| match self.slots[*slot] {
                None => (0, 0, None, *slot),
                Some(HeldTile { tile, state, last_wanted }) => {
                    let kind = if state == SlotState::Resident { 2 } else { 1 };
                    (kind, last_wanted, Some(Reverse(tile)), *slot)
                }
            };
            let candidates = (0..self.slots.len()).filter(|&slot| may_go(&self.slots[slot]));
            if let Some(slot) = candidates.min_by_key(order) {
                let state = SlotState::Reserved;
                self.slots[slot] = Some(HeldTile { tile, state, last_wanted: frame });
            }
        }
    }

    fn shown(&self, wanted: &[TileId]) -> Vec<(TileId, u32)> {
        let stand_in = |&tile: &TileId| {
            let mut way_up = std::iter::successors(Some(tile), |tile| tile.parent());
            way_up.find(|&tile| self.is_resident(tile))
        };
        let shown = wanted.iter().filter_map(stand_in).collect::<Vec<_>>();
        let slots = (0..).zip(&self.slots).filter_map(|(slot, held)| Some(((*held)?.tile, slot)));
        slots.filter(|(tile, _)| shown.contains(tile)).collect()
    }
}

fn tile(number: u32) -> TileId {
    if number == 0 { TileId::ROOT } else { TileId::new(4, number / 16, number % 16) }
}

/// Level 0, and the tiles of these numbers, each once.
fn wanted(numbers: &[u32], slot_count: u32) -> Vec<TileId> {
    let mut wanted = vec![TileId::ROOT];
    for &number in numbers {
        if !wanted.contains(&tile(number)) {
            wanted.push(tile(number));
        }
    }
    wanted.truncate(slot_count as usize);
    wanted
}

proptest! {
    /// With everything there as soon as it is asked for, tiles get the slots the cache on the CPU gives.
    #[test]
    fn slots_are_those_of_the_cache_on_the_cpu(
        views in prop::collection::vec(prop::collection::vec(0u32..90, 0..50), 1..12),
        slot_count in 1u32..48,
    ) {
        let (mut managed, mut frame) = (ManagedSlots::new(slot_count), 0);
        let mut cache = TileCache::new(slot_count, 1);
        let mut asked = vec![TileInSlot::new(TileId::ROOT, 0)];
        for numbers in views {
            let wanted = wanted(&numbers, slot_count);
            loop {
                frame += 1;
                let result = managed.frame(&wanted, &asked, &[], frame);
                asked = result.asked;
                if result.missing == 0 {
                    break;
                }
            }
            cache.plan(&wanted, &|_| Some(1), u64::MAX, frame);
            let held = (0..).zip(&managed.slots);
            let held = held.filter_map(|(slot, held)| Some(((*held)?.tile, slot)));
            prop_assert_eq!(held.collect::<Vec<_>>(), cache.residents().collect::<Vec<_>>());
        }
    }

    /// Whatever the delays of lists and loads, the budget and the views.
    #[test]
    fn late_lists_never_spoil_a_slot_and_everything_comes_in_the_end(
        views in prop::collection::vec((prop::collection::vec(0u32..40, 0..12), 1usize..6), 1..30),
        latency in 0usize..5,
        slot_count in 1u32..14,
        budget in 1u64..4,
    ) {
        let mut flight = Flight::new(slot_count, latency, budget);
        for (numbers, frames) in views {
            let wanted = wanted(&numbers, slot_count);
            for _ in 0..frames {
                flight.frame(&wanted, numbers.len() % 2 == 0);
            }
        }
        // At rest on the last view's tiles.
        let wanted = wanted(&[3, 7, 20, 31], slot_count);
        let frames = 8 * (latency + 2);
        (0..frames).for_each(|_| flight.frame(&wanted, true));
        for &tile in &wanted {
            let is_bad = tile == Flight::BAD;
            prop_assert!(flight.slots.is_resident(tile) != is_bad, "{}", tile);
        }
        let moved = flight.uploads;
        flight.frame(&wanted, true);
        prop_assert_eq!((flight.uploads, flight.stream.missing()), (moved, 0));
    }
}

/// Both sides of the traffic, with lists that take some frames, and what lies in each slot of the atlas.
struct Flight {
    slots: ManagedSlots,
    stream: SlotStream<TileId>,
    atlas: HashMap<u32, TileId>,
    latest_slot: HashMap<TileId, u32>,
    on_their_way: VecDeque<(ManagedFrame, u64)>,
    latency: usize,
    budget: u64,
    frame: u64,
    uploads: usize,
}

impl Flight {
    /// A tile that cannot be loaded.
    const BAD: TileId = TileId { level: 4, row: 1, column: 15 };

    fn new(slot_count: u32, latency: usize, budget: u64) -> Self {
        let load = |tile: TileId| {
            if tile == Self::BAD {
                return Err(LoadError::Absent { path: "nowhere".into(), tile });
            }
            Ok(Loaded { tile, disk_bytes: 1 })
        };
        let loading = Loading { threads: 1, delay_frames: 0 };
        let mut intake = TileIntake::new(loading, Arc::new(load), |_| 1).unwrap();
        intake.supply(TileId::ROOT, TileId::ROOT);
        Self {
            slots: ManagedSlots::new(slot_count),
            stream: SlotStream::new(slot_count, intake),
            atlas: HashMap::new(),
            latest_slot: HashMap::new(),
            on_their_way: VecDeque::new(),
            latency,
            budget,
            frame: 0,
            uploads: 0,
        }
    }

    fn frame(&mut self, wanted: &[TileId], waits: bool) {
        self.frame += 1;
        while self.on_their_way.len() > self.latency {
            let (list, frame) = self.on_their_way.pop_front().unwrap();
            self.stream.receive(list.asked, list.missing, frame);
        }
        if waits {
            self.stream.wait(Duration::from_secs(10));
        }
        let update = self.stream.update(self.budget, self.frame);
        assert!(update.uploads.len() as u64 <= self.budget);
        self.uploads += update.uploads.len();
        let mut uploaded = Vec::new();
        for (placement, payload) in update.uploads {
            let held = self.slots.slots[placement.slot as usize];
            let shows = held.is_some_and(|held| held.state == SlotState::Resident);
            assert!(!shows, "{placement:?} overwrites {held:?}");
            let evicted = self.atlas.insert(placement.slot, payload);
            // Not what lies elsewhere by now, nor the tile itself, come back to the slot it had.
            let was_there = |tile: &TileId| {
                self.latest_slot.get(tile) == Some(&placement.slot) && *tile != placement.tile
            };
            assert_eq!(placement.evicted, evicted.filter(was_there));
            self.latest_slot.insert(placement.tile, placement.slot);
            uploaded.push(TileInSlot::new(placement.tile, placement.slot));
        }
        let before = self.slots.clone();
        let result = self.slots.frame(wanted, &uploaded, &update.failed, self.frame);
        self.check(&before, wanted, &result);
        self.on_their_way.push_back((result, self.frame));
    }

    fn check(&self, before: &ManagedSlots, wanted: &[TileId], result: &ManagedFrame) {
        let held = self.slots.slots.iter().flatten().map(|held| held.tile).collect::<Vec<_>>();
        let distinct = held.iter().collect::<std::collections::HashSet<_>>();
        assert_eq!(distinct.len(), held.len(), "a tile has two slots");
        assert!(self.slots.is_resident(TileId::ROOT), "level 0 is lost");
        for &tile in wanted.iter().filter(|&&tile| before.is_resident(tile)) {
            assert_eq!(before.slot_of(tile), self.slots.slot_of(tile), "{tile} had to go");
        }
        for &(tile, slot) in &result.shown {
            assert_eq!(self.atlas.get(&slot), Some(&tile), "what is shown lies there");
        }
    }
}
