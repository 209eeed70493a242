//! Heights at and beyond the limits of their types: none reaches a pixel as NaN.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::{DVec2, DVec3, dvec2};
use terrain_core::dataset::{Dataset, TileSource};
use terrain_core::gpu::GpuContext;
use terrain_core::prepare::{NoProgress, PrepareRequest, prepare};
use terrain_core::selection::Strategy;
use terrain_core::{CameraView, RendererSettings};
use terrain_tests::{AnalyticSource, Bench, RasterFixture, Ridges, Surface};

use crate::drawn::check;

fn view(eye: DVec3, heading_deg: f64, pitch_deg: f64) -> CameraView {
    CameraView { eye, viewport_px: [96, 54], ..Ridges::view(heading_deg, pitch_deg, 0.0) }
}

pub fn heights_at_the_limits_of_their_types(gpu: &Arc<GpuContext>, strategy: Strategy) {
    fn half(p: DVec2, west_m: f64, east_m: f64) -> f64 {
        if p.x < 0.0 { west_m } else { east_m }
    }
    type Height = fn(DVec2) -> f64;
    let surfaces: [(&str, Height); 5] = [
        ("the range of 16-bit integers", |p| half(p, -32_768.0, 32_767.0)),
        ("the largest floats", |p| half(p, f64::from(f32::MIN), f64::from(f32::MAX))),
        ("what is no height", |p| {
            // The last is the usual mark of a void.
            let none = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -3.402_823_466e38];
            half(p, none[(p.y / 2_000.0).floor().rem_euclid(4.0) as usize], 10.0)
        }),
        ("no data at all", |_| f64::NAN),
        ("denormals", |p| half(p, 1.0e-40, -1.0e-40)),
    ];
    for (what, height_m) in surfaces {
        let surface = Surface { height_m, colour: |_| [120, 130, 90] };
        let source = AnalyticSource::new(surface, DVec2::ZERO, Ridges::ROOT_M, [4, 3]);
        let settings = RendererSettings { strategy, ..Default::default() };
        let mut bench = Bench::on(gpu, Arc::new(source), settings).unwrap();
        for (x, heading_deg, pitch_deg) in
            [(4_000.0, -60.0, -18.0), (-4_000.0, 60.0, -18.0), (500.0, 0.0, -90.0)]
        {
            check(&mut bench, what, &view(DVec3::new(x, 0.0, 2_500.0), heading_deg, pitch_deg));
        }
    }
}

pub fn a_dem_full_of_numbers_that_are_no_heights(gpu: &Arc<GpuContext>, strategy: Strategy) {
    let oddities = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN, 1.0e-40, -0.0];
    let fixture = RasterFixture::utm([200, 160], [500_000.0, 6_800_000.0], 30.0);
    let height_m = |i: usize| {
        if i.is_multiple_of(3) { oddities[i / 3 % 7] } else { 500.0 + (i % 200) as f32 }
    };
    let heights = (0..200 * 160).map(height_m).collect::<Vec<_>>();
    let folder = tempfile::tempdir().unwrap();
    let (dem, out) = (folder.path().join("dem.tif"), folder.path().join("dataset"));
    fixture.write_f32(&dem, &heights).unwrap();
    let request = PrepareRequest::new(vec![dem], Vec::new(), out.clone());
    prepare(&request, &NoProgress, &AtomicBool::new(false)).unwrap();
    let dataset = Dataset::open(&out).unwrap();
    let range = dataset.manifest().heights.range;
    assert!(range.min_m.abs() < 1.0 && (range.max_m - 699.0).abs() < 1.0, "{range:?}");
    assert!(dataset.manifest().heights.has_voids);
    let settings = RendererSettings { strategy, ..Default::default() };
    let mut bench = Bench::on(gpu, Arc::new(dataset), settings).unwrap();
    let eye = dvec2(503_000.0, 6_797_600.0).extend(2_000.0);
    for pitch_deg in [-5.0, -90.0] {
        check(&mut bench, "from a file", &view(eye, 20.0, pitch_deg));
    }
}
