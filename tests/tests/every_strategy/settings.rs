//! Settings take hold when they change, or are refused and change nothing.

use std::sync::Arc;

use glam::DVec2;
use terrain_core::gpu::GpuContext;
use terrain_core::selection::Strategy;
use terrain_core::{CameraView, DebugView, RendererSettings};
use terrain_tests::{AnalyticSource, Bench, Ridges};

use crate::drawn::{PLACE_CONTRACT_PX, check, down, settle_to_rest};

fn settings(strategy: Strategy) -> RendererSettings {
    RendererSettings { strategy, ..Default::default() }
}

pub fn a_new_cache_is_counted(gpu: &Arc<GpuContext>, strategy: Strategy) {
    let mut bench = Bench::on(gpu, Ridges::source(), settings(strategy)).unwrap();
    bench.settle(&down()).unwrap();
    bench
        .change(|settings| {
            (settings.cache_columns, settings.cache_rows, settings.max_tiles) = (4, 4, 16);
        })
        .unwrap();
    let record = bench.draw(&down()).unwrap();
    let level_0_bytes = 392 * 392 * 4;
    assert!(record.upload_dom_bytes >= level_0_bytes, "level 0 went up anew: {record:?}");
}

pub fn a_cache_larger_than_a_texture_is_refused_and_the_old_one_stays(
    gpu: &Arc<GpuContext>,
    strategy: Strategy,
) {
    let source = Arc::new(Ridges::source_at(DVec2::ZERO).with_tile_sizes([128, 2048]));
    let old =
        RendererSettings { cache_columns: 2, cache_rows: 2, max_tiles: 4, ..settings(strategy) };
    let mut bench = Bench::on(gpu, source, old).unwrap();
    let old = *bench.renderer.settings();
    let refused = bench.change(|settings| settings.cache_columns = 40).unwrap_err();
    assert!(refused.to_string().contains("choose a smaller cache"), "{refused}");
    assert_eq!(*bench.renderer.settings(), old);
    settle_to_rest(&mut bench, &down());
}

pub fn every_view_of_the_ground_can_be_drawn(gpu: &Arc<GpuContext>, strategy: Strategy) {
    let mut bench = Bench::on(gpu, Ridges::source(), settings(strategy)).unwrap();
    let view = CameraView { viewport_px: [192, 108], ..Ridges::view(20.0, -18.0, 2_500.0) };
    let mut before = bench.settled_picture(&view).unwrap();
    for debug_view in [DebugView::TileBorders, DebugView::Levels, DebugView::Shading] {
        for wireframe in [false, true] {
            bench
                .change(|settings| {
                    (settings.debug_view, settings.wireframe) = (debug_view, wireframe);
                })
                .unwrap();
            settle_to_rest(&mut bench, &view);
            let picture = bench.picture().unwrap();
            assert!(picture != before, "{debug_view:?}, wireframe {wireframe}: nothing changed");
            before = picture;
        }
    }
}

/// What is no factor, or beyond the range from 0.01 to 1000, is brought into it.
pub fn exaggeration_up_to_a_thousandfold_and_what_is_none(
    gpu: &Arc<GpuContext>,
    strategy: Strategy,
) {
    let source = AnalyticSource::new(Ridges::surface(), DVec2::ZERO, Ridges::ROOT_M, [4, 3]);
    let mut bench = Bench::on(gpu, Arc::new(source), settings(strategy)).unwrap();
    for factor in [0.0, 1.0e-3, 1.0, 1000.0, f64::INFINITY, f64::NAN, -3.0] {
        bench.change(|settings| settings.vertical_exaggeration = factor).unwrap();
        for (eye_m, pitch_deg) in [(2_500.0, -18.0), (900_000.0, -90.0)] {
            let view = Ridges::view(20.0, pitch_deg, eye_m);
            let view = CameraView { viewport_px: [96, 54], ..view };
            let drawn = check(&mut bench, &format!("exaggeration {factor}"), &view);
            let error_px = drawn.place_error_px();
            assert!(error_px < PLACE_CONTRACT_PX, "{error_px} px");
        }
    }
}
