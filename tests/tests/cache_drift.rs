//! A cache that is used for hours keeps its promises.

use std::collections::HashSet;

use terrain_core::residency::{OffsetTable, TileCache};
use terrain_core::tiling::TileId;

#[test]
fn a_cache_drifted_over_for_a_million_frames_keeps_its_promises() {
    let mut cache = TileCache::new(6, 6);
    let level = 20;
    for frame in 0..1_000_000_u64 {
        // A window of 5 x 5 tiles that moves on by a tile every 16 frames.
        let start = (frame / 16) as u32;
        let window = (0..25).map(|i| TileId::new(level, start + i / 5, 3 * start + i % 5));
        let wanted = std::iter::once(TileId::ROOT).chain(window).collect::<Vec<_>>();
        let plan = cache.plan(&wanted, &|_| Some(36_992), 1 << 18, frame);
        assert!(plan.uploads.len() <= 7 && plan.turned_away == 0, "frame {frame}: {plan:?}");
        assert!(cache.slot_of(TileId::ROOT).is_some() && cache.len() <= 36, "frame {frame}");
        if frame % 16 == 15 {
            assert_eq!(plan.missing, 0, "frame {frame}: {plan:?}");
        }
        if frame % 10_000 == 0 {
            let table = OffsetTable::build(cache.residents());
            let slots = table.entries.iter().map(|entry| entry.slot).collect::<HashSet<_>>();
            assert_eq!((table.entries.len(), slots.len()), (cache.len(), cache.len()));
        }
    }
}
