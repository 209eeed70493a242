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
fn affordable_uploads(waiting: &[(TileId, u64)], budget_bytes: u64) -> usize {
    let mut total_bytes = 0_u64;
    let fitting = waiting.iter().take_while(|(_, bytes)| {
        total_bytes = total_bytes.saturating_add(*bytes);
        total_bytes <= budget_bytes
    });
    fitting.count().max(1).min(waiting.len())
}
