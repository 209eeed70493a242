use std::collections::{HashMap, HashSet};

use crate::tiling::TileId;

/// The slots of one layer's atlas and the tiles in them: says what to load, upload and evict, and
/// touches nothing itself.
///
/// The cache of Liu Hao et al., "Dynamic Scheduling and Real-time Rendering Method for Large-Scale
/// Terrain", section 3.2: m x n slots, any tile in any slot, tiles taken in the order of the list.
///
/// Departures: tiles stay until their slot is needed, and the least recently used goes first (the
/// paper names no rule); uploads keep within a byte budget a frame; only new tiles are uploaded, not
/// the whole cache.
#[derive(Clone, Debug)]
pub struct TileCache {
    columns: u32,
    rows: u32,
    slots: Vec<Option<Resident>>,
    slot_of: HashMap<TileId, u32>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Resident {
    tile: TileId,
    /// The latest frame that wanted the tile.
    last_wanted: u64,
}

/// A tile to upload, and the slot it goes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Placement {
    /// The tile.
    pub tile: TileId,
    /// The slot, counted row by row from 0.
    pub slot: u32,
    /// The tile that was there.
    pub evicted: Option<TileId>,
}

/// What one frame is to do about a [`TileCache`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CachePlan {
    /// Tiles to upload now. The cache counts them as resident from here on.
    pub uploads: Vec<Placement>,
    /// Tiles to load, most urgent first.
    pub requests: Vec<TileId>,
    /// Tiles that are loaded, but over this frame's budget.
    pub deferred: Vec<TileId>,
    /// Wanted tiles there is room for that are not resident after this plan: what later frames can
    /// still bring.
    pub missing: usize,
    /// Tiles wanted beyond what there are slots for, neither loaded nor missing.
    pub turned_away: usize,
}

impl TileCache {
    /// An empty cache of `columns` x `rows` slots. Without any slot everything is missing for ever.
    pub fn new(columns: u32, rows: u32) -> Self {
        let capacity = columns as usize * rows as usize;
        Self { columns, rows, slots: vec![None; capacity], slot_of: HashMap::new() }
    }

    /// Slots across.
    pub fn columns(&self) -> u32 {
        self.columns
    }

    /// Slots down.
    pub fn rows(&self) -> u32 {
        self.rows
    }

    /// Number of slots.
    pub fn capacity(&self) -> usize {
        self.slots.len()
    }

    /// Number of resident tiles.
    pub fn len(&self) -> usize {
        self.slot_of.len()
    }

    /// Whether no tile is resident.
    pub fn is_empty(&self) -> bool {
        self.slot_of.is_empty()
    }

    /// The slot of a resident tile.
    pub fn slot_of(&self, tile: TileId) -> Option<u32> {
        self.slot_of.get(&tile).copied()
    }

