//! Frames keep the budget of uploads, and the least of everything still draws.

use std::sync::Arc;
use std::time::Duration;

use terrain_core::RendererSettings;
use terrain_core::gpu::GpuContext;
use terrain_core::selection::Strategy;
use terrain_tests::{Bench, Ridges};

use crate::drawn::{down, holes, settle_to_rest};

/// A tile of the imagery, 392 texels a side with its gutter, at 4 bytes a texel.
const COLOUR_TILE_BYTES: u64 = 392 * 392 * 4;

pub fn the_budget_bounds_the_bytes_of_a_frame(gpu: &Arc<GpuContext>, strategy: Strategy) {
    // Level 0 is a tile or a strip of each layer; what goes up beside ground is small.
    const HEIGHT_TILE_BYTES: u64 = 136 * 136 * 4;
    const BESIDE_BYTES: u64 = 40_000;
    for budget_bytes in [300_000, 700_000] {
        let settings =
            RendererSettings { strategy, upload_budget_bytes: budget_bytes, ..Default::default() };
        let mut bench = Bench::on(gpu, Ridges::source(), settings).unwrap();
        for frame in 0..24 {
            let record = bench.draw(&down()).unwrap();
            // One tile or strip of a layer goes through whatever is left.
            let most = budget_bytes + COLOUR_TILE_BYTES + HEIGHT_TILE_BYTES + BESIDE_BYTES;
            assert!(record.upload_bytes <= most, "frame {frame}: {record:?}");
            std::thread::sleep(Duration::from_millis(3));
        }
    }
}

pub fn the_smallest_cache_and_no_budget_still_draw(gpu: &Arc<GpuContext>, strategy: Strategy) {
    let settings = RendererSettings {
        strategy,
        cache_columns: 1,
        cache_rows: 1,
        max_tiles: 1,
        upload_budget_bytes: 0,
        ..Default::default()
    };
    let mut bench = Bench::on(gpu, Ridges::source(), settings).unwrap();
    for frame in 0..3 {
        bench.draw(&down()).unwrap();
        assert_eq!(holes(&bench.picture().unwrap()), 0, "frame {frame}");
    }
    let record = settle_to_rest(&mut bench, &down());
    assert_eq!(holes(&bench.picture().unwrap()), 0);
    assert!(record.tiles_selected <= 1, "{record:?}");
}
