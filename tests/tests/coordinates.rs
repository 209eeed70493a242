//! The coordinates the GPU gives for each pixel, against the finest samples of real data.

#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a step that fails fails the test")]
#![allow(clippy::print_stdout, reason = "measured values are to be seen")]

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::{DVec2, DVec3, dvec2};
use terrain_core::dataset::{Dataset, HeightTile, TileSource};
use terrain_core::prepare::{NoProgress, PrepareRequest, prepare};
use terrain_core::tiling::TileId;
use terrain_core::{CameraView, RendererSettings, TerrainRenderer};
use terrain_tests::gpu;

/// How far the answers are from the truth, in pixels.
#[derive(Debug, Default)]
struct Errors {
    ground_pixels: usize,
    /// Largest distance of an answer's place in the picture from its pixel's centre.
    place_px: f64,
    /// Vertical distances from the surface over the size of a pixel there, sorted.
    heights_px: Vec<f64>,
}

impl Errors {
    fn height_px(&self, part: f64) -> f64 {
        let index = ((self.heights_px.len() - 1) as f64 * part) as usize;
        self.heights_px[index]
    }
}

/// Draws the view's coordinates and holds each against the true height at its place.
fn measure(
    source: Arc<dyn TileSource>,
    true_height_m: &mut dyn FnMut(DVec2) -> Option<f64>,
    triangle_px: f64,
    view: CameraView,
) -> Option<Errors> {
    let settings = RendererSettings { triangle_px, ..Default::default() };
    let mut renderer = TerrainRenderer::new(gpu()?, source, settings).unwrap();
    let points = renderer.ground_coordinates(&view).unwrap();
    let mut errors = Errors::default();
    for (index, point) in points.iter().map(|&point| DVec3::from_array(point)).enumerate() {
        if point.is_nan() {
            continue;
        }
        let width = view.viewport_px[0] as usize;
        let expected = [(index % width) as f64 + 0.5, (index / width) as f64 + 0.5];
        let place = view.pixel_from_world(point).expect("seen points lie before the eye");
        errors.ground_pixels += 1;
        errors.place_px =
            errors.place_px.max((place[0] - expected[0]).hypot(place[1] - expected[1]));
        // A point on the very border may round to beyond it, where the true surface ends.
        let Some(height_m) = true_height_m(point.truncate()) else { continue };
        let footprint_m = point.distance(view.eye) * view.pixel_angle_rad();
        errors.heights_px.push((point.z - height_m).abs() / footprint_m);
    }
    errors.heights_px.sort_by(f64::total_cmp);
    Some(errors)
}

fn view(x: f64, y: f64, z: f64, heading_deg: f64, pitch_deg: f64) -> CameraView {
    let eye = DVec3::new(x, y, z);
    CameraView { eye, heading_deg, pitch_deg, fov_y_deg: 50.0, viewport_px: [320, 180] }
}

/// The surface as the finest level holds it: bilinear between its samples, in f64.
struct FinestLevel<'a> {
    dataset: &'a Dataset,
    tiles: HashMap<TileId, Option<HeightTile>>,
}

impl FinestLevel<'_> {
    fn height_m(&mut self, point: DVec2) -> Option<f64> {
        let manifest = self.dataset.manifest();
        let layout = manifest.heights.layout;
        let tile = manifest.scheme.tile_at(layout.finest_level(), point)?;
        let dataset = self.dataset;
        let loaded = self
            .tiles
            .entry(tile)
            .or_insert_with(|| dataset.load_heights(tile).ok().map(|loaded| loaded.tile));
        loaded.as_ref()?.height_at_m(&manifest.scheme, &layout, point)
    }
}

/// Prepares heights and draws their coordinates from a view given by the data's extent.
fn measure_file(
    heights: &Path,
    epsg: Option<u32>,
    triangle_px: f64,
    view_of: &dyn Fn(&Dataset) -> CameraView,
) -> Option<Errors> {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("dataset");
    let mut request = PrepareRequest::new(vec![heights.to_owned()], Vec::new(), out.clone());
    request.epsg = epsg;
    prepare(&request, &NoProgress, &AtomicBool::new(false)).unwrap();
    let dataset = Arc::new(Dataset::open(&out).unwrap());
    let view = view_of(&dataset);
    let mut finest = FinestLevel { dataset: &dataset, tiles: HashMap::new() };
    let source = Arc::clone(&dataset);
    measure(source, &mut |point| finest.height_m(point), triangle_px, view)
}

fn report(name: &str, errors: &Errors) {
    let [p50, p99, worst] = [0.5, 0.99, 1.0].map(|part| errors.height_px(part));
    println!("{name}: median {p50:.3} px, p99 {p99:.3} px, worst {worst:.3} px");
}

#[test]
fn the_demo_is_met_within_a_tenth_of_a_pixel_near_and_far() {
    let heights = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/demo/dem.tif");
    // Over the Himalaya: low, where one cell is many pixels, and high, where a pixel is a cell.
    for (name, height_m, pitch_deg, [p50_bound, p99_bound]) in
        [("low", 30_000.0, -20.0, [0.01, 0.05]), ("high", 1_000_000.0, -45.0, [0.01, 0.1])]
    {
        let eye = dvec2(9_400_000.0, 3_000_000.0).extend(height_m);
        let view = CameraView { eye, pitch_deg, ..view(0.0, 0.0, 0.0, 0.0, 0.0) };
        let Some(errors) = measure_file(&heights, Some(3395), 2.0, &|_| view) else { return };
        report(name, &errors);
        assert!(errors.ground_pixels > 10_000 && errors.place_px < 0.01, "{errors:?}");
        let (p50, p99) = (errors.height_px(0.5), errors.height_px(0.99));
        assert!(p50 < p50_bound && p99 < p99_bound, "{name}: median {p50} px, p99 {p99} px");
    }
}

#[test]
fn real_mountains_in_their_own_grid_are_met_within_a_part_of_a_pixel() {
    let heights =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/jotunheimen_dem_512.tif");
    if !heights.exists() {
        println!("SKIPPED: {} is not there", heights.display());
        return;
    }
    for (name, agl_m, pitch_deg, [p50_bound, p99_bound]) in
        [("low", 300.0, -5.0, [0.01, 0.2]), ("high", 20_000.0, -40.0, [0.1, 0.6])]
    {
        let view_of = |dataset: &Dataset| {
            let centre = dataset.manifest().data_extent.centre();
            let mut finest = FinestLevel { dataset, tiles: HashMap::new() };
            let ground_m = finest.height_m(centre).unwrap();
            let eye = centre.extend(ground_m + agl_m);
            CameraView { eye, pitch_deg, ..view(0.0, 0.0, 0.0, 20.0, 0.0) }
        };
        let Some(errors) = measure_file(&heights, None, 2.0, &view_of) else { return };
        report(name, &errors);
        assert!(errors.ground_pixels > 10_000 && errors.place_px < 0.01, "{errors:?}");
        let (p50, p99) = (errors.height_px(0.5), errors.height_px(0.99));
        assert!(p50 < p50_bound && p99 < p99_bound, "{name}: median {p50} px, p99 {p99} px");
    }
}