    /// The resident tiles and their slots, in the order of the slots.
    pub fn residents(&self) -> impl Iterator<Item = (TileId, u32)> + '_ {
        (0u32..)
            .zip(&self.slots)
            .filter_map(|(slot, resident)| Some((resident.as_ref()?.tile, slot)))
    }

    /// Forgets every tile, as after the loss of the atlas.
    pub fn clear(&mut self) {
        self.slots.fill(None);
        self.slot_of.clear();
    }

    /// Plans one frame.
    ///
    /// * `wanted`: the tiles the frame is to be drawn with, most urgent first. Of more than there
    ///   are slots, the first are taken.
    /// * `ready`: the bytes a tile's upload moves, if it is loaded and waiting.
    /// * `upload_budget_bytes`: the uploads' bytes at the most; the first upload of a frame goes
    ///   through whatever its size, so that there is always progress.
    /// * `frame`: a number that never falls; the order in which tiles were last wanted.
    ///
    /// Wanted tiles that are resident stay. Uploads go in order of urgency, to free slots first, then
    /// to those of the least recently wanted tiles (of equally old ones the finest first). A tile
    /// wanted this frame is never evicted, nor is level 0.
    pub fn plan(
        &mut self,
        wanted: &[TileId],
        ready: &dyn Fn(TileId) -> Option<u64>,
        upload_budget_bytes: u64,
        frame: u64,
    ) -> CachePlan {
        let (admitted, turned_away) = self.admit(wanted);
        self.touch(&admitted, frame);
        let absent: Vec<_> =
            admitted.iter().copied().filter(|tile| !self.slot_of.contains_key(tile)).collect();
        let mut plan = CachePlan { turned_away, ..CachePlan::default() };
        let mut waiting = Vec::new();
        for &tile in &absent {
            match ready(tile) {
                Some(bytes) => waiting.push((tile, bytes)),
                None => plan.requests.push(tile),
            }
        }
        let affordable = affordable_uploads(&waiting, upload_budget_bytes);
        plan.deferred = waiting.drain(affordable..).map(|(tile, _)| tile).collect();
        let slots = self.slots_to_fill(affordable, &admitted);
        for ((tile, _), slot) in waiting.into_iter().zip(slots) {
            plan.uploads.push(self.place(tile, slot, frame));
        }
        plan.missing = absent.len() - plan.uploads.len();
        plan
    }

    /// The wanted tiles there is room for, each once, and how many there is none for. Level 0 keeps
    /// its slot even when it is not wanted.
    fn admit(&self, wanted: &[TileId]) -> (Vec<TileId>, usize) {
        let mut seen = HashSet::with_capacity(wanted.len());
        let mut admitted: Vec<_> =
            wanted.iter().copied().filter(|&tile| seen.insert(tile)).collect();
        let distinct = admitted.len();
        admitted.truncate(self.capacity());
        if self.slot_of.contains_key(&TileId::ROOT) && !admitted.contains(&TileId::ROOT) {
            admitted.truncate(self.capacity() - 1);
        }
        let turned_away = distinct - admitted.len();
        (admitted, turned_away)
    }

    fn touch(&mut self, tiles: &[TileId], frame: u64) {
        for tile in tiles {
            let slot = self.slot_of.get(tile).copied();
            if let Some(resident) = slot.and_then(|slot| self.slots[slot as usize].as_mut()) {
                resident.last_wanted = frame;
            }
        }
    }

    /// `count` slots for new tiles: free ones first, then the least recently wanted tiles', never
    /// one of a tile that is to `keep` nor of level 0.
    fn slots_to_fill(&self, count: usize, keep: &[TileId]) -> Vec<u32> {
        if count == 0 {
            return Vec::new();
        }
        let keep: HashSet<_> = keep.iter().chain(&[TileId::ROOT]).collect();
        let mut slots: Vec<_> = (0u32..)
            .zip(&self.slots)
            .filter(|(_, resident)| resident.is_none_or(|resident| !keep.contains(&resident.tile)))
            .collect();
        // `None`, a free slot, sorts before any frame.
        slots.sort_by_key(|(slot, resident)| {
            (resident.map(|r| (r.last_wanted, std::cmp::Reverse(r.tile))), *slot)
        });
        slots.truncate(count);
        slots.into_iter().map(|(slot, _)| slot).collect()
    }

    fn place(&mut self, tile: TileId, slot: u32, frame: u64) -> Placement {
        let resident = Resident { tile, last_wanted: frame };
        let evicted = self.slots[slot as usize].replace(resident).map(|old| old.tile);
        if let Some(evicted) = evicted {
            self.slot_of.remove(&evicted);
        }
        self.slot_of.insert(tile, slot);
        Placement { tile, slot, evicted }
    }
}

