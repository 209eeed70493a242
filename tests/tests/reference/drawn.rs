//! What the GPU draws against the reference.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::{DVec2, DVec3, dvec3};
use terrain_core::dataset::{Dataset, TileSource};
use terrain_core::gpu::{OFFSCREEN_FORMAT, OffscreenTarget};
use terrain_core::prepare::{NoProgress, PrepareRequest, prepare};
use terrain_core::reference::{ReferenceScene, ReferenceSettings};
use terrain_core::{CameraView, RendererSettings, TerrainRenderer};
use terrain_tests::{AnalyticSource, Picture, RasterFixture, Surface, gpu};

use super::{ROOT_M, demo, differences, himalaya, mean, prepared, take};

fn jotunheimen() -> Option<(tempfile::TempDir, Arc<Dataset>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data");
    let dem = folder.join("jotunheimen_dem_512.tif");
    if !dem.exists() {
        println!("SKIPPED: {} is not there", dem.display());
        return None;
    }
    Some(prepared(dem, folder.join("jotunheimen_map_4096.jpg"), None))
}

/// The GPU's picture and ground coordinates, settled, of fine triangles.
fn drawn(
    source: Arc<dyn TileSource>,
    view: &CameraView,
    exaggeration: f64,
) -> Option<(Vec<[u8; 4]>, Vec<DVec3>)> {
    let gpu = gpu()?;
    let settings = RendererSettings {
        triangle_px: 2.0,
        anisotropy: 16,
        vertical_exaggeration: exaggeration,
        cache_columns: 12,
        cache_rows: 12,
        max_tiles: 144,
        ..Default::default()
    };
    let mut renderer = TerrainRenderer::new(Arc::clone(&gpu), source, settings).unwrap();
    let target = OffscreenTarget::new(&gpu, view.viewport_px);
    renderer.render_settled(view, target.view(), OFFSCREEN_FORMAT).unwrap();
    gpu.wait().unwrap();
    let picture = Picture::read(&gpu, &target).unwrap();
    let (pixels, _) = picture.rgba.as_chunks::<4>();
    let points = renderer.ground_coordinates(view).unwrap();
    Some((pixels.to_vec(), points.into_iter().map(DVec3::from_array).collect()))
}

/// Bounds on how the GPU's answers differ from the reference's: the mean of the colours' steps, the
/// part of pixels of which one has ground and the other sky, and for 99 % of the pixels away from
/// silhouettes the distance, in pixels, between where both see the ground.
struct Agreement {
    mean_steps: f64,
    sky_part: f64,
    p99_px: f64,
}

fn check_agreement(
    name: &str,
    dataset: Arc<dyn TileSource>,
    view: &CameraView,
    exaggeration: f64,
    bounds: &Agreement,
) {
    let Some((pixels, points)) = drawn(Arc::clone(&dataset), view, exaggeration) else { return };
    let scene = ReferenceScene::open(dataset).unwrap();
    let settings = ReferenceSettings { vertical_exaggeration: exaggeration, ..Default::default() };
    let seen = take(&scene, view, &settings);
    let mean_steps = mean(&differences(&pixels, &seen.rgba));
    let pairs = || points.iter().zip(&seen.coordinates).zip(&seen.silhouette);
    let unlike = pairs().filter(|((a, b), _)| a.is_nan() != b.is_nan()).count();
    let sky_part = unlike as f64 / points.len() as f64;
    // Seen from the eye both lie behind one pixel; the difference is the height at the same place.
    let mut offsets_px: Vec<f64> = pairs()
        .filter(|((a, b), is_edge)| !a.is_nan() && !b.is_nan() && !**is_edge)
        .filter_map(|((drawn, _), _)| {
            let true_m = scene.height_m(drawn.truncate())? * exaggeration;
            let shifted = view.pixel_from_world(drawn.truncate().extend(true_m))?;
            let place = view.pixel_from_world(*drawn)?;
            Some((shifted[0] - place[0]).hypot(shifted[1] - place[1]))
        })
        .collect();
    offsets_px.sort_by(f64::total_cmp);
    let p99_px = offsets_px[offsets_px.len() * 99 / 100];
    println!("{name}: colours {mean_steps:.3} steps, sky {sky_part:.5}, p99 {p99_px:.3} px");
    assert!(mean_steps < bounds.mean_steps, "{name}: {mean_steps} steps");
    assert!(sky_part < bounds.sky_part, "{name}: sky {sky_part}");
    assert!(p99_px < bounds.p99_px, "{name}: {p99_px} px");
}

