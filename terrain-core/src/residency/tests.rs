//! Cache, loader and table together, as a renderer uses them frame by frame.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::Duration;

use super::*;
use crate::tiling::{FixedPosition, TileId};

const BYTES: u64 = 1_000;
const BUDGET_BYTES: u64 = 3 * BYTES;
/// Frames in which anything can be brought that fits a cache of 25 slots.
const FRAMES_AT_MOST: u64 = 200;

/// Level 0, then the tiles round a point down to level 4: what a flight over the point wants.
fn wanted_round(east: f64, south: f64) -> Vec<TileId> {
    let mut wanted = vec![TileId::ROOT];
    for level in 1..=4 {
        let side = 1.0 / f64::from(1 << level);
        for (x, y) in [(-0.25, -0.25), (0.25, -0.25), (-0.25, 0.25), (0.25, 0.25)] {
            let position =
                FixedPosition::from_root_fraction(east + 2.0 * x * side, south + 2.0 * y * side);
            wanted.extend(position.tile_at(level).filter(|tile| !wanted.contains(tile)));
        }
    }
    wanted
}

/// A renderer's side of the traffic: what is loaded and waits, and what it holds in each slot.
struct Renderer {
    cache: TileCache,
    loader: TileLoader<TileId>,
    waiting: HashMap<TileId, TileId>,
    atlas: HashMap<u32, TileId>,
}

impl Renderer {
    fn new() -> Self {
        let load = Arc::new(|tile: TileId| tile);
        Self {
            cache: TileCache::new(5, 5),
            loader: TileLoader::new(Loading { threads: 2, delay_frames: 0 }, load).unwrap(),
            waiting: HashMap::new(),
            atlas: HashMap::new(),
        }
    }

    fn frame(&mut self, wanted: &[TileId], frame: u64) -> CachePlan {
        self.waiting.extend(self.loader.poll());
        let ready = |tile| self.waiting.contains_key(&tile).then_some(BYTES);
        let plan = self.cache.plan(wanted, &ready, BUDGET_BYTES, frame);
        for placement in &plan.uploads {
            let payload = self.waiting.remove(&placement.tile).unwrap();
            assert_eq!(self.atlas.insert(placement.slot, payload), placement.evicted);
        }
        self.waiting.retain(|tile, _| wanted.contains(tile));
        self.loader.set_wanted(&plan.requests);
        plan
    }

    /// Every entry of the table leads to its own tile's content.
    fn check_table(&self) {
        let table = OffsetTable::build(self.cache.residents());
        assert_eq!(table.entries.len(), self.atlas.len());
        for entry in &table.entries {
            assert_eq!(self.atlas.get(&entry.slot), Some(&entry.tile));
        }
    }
}

#[test]
fn a_flight_gets_what_it_wants_within_budget_and_never_shows_a_hole() {
    let mut renderer = Renderer::new();
    let mut frame = 0;
    for step in 0..12 {
        let (east, south) = (0.1 + 0.07 * f64::from(step), 0.8 - 0.06 * f64::from(step));
        let wanted = wanted_round(east, south);
        assert!(wanted.len() <= renderer.cache.capacity());
        let last = frame + FRAMES_AT_MOST;
        loop {
            frame += 1;
            assert!(frame < last, "step {step} does not come to rest");
            let plan = renderer.frame(&wanted, frame);
            assert!(plan.uploads.len() as u64 * BYTES <= BUDGET_BYTES);
            renderer.check_table();
            let root_came = renderer.cache.slot_of(TileId::ROOT).is_some();
            assert!(step == 0 || root_came, "level 0 was lost");
            if plan.missing == 0 {
                break;
            }
            renderer.loader.wait_any(Duration::from_secs(10));
        }
        assert!(wanted.iter().all(|&tile| renderer.cache.slot_of(tile).is_some()));
        let table = OffsetTable::build(renderer.cache.residents());
        let here = FixedPosition::from_root_fraction(east, south);
        let found = table.find_descend(here).map(|index| table.entries[index].tile);
        assert_eq!(found, here.tile_at(4), "the finest tile under the eye is shown");
        assert_eq!(renderer.frame(&wanted, frame), CachePlan::default(), "at rest nothing moves");
    }
}