/// How many of the tiles fit the budget together, in order; at least one, where there is one.
pub(super) fn affordable_uploads<T>(waiting: &[(T, u64)], budget_bytes: u64) -> usize {
    let mut total_bytes = 0_u64;
    let fitting = waiting.iter().take_while(|(_, bytes)| {
        total_bytes = total_bytes.saturating_add(*bytes);
        total_bytes <= budget_bytes
    });
    fitting.count().max(1).min(waiting.len())
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use proptest::prelude::*;

    use super::*;

    fn tile(number: u32) -> TileId {
        TileId::new(4, number / 16, number % 16)
    }

    const BYTES: u64 = 100;

    fn everything_ready(_: TileId) -> Option<u64> {
        Some(BYTES)
    }

    fn placed(plan: &CachePlan) -> Vec<TileId> {
        plan.uploads.iter().map(|placement| placement.tile).collect()
    }

    #[test]
    fn what_is_not_loaded_is_requested_and_what_is_goes_to_free_slots_in_order() {
        let mut cache = TileCache::new(2, 2);
        let wanted = [TileId::ROOT, tile(1), tile(2)];
        let plan = cache.plan(&wanted, &|_| None, 1_000, 1);
        assert_eq!((plan.requests.as_slice(), plan.missing), (wanted.as_slice(), 3));
        let plan = cache.plan(&wanted, &|t| (t != tile(1)).then_some(BYTES), 1_000, 2);
        assert_eq!(placed(&plan), [TileId::ROOT, tile(2)]);
        assert_eq!((plan.requests.as_slice(), plan.missing), ([tile(1)].as_slice(), 1));
        assert_eq!(cache.residents().collect::<Vec<_>>(), [(TileId::ROOT, 0), (tile(2), 1)]);
        let plan = cache.plan(&wanted, &everything_ready, 1_000, 3);
        assert_eq!(plan.uploads, [Placement { tile: tile(1), slot: 2, evicted: None }]);
        let idle = cache.plan(&wanted, &everything_ready, 1_000, 4);
        assert_eq!(idle, CachePlan::default(), "nothing moves once all is resident");
    }

    #[test]
    fn the_budget_holds_but_never_stops_progress() {
        let mut cache = TileCache::new(3, 3);
        let wanted: Vec<_> = (0..5).map(tile).collect();
        let plan = cache.plan(&wanted, &everything_ready, 2 * BYTES + 99, 1);
        assert_eq!(placed(&plan), wanted[..2]);
        assert_eq!((plan.deferred.as_slice(), plan.missing), (&wanted[2..], 3));
        for (frame, next) in (2..).zip(&wanted[2..]) {
            let plan = cache.plan(&wanted, &everything_ready, 0, frame);
            assert_eq!(placed(&plan), [*next], "one upload even without any budget");
        }
    }

    #[test]
    fn an_urgent_tile_over_budget_is_not_overtaken_by_smaller_ones() {
        let mut cache = TileCache::new(3, 3);
        let bytes = |t| Some(if t == tile(1) { 500 } else { 10 });
        let plan = cache.plan(&[tile(0), tile(1), tile(2)], &bytes, 100, 1);
        assert_eq!((placed(&plan), plan.deferred), (vec![tile(0)], vec![tile(1), tile(2)]));
    }

    #[test]
    fn level_0_is_never_evicted_and_more_wanted_than_slots_takes_the_first() {
        let mut cache = TileCache::new(2, 1);
        cache.plan(&[TileId::ROOT], &everything_ready, 1_000, 1);
        let plan = cache.plan(&[tile(1), tile(2), tile(3)], &everything_ready, 1_000, 2);
        assert_eq!((placed(&plan), plan.turned_away, plan.missing), (vec![tile(1)], 2, 0));
        let plan = cache.plan(&[tile(2)], &everything_ready, 1_000, 3);
        assert_eq!(plan.uploads[0].evicted, Some(tile(1)));
        assert!(cache.slot_of(TileId::ROOT).is_some());
    }

    #[test]
    fn a_cache_without_slots_is_a_state() {
        let mut cache = TileCache::new(0, 7);
        let plan = cache.plan(&[TileId::ROOT], &everything_ready, 1_000, 1);
        assert_eq!(plan, CachePlan { turned_away: 1, ..CachePlan::default() });
    }

    /// Tiles wanted (0 stands for level 0), the numbers of those ready, and the budget in tiles.
    type Frame = (Vec<u32>, BTreeSet<u32>, u64);

    fn frames() -> impl Strategy<Value = Vec<Frame>> {
        let wanted = prop::collection::vec(0u32..14, 0..10);
        let ready = prop::collection::btree_set(0u32..14, 0..14);
        prop::collection::vec((wanted, ready, 0u64..5), 1..40)
    }

    fn numbered(number: u32) -> TileId {
        if number == 0 { TileId::ROOT } else { tile(number) }
    }

    proptest! {
        #[test]
        fn it_behaves_like_a_slow_and_literal_cache(
            frames in frames(), columns in 1u32..4, rows in 1u32..4,
        ) {
            let mut cache = TileCache::new(columns, rows);
            // (tile, the frame that last wanted it) by slot.
            let mut model: Vec<Option<(TileId, u64)>> = vec![None; (columns * rows) as usize];
            for (frame, (wanted, ready, budget)) in (1u64..).zip(frames) {
                let wanted: Vec<_> = wanted.into_iter().map(numbered).collect();
                let ready: BTreeSet<_> = ready.into_iter().map(numbered).collect();
                let is_ready = |tile| ready.contains(&tile).then_some(BYTES);
                let plan = cache.plan(&wanted, &is_ready, budget * BYTES, frame);
                let expected = plan_by_hand(&mut model, &wanted, &ready, budget, frame);
                prop_assert_eq!(plan, expected);
                let residents: Vec<_> = (0u32..)
                    .zip(&model)
                    .filter_map(|(slot, held)| held.map(|(tile, _)| (tile, slot)))
                    .collect();
                prop_assert_eq!(cache.residents().collect::<Vec<_>>(), residents.clone());
                prop_assert_eq!(cache.len(), residents.len());
                for (tile, slot) in residents {
                    prop_assert_eq!(cache.slot_of(tile), Some(slot));
                }
            }
        }
    }

    /// The rules of [`TileCache::plan`] one by one, for tiles that all have [`BYTES`] bytes.
    fn plan_by_hand(
        model: &mut [Option<(TileId, u64)>],
        wanted: &[TileId],
        ready: &BTreeSet<TileId>,
        budget_tiles: u64,
        frame: u64,
    ) -> CachePlan {
        let is_held = |model: &[Option<(TileId, u64)>], tile| {
            model.iter().flatten().any(|&(held, _)| held == tile)
        };
        let mut room = model.len();
        let mut distinct: Vec<TileId> = Vec::new();
        for &tile in wanted {
            if !distinct.contains(&tile) {
                distinct.push(tile);
            }
        }
        let root_is_among = distinct.iter().take(room).any(|&tile| tile == TileId::ROOT);
        if is_held(model, TileId::ROOT) && !root_is_among {
            room -= 1;
        }
        let turned_away = distinct.len().saturating_sub(room);
        distinct.truncate(room);
        for held in model.iter_mut().flatten().filter(|(tile, _)| distinct.contains(tile)) {
            held.1 = frame;
        }
        let mut plan = CachePlan { turned_away, ..CachePlan::default() };
        for &tile in &distinct {
            if is_held(model, tile) {
                continue;
            }
            plan.missing += 1;
            if !ready.contains(&tile) {
                plan.requests.push(tile);
            } else if plan.uploads.len() as u64 >= budget_tiles.max(1) {
                plan.deferred.push(tile);
            } else {
                let age = |slot: &usize| match model[*slot] {
                    None => (0, 0, std::cmp::Reverse(TileId::ROOT), *slot),
                    Some((tile, last)) => (1, last, std::cmp::Reverse(tile), *slot),
                };
                let may_go = |slot: &usize| {
                    model[*slot].is_none_or(|(t, _)| t != TileId::ROOT && !distinct.contains(&t))
                };
                let slot = (0..model.len()).filter(may_go).min_by_key(age).unwrap();
                let evicted = model[slot].replace((tile, frame)).map(|(tile, _)| tile);
                plan.uploads.push(Placement { tile, slot: slot as u32, evicted });
                plan.missing -= 1;
            }
        }
        plan
    }
}