#[test]
fn smooth_ground_is_drawn_as_the_reference_has_it() {
    let hills = Surface {
        height_m: |p| 200.0 * (p.x / 1_500.0).sin() * (p.y / 2_100.0).cos(),
        colour: |p| {
            let wave = 0.5 + 0.5 * (p.x / 3_000.0).sin() * (p.y / 2_500.0).sin();
            [(60.0 + 150.0 * wave) as u8, 120, (200.0 - 150.0 * wave) as u8]
        },
    };
    let source = Arc::new(AnalyticSource::new(hills, DVec2::ZERO, ROOT_M, [5, 4]));
    let eye = dvec3(-500.0, -6_000.0, 900.0);
    let view = CameraView { eye, pitch_deg: -12.0, viewport_px: [320, 180], ..himalaya() };
    let bounds = Agreement { mean_steps: 0.5, sky_part: 0.003, p99_px: 0.1 };
    check_agreement("hills", source, &view, 1.0, &bounds);
}

#[test]
fn the_demo_is_drawn_as_the_reference_has_it() {
    let (_folder, dataset) = demo();
    let view = CameraView { viewport_px: [320, 180], ..himalaya() };
    let bounds = Agreement { mean_steps: 4.0, sky_part: 0.003, p99_px: 1.0 };
    check_agreement("demo", dataset, &view, 15.0, &bounds);
}

#[test]
fn real_mountains_are_drawn_as_the_reference_has_them() {
    let Some((_folder, dataset)) = jotunheimen() else { return };
    let eye = dvec3(463_500.0, 6_820_000.0, 2_500.0);
    let view = CameraView {
        eye,
        heading_deg: 215.0,
        pitch_deg: -12.0,
        viewport_px: [320, 180],
        ..himalaya()
    };
    let bounds = Agreement { mean_steps: 1.5, sky_part: 0.01, p99_px: 0.5 };
    check_agreement("Jotunheimen", dataset, &view, 1.0, &bounds);
}

#[test]
fn ground_without_imagery_and_ground_without_data_are_drawn_as_the_reference_has_them() {
    let folder = tempfile::tempdir().unwrap();
    let [dem, out] = ["dem.tif", "dataset"].map(|name| folder.path().join(name));
    // Hills of 300 m with a hole of 40 x 30 cells, in which there is nothing to see.
    let height_m = |row: u32, column: u32| {
        let is_hole = (100..130).contains(&row) && (80..120).contains(&column);
        let (x, y) = (f64::from(column) / 30.0, f64::from(row) / 40.0);
        if is_hole { f32::NAN } else { (150.0 * x.sin() * y.cos() + 150.0) as f32 }
    };
    let places = (0..200).flat_map(|row| (0..240).map(move |column| (row, column)));
    let heights_m: Vec<f32> = places.map(|(row, column)| height_m(row, column)).collect();
    let raster = RasterFixture::utm([240, 200], [500_000.0, 6_800_000.0], 50.0);
    raster.write_f32(&dem, &heights_m).unwrap();
    let request =
        PrepareRequest { keep_voids: true, ..PrepareRequest::new(vec![dem], vec![], out) };
    prepare(&request, &NoProgress, &AtomicBool::new(false)).unwrap();
    let dataset = Arc::new(Dataset::open(&request.out).unwrap());
    let eye = dvec3(505_000.0, 6_791_000.0, 1_800.0);
    let view = CameraView {
        eye,
        pitch_deg: -25.0,
        viewport_px: [320, 180],
        heading_deg: 0.0,
        ..himalaya()
    };
    let hole = view.pixel_from_world(dvec3(505_000.0, 6_794_250.0, 0.0)).unwrap();
    let scene = ReferenceScene::open(dataset.clone()).unwrap();
    assert!(scene.first_hit(eye, view.ray_direction(hole[0], hole[1]), 1.0).is_none());
    let bounds = Agreement { mean_steps: 0.8, sky_part: 0.005, p99_px: 0.2 };
    check_agreement("hills with a hole", dataset, &view, 1.0, &bounds);
}
