//! A still camera comes to rest, and then costs nothing.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use terrain_core::dataset::Dataset;
use terrain_core::gpu::GpuContext;
use terrain_core::measure::Flight;
use terrain_core::prepare::{NoProgress, PrepareRequest, prepare};
use terrain_core::selection::Strategy;
use terrain_core::{CameraView, RendererSettings};
use terrain_tests::{Bench, Ridges};

use crate::drawn::settle_to_rest;

fn settings(strategy: Strategy) -> RendererSettings {
    RendererSettings { strategy, ..Default::default() }
}

pub fn a_still_camera_costs_nothing_but_its_picture(gpu: &Arc<GpuContext>, strategy: Strategy) {
    let mut bench = Bench::on(gpu, Ridges::source(), settings(strategy)).unwrap();
    let view = Ridges::view(20.0, -18.0, 2_500.0);
    let settled = settle_to_rest(&mut bench, &view);
    assert_eq!(settled.strategy, strategy.name());
    let first = bench.picture().unwrap();
    for _ in 0..3 {
        let record = bench.draw(&view).unwrap();
        assert_eq!((record.upload_bytes, record.readback_bytes), (0, 0), "{record:?}");
        assert_eq!((record.disk_bytes, record.tiles_new), (0, 0), "{record:?}");
        assert!(!record.coordinate_pass_drawn && record.select_ms == 0.0, "{record:?}");
    }
    assert!(bench.picture().unwrap() == first, "the picture changed");
    let turned = CameraView { heading_deg: view.heading_deg + 0.1, ..view };
    assert!(bench.renderer.needs_frame(&turned));
}

pub fn a_view_of_the_sky_is_a_state(gpu: &Arc<GpuContext>, strategy: Strategy) {
    let mut bench = Bench::on(gpu, Ridges::source(), settings(strategy)).unwrap();
    let record = settle_to_rest(&mut bench, &Ridges::view(20.0, 80.0, 2_500.0));
    assert!(record.tiles_selected <= 1, "more than level 0: {record:?}");
}

pub fn drawing_beside_the_frames_leaves_no_trace(gpu: &Arc<GpuContext>, strategy: Strategy) {
    let mut bench = Bench::on(gpu, Ridges::source(), settings(strategy)).unwrap();
    let here = Ridges::view(20.0, -18.0, 2_500.0);
    let picture = bench.settled_picture(&here).unwrap();
    let elsewhere = Ridges::view(140.0, -40.0, 9_000.0);
    bench.renderer.drawn_coordinates(&elsewhere).unwrap();
    bench.redraw(&elsewhere).unwrap();
    assert!(!bench.renderer.needs_frame(&here));
    let record = bench.draw(&here).unwrap();
    assert_eq!((record.upload_bytes, record.readback_bytes), (0, 0), "{record:?}");
    assert!(bench.picture().unwrap() == picture, "the picture changed");
}

/// Along the demo flight with a cache far too small for texels of half a pixel: every selection is
/// merged down to what fits, so a little more or less ground in view changes many tiles, and through
/// their heights the ground in view.
pub fn where_tiles_and_view_feed_each_other_the_camera_still_comes_to_rest(
    gpu: &Arc<GpuContext>,
    strategy: Strategy,
) {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/demo");
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("demo");
    let mut request = PrepareRequest::new(vec![data.join("dem.tif")], Vec::new(), out.clone());
    request.epsg = Some(3395);
    prepare(&request, &NoProgress, &AtomicBool::new(false)).unwrap();
    let flight = Flight::read(&data.join("flight.json")).unwrap();
    let settings =
        RendererSettings { texel_px: 0.5, vertical_exaggeration: 15.0, ..settings(strategy) };
    let mut bench = Bench::on(gpu, Arc::new(Dataset::open(&out).unwrap()), settings).unwrap();
    let mut most = 0;
    for frame in (560..574).chain(728..734) {
        let view = flight.view_at(flight.frame_time_s(frame), [640, 360]);
        let record = settle_to_rest(&mut bench, &view);
        most = most.max(record.tiles_new);
    }
    println!("at most {most} tiles for a view");
    let by_what_was_seen = strategy.implementation().is_some_and(|choice| choice.needs_region());
    // Twice the cache; without a bound to it there were 1,682.
    assert!(!by_what_was_seen || most <= 72, "{most} tiles for one view");
}
