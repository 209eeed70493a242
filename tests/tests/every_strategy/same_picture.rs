//! The picture of a view depends on the view alone.

use std::sync::{Arc, LazyLock};

use glam::{DVec2, DVec3, dvec2};
use terrain_core::dataset::TileSource;
use terrain_core::gpu::GpuContext;
use terrain_core::selection::Strategy;
use terrain_core::{CameraView, LookupMethod, RendererSettings};
use terrain_tests::{AnalyticSource, Bench, Picture, Remembering, Ridges};

use crate::drawn::check;

fn bench(gpu: &Arc<GpuContext>, strategy: Strategy) -> Bench {
    bench_of(gpu, strategy, Ridges::source())
}

fn bench_of(gpu: &Arc<GpuContext>, strategy: Strategy, source: Arc<dyn TileSource>) -> Bench {
    let settings = RendererSettings { strategy, ..Default::default() };
    Bench::on(gpu, source, settings).unwrap()
}

fn view() -> CameraView {
    Ridges::view(20.0, -18.0, 2_500.0)
}

fn moved(view: &CameraView, by: DVec2) -> CameraView {
    CameraView { eye: view.eye + by.extend(0.0), ..*view }
}

/// The pictures of two renderers are the same but for rounding: which slot a tile comes to depends on
/// the order in which tiles were loaded (with a single loading thread the pictures are equal bit for bit),
/// and how a sampler's coordinates round depends on the slot.
fn assert_same(a: &Picture, b: &Picture) {
    let differences = a.rgba.iter().zip(&b.rgba).map(|(a, b)| a.abs_diff(*b));
    let most = differences.clone().max().unwrap_or(0);
    let count = differences.filter(|difference| *difference > 0).count();
    println!("{count} values differ, by {most} of 255 at most");
    assert!(a.size_px == b.size_px && most <= 1, "the pictures differ by up to {most} of 255");
    assert!(count * 1_000 <= a.rgba.len(), "the pictures differ in {count} values");
}

pub fn ten_thousand_kilometres_away_it_is_the_same(gpu: &Arc<GpuContext>, strategy: Strategy) {
    // Made once for all strategies.
    static FAR: LazyLock<Arc<Remembering<AnalyticSource>>> =
        LazyLock::new(|| Arc::new(Remembering::new(Ridges::source_at(FAR_CENTRE))));
    const FAR_CENTRE: DVec2 = dvec2(10_000_000.0, -10_000_000.0);
    let near = bench(gpu, strategy).settled_picture(&view()).unwrap();
    let mut far = bench_of(gpu, strategy, Arc::clone(&FAR) as _);
    assert_same(&near, &far.settled_picture(&moved(&view(), FAR_CENTRE)).unwrap());
}

pub fn both_lookups_draw_the_same(gpu: &Arc<GpuContext>, strategy: Strategy) {
    let [descend, linear] = [LookupMethod::Descend, LookupMethod::Linear].map(|lookup| {
        let mut bench = bench(gpu, strategy);
        bench.change(|settings| settings.lookup = lookup).unwrap();
        bench.settled_picture(&view()).unwrap()
    });
    assert_same(&descend, &linear);
}

pub fn it_does_not_depend_on_the_way_there(gpu: &Arc<GpuContext>, strategy: Strategy) {
    let high = CameraView { eye: DVec2::ZERO.extend(60_000.0), pitch_deg: -60.0, ..view() };
    let (mut flown, mut fresh) = (bench(gpu, strategy), bench(gpu, strategy));
    flown.settle(&view()).unwrap();
    // Not so where fine tiles of the way there still show.
    assert_same(&flown.settled_picture(&high).unwrap(), &fresh.settled_picture(&high).unwrap());
    for away in [
        CameraView { eye: view().eye + DVec3::new(4_000.0, 1_000.0, 0.0), ..view() },
        CameraView { fov_y_deg: 12.0, ..view() },
    ] {
        // One frame only: the next view comes before anything has been answered.
        flown.draw(&away).unwrap();
    }
    let fresh = bench(gpu, strategy).settled_picture(&view()).unwrap();
    assert_same(&flown.settled_picture(&view()).unwrap(), &fresh);
}

pub fn after_jumps_across_the_earth_it_is_what_it_was(gpu: &Arc<GpuContext>, strategy: Strategy) {
    let mut bench = bench(gpu, strategy);
    let view = CameraView { viewport_px: [96, 54], ..view() };
    let home = check(&mut bench, "home", &view).points;
    for shift in [dvec2(1.0e7, 0.0), dvec2(-1.0e7, 1.0e7), dvec2(0.0, -4.0e7)] {
        // One frame only: the next jump comes before anything has been answered.
        bench.draw(&moved(&view, shift)).unwrap();
        let back = check(&mut bench, "back", &view).points;
        let equal = |(a, b): (&DVec3, &DVec3)| a == b || (a.is_nan() && b.is_nan());
        assert!(home.iter().zip(&back).all(equal), "after a jump by {shift}");
    }
}
