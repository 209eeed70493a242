//! The mesh made on the CPU and sent as geometry: true to the ground, whole, within its budget, at rest
//! when the camera is.

#![allow(clippy::unwrap_used, reason = "a step that fails fails the test")]
#![allow(clippy::print_stdout, reason = "measured values are to be seen")]

use std::sync::Arc;

use glam::{DVec2, DVec3, dvec2, dvec3};
use terrain_core::dataset::{ColourTile, HeightTile, LoadError, Loaded, Manifest, TileSource};
use terrain_core::gpu::{GpuContext, OFFSCREEN_FORMAT, OffscreenTarget};
use terrain_core::measure::FrameRecord;
use terrain_core::selection::Strategy;
use terrain_core::tiling::{TileId, TileSet};
use terrain_core::{CameraView, DebugView, RendererSettings, TerrainRenderer};
use terrain_tests::{AnalyticSource, Picture, Surface, gpu};

const SIZE_PX: [u32; 2] = [320, 180];
const ROOT_M: f64 = 65_536.0;
/// Pixels that the ground may look off by, texels being drawn a pixel large.
const TOLERANCE_PX: f64 = 1.5;

fn height_m(p: DVec2) -> f64 {
    900.0 * (p.x / 4000.0).sin() * (p.y / 5000.0).cos() + 200.0 * (p.x / 900.0).sin()
}

fn hills() -> Surface {
    Surface {
        height_m,
        colour: |p| {
            let waves = (p.x / 137.0).sin() * (p.y / 253.0).cos() + (p.x / 610.0).sin();
            [(140.0 + 40.0 * waves) as u8, 130, (90.0 - 30.0 * waves) as u8]
        },
    }
}

/// [`hills`] with a round lake of no data before the camera.
fn lake() -> Surface {
    Surface {
        height_m: |p| if p.distance(LAKE) < LAKE_RADIUS_M { f64::NAN } else { height_m(p) },
        ..hills()
    }
}

const LAKE: DVec2 = dvec2(-1_500.0, -5_000.0);
const LAKE_RADIUS_M: f64 = 1_500.0;

fn source_at(surface: Surface, centre: DVec2) -> Arc<AnalyticSource> {
    Arc::new(AnalyticSource::new(surface, centre, ROOT_M, [6, 6]))
}

fn source() -> Arc<AnalyticSource> {
    source_at(hills(), DVec2::ZERO)
}

fn settings() -> RendererSettings {
    RendererSettings {
        strategy: Strategy::CpuMesh,
        cache_columns: 12,
        cache_rows: 12,
        max_tiles: 144,
        ..Default::default()
    }
}

fn view(heading_deg: f64, pitch_deg: f64, height_m: f64) -> CameraView {
    CameraView {
        eye: dvec2(-3_000.0, -9_000.0).extend(height_m),
        heading_deg,
        pitch_deg,
        fov_y_deg: 50.0,
        viewport_px: SIZE_PX,
    }
}

struct Bench {
    gpu: Arc<GpuContext>,
    renderer: TerrainRenderer,
    target: OffscreenTarget,
}

impl Bench {
    fn new(source: Arc<dyn TileSource>, settings: RendererSettings) -> Option<Self> {
        let gpu = gpu()?;
        let renderer = TerrainRenderer::new(Arc::clone(&gpu), source, settings).unwrap();
        let target = OffscreenTarget::new(&gpu, SIZE_PX);
        Some(Self { gpu, renderer, target })
    }

    fn frame(&mut self, view: &CameraView) -> FrameRecord {
        self.renderer.render(view, self.target.view(), OFFSCREEN_FORMAT).unwrap()
    }

    fn settle(&mut self, view: &CameraView) -> FrameRecord {
        let record =
            self.renderer.render_settled(view, self.target.view(), OFFSCREEN_FORMAT).unwrap();
        assert_eq!(record.tiles_missing, 0, "{record:?}");
        assert!(!self.renderer.needs_frame(view), "the camera never comes to rest");
        record
    }

    fn picture(&mut self, view: &CameraView) -> Picture {
        self.settle(view);
        Picture::read(&self.gpu, &self.target).unwrap()
    }

    fn points(&mut self, view: &CameraView) -> Vec<DVec3> {
        let points = self.renderer.ground_coordinates(view).unwrap();
        points.into_iter().map(DVec3::from_array).collect()
    }
}

/// Largest distance in pixels of the ground drawn from the true ground at the same place.
fn worst_error_px(points: &[DVec3], view: &CameraView, exaggeration: f64) -> f64 {
    let error_px = |point: &DVec3| {
        let true_m = height_m(point.truncate()) * exaggeration;
        let angle = (point.z - true_m).abs() / view.eye.distance(*point);
        angle / view.pixel_angle_rad()
    };
    points.iter().filter(|point| point.is_finite()).map(error_px).fold(0.0, f64::max)
}

/// The part of the values that differ by more than `steps`.
fn part_off(a: &Picture, b: &Picture, steps: u8) -> f64 {
    let off = a.rgba.iter().zip(&b.rgba).filter(|(a, b)| a.abs_diff(**b) > steps).count();
    off as f64 / a.rgba.len() as f64
}

#[test]
fn the_ground_drawn_is_the_ground_to_within_the_tolerance() {
    let Some(mut bench) = Bench::new(source(), settings()) else { return };
    for (heading_deg, pitch_deg, height_m) in [
        (20.0, -18.0, 2_500.0),
        (200.0, -5.0, 1_300.0),
        (95.0, -60.0, 6_000.0),
        (0.0, -90.0, 40_000.0),
    ] {
        let view = view(heading_deg, pitch_deg, height_m);
        let record = bench.settle(&view);
        let points = bench.points(&view);
        let error_px = worst_error_px(&points, &view, 1.0);
        println!(
            "{heading_deg} deg, {height_m} m: {} triangles, {error_px:.2} px",
            record.triangles_drawn
        );
        assert!(error_px < 1.05 * TOLERANCE_PX, "{error_px} px");
        assert!(record.triangles_drawn < 60_000, "{record:?}");
        // Each point lies in its pixel.
        for (index, point) in points.iter().enumerate().filter(|(_, point)| point.is_finite()) {
            let centre = dvec2((index % 320) as f64 + 0.5, (index / 320) as f64 + 0.5);
            let place = DVec2::from(view.pixel_from_world(*point).unwrap());
            assert!(place.distance(centre) < 1.0 / 16.0, "pixel {index}: {place}");
        }
    }
}

#[test]
fn the_picture_is_that_of_the_displaced_mesh_but_for_triangles() {
    let Some(mut mesh) = Bench::new(source(), settings()) else { return };
    let displaced =
        RendererSettings { strategy: Strategy::CpuFrustum, triangle_px: 4.0, ..settings() };
    let mut displaced = Bench::new(source(), displaced).unwrap();
    for view in [view(20.0, -18.0, 2_500.0), view(95.0, -60.0, 6_000.0)] {
        let part = part_off(&mesh.picture(&view), &displaced.picture(&view), 12);
        println!("{part} of the values are off by more than 12 of 255");
        assert!(part < 0.03, "{part}");
    }
}

#[test]
fn a_still_camera_sends_nothing_and_a_trembling_one_no_geometry() {
    let Some(mut bench) = Bench::new(source(), settings()) else { return };
    let still = view(20.0, -18.0, 2_500.0);
    let settled = bench.settle(&still);
    assert_eq!(settled.strategy, "cpu-mesh");
    assert!(settled.upload_mesh_bytes > 10_000 && settled.upload_dem_bytes == 0, "{settled:?}");
    let again = bench.frame(&still);
    assert_eq!((again.upload_bytes, again.disk_bytes, again.readback_bytes), (0, 0, 0));
    let mut moved = still;
    moved.eye += dvec3(4.0, 3.0, -1.0);
    bench.settle(&moved);
    for _ in 0..4 {
        for view in [still, moved] {
            assert_eq!(bench.settle(&view).upload_mesh_bytes, 0);
        }
    }
}

#[test]
fn flying_on_sends_a_little_of_the_mesh_within_the_budget() {
    let budget = 96 << 10;
    let Some(mut bench) =
        Bench::new(source(), RendererSettings { upload_budget_bytes: budget, ..settings() })
    else {
        return;
    };
    let at = |step: u32| {
        let mut view = view(20.0, -18.0, 2_500.0);
        view.eye += dvec3(10.0, 25.0, 0.0) * f64::from(step);
        view
    };
    // One tile of imagery always goes through; tables and uniforms are beside the budget.
    let most = budget + 392 * 392 * 4 + 40_000;
    let mut first = 0;
    for _ in 0..400 {
        let record = bench.frame(&at(0));
        assert!(record.upload_bytes < most, "{record:?}");
        first += record.upload_mesh_bytes;
        if !bench.renderer.needs_frame(&at(0)) {
            break;
        }
    }
    bench.settle(&at(0));
    let mut sent = 0;
    for step in 1..=40 {
        sent += bench.settle(&at(step)).upload_mesh_bytes;
    }
    println!("{first} bytes for the first view, {} for each of the next", sent / 40);
    assert!(sent / 40 < first / 50, "{sent} bytes after {first}");
    assert!(sent > 0);
}

#[test]
fn other_views_drawn_beside_leave_no_trace() {
    let Some(mut bench) = Bench::new(source(), settings()) else { return };
    let (first, other) = (view(20.0, -18.0, 2_500.0), view(200.0, -5.0, 1_300.0));
    let picture = bench.picture(&first);
    bench.renderer.redraw(&other, bench.target.view(), OFFSCREEN_FORMAT).unwrap();
    assert!(!bench.renderer.needs_frame(&first));
    let record = bench.frame(&first);
    assert_eq!((record.upload_mesh_bytes, record.upload_dom_bytes), (0, 0));
    assert!(Picture::read(&bench.gpu, &bench.target).unwrap() == picture);
}

#[test]
fn a_switch_to_the_mesh_and_back_draws_what_each_draws_alone() {
    let Some(mut bench) = Bench::new(source(), settings()) else { return };
    let view = view(20.0, -18.0, 2_500.0);
    let alone = bench.picture(&view);
    for strategy in [Strategy::CpuFrustum, Strategy::CpuMesh] {
        let settings = RendererSettings { strategy, ..*bench.renderer.settings() };
        bench.renderer.set_settings(settings).unwrap();
        assert!(bench.renderer.needs_frame(&view), "the switch shows at once");
        let record = bench.frame(&view);
        assert_eq!(record.strategy, strategy.name());
    }
    assert!(part_off(&bench.picture(&view), &alone, 1) < 1.0e-4);
}

#[test]
fn ground_without_data_is_left_out_and_no_other() {
    let Some(mut bench) = Bench::new(source_at(lake(), DVec2::ZERO), settings()) else { return };
    let view = view(15.0, -35.0, 3_000.0);
    let picture = bench.picture(&view);
    let points = bench.points(&view);
    let (mut land, mut water) = (0, 0);
    for (index, point) in points.iter().enumerate() {
        let [x, y] = [(index % 320) as f64 + 0.5, (index / 320) as f64 + 0.5];
        // Where the ray through the pixel meets the lake's plane, by arithmetic of the test's own.
        let ray = view.ray_direction(x, y);
        let on_lake = view.eye + ray * ((height_m(LAKE) - view.eye.z) / ray.z);
        let from_shore_m = on_lake.truncate().distance(LAKE) - LAKE_RADIUS_M;
        if point.is_finite() {
            land += 1;
            let inside_m = LAKE_RADIUS_M - point.truncate().distance(LAKE);
            // Half a texel of the tiles in use, and what the shore's triangles cut off.
            assert!(inside_m < 80.0, "ground {inside_m} m inside the lake");
        } else if from_shore_m < -600.0 && ray.z < 0.0 {
            water += 1;
        }
    }
    println!("{land} pixels of land, {water} of the lake");
    assert!(land > 20_000 && water > 500, "{land} and {water}");
    assert!(picture.rgba.chunks_exact(4).all(|pixel| pixel[3] == 255));
}

#[test]
fn the_picture_does_not_depend_on_where_on_earth_the_data_lies() {
    let Some(mut near) = Bench::new(source(), settings()) else { return };
    let far_away = dvec2(20_000_000.0, -8_388_608.0);
    let mut far = Bench::new(source_at(hills(), far_away), settings()).unwrap();
    let here = view(20.0, -18.0, 2_500.0);
    let there = CameraView { eye: here.eye + far_away.extend(0.0), ..here };
    assert!(part_off(&near.picture(&here), &far.picture(&there), 1) < 1.0e-3);
}

#[test]
fn a_change_of_exaggeration_and_of_detail_takes_hold() {
    let Some(mut bench) = Bench::new(source(), settings()) else { return };
    let view = view(20.0, -25.0, 9_000.0);
    let coarse = bench.settle(&view).triangles_drawn;
    let changed = RendererSettings {
        vertical_exaggeration: 3.0,
        texel_px: 0.5,
        ..*bench.renderer.settings()
    };
    bench.renderer.set_settings(changed).unwrap();
    let fine = bench.settle(&view).triangles_drawn;
    assert!(fine > 2 * coarse, "{fine} triangles after {coarse}");
    let error_px = worst_error_px(&bench.points(&view), &view, 3.0);
    assert!(error_px < 0.55 * TOLERANCE_PX, "{error_px} px");
}

#[test]
fn no_camera_is_too_strange() {
    let Some(mut bench) = Bench::new(source(), settings()) else { return };
    let at = |x: f64, y: f64, z: f64| CameraView { eye: dvec3(x, y, z), ..view(20.0, -18.0, 0.0) };
    let edge = 0.5 * ROOT_M;
    let wide = CameraView { fov_y_deg: 170.0, ..view(20.0, -18.0, 2_500.0) };
    let moon = CameraView { fov_y_deg: 1.0, pitch_deg: -90.0, ..at(0.0, 0.0, 4.0e8) };
    let views = [
        at(6_000.0, 0.0, -300.0),
        at(0.0, 0.0, -9_000.0),
        at(0.0, 0.0, 0.0),
        view(0.0, 90.0, 2_500.0),
        view(0.0, -90.0, 2_500.0),
        wide,
        at(edge, edge, 900.0),
        at(-edge - 1.0e-3, 0.0, 900.0),
        at(-1.0e6, 0.0, 900.0),
        moon,
    ];
    for view in views {
        let picture = bench.picture(&view);
        // Neither ground nor sky is black anywhere; NaN and infinity are.
        let black = picture.rgba.chunks_exact(4).filter(|pixel| pixel[..3] == [0; 3]).count();
        assert_eq!(black, 0, "{view:?}");
        let points = bench.points(&view);
        let whole = |p: &DVec3| p.is_finite() || p.to_array().iter().all(|c| c.is_nan());
        assert!(points.iter().all(whole), "{view:?}");
    }
    let debugged = [DebugView::TileBorders, DebugView::Levels, DebugView::Shading];
    for debug_view in debugged {
        let settings = RendererSettings { debug_view, wireframe: true, ..settings() };
        bench.renderer.set_settings(settings).unwrap();
        bench.settle(&view(20.0, -18.0, 2_500.0));
    }
}

/// A source whose height tiles of some level are damaged, and whose imagery is none.
struct Damaged {
    inner: Arc<AnalyticSource>,
    manifest: Manifest,
    no_colours: TileSet,
}

impl TileSource for Damaged {
    fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    fn heights_present(&self) -> &TileSet {
        self.inner.heights_present()
    }

    fn colours_present(&self) -> &TileSet {
        &self.no_colours
    }

    fn load_heights(&self, tile: TileId) -> Result<Loaded<HeightTile>, LoadError> {
        if tile.level == 3 {
            return Err(LoadError::Absent { path: "damaged".into(), tile });
        }
        self.inner.load_heights(tile)
    }

    fn load_colours(&self, tile: TileId) -> Result<Loaded<ColourTile>, LoadError> {
        Err(LoadError::Absent { path: "damaged".into(), tile })
    }
}

#[test]
fn tiles_that_cannot_be_loaded_are_named_and_leave_no_hole() {
    let inner = source();
    let manifest = Manifest { colours: None, ..inner.manifest().clone() };
    let damaged = Damaged { inner, manifest, no_colours: TileSet::new() };
    let Some(mut bench) = Bench::new(Arc::new(damaged), settings()) else { return };
    let view = view(20.0, -60.0, 4_000.0);
    bench.settle(&view);
    let failures = bench.renderer.take_failures();
    assert!(failures.iter().any(|failure| failure.contains("no tile 3/")), "{failures:?}");
    assert!(bench.points(&view).iter().all(|point| point.is_finite()), "there is a hole");
    bench.settle(&view);
    assert!(bench.renderer.take_failures().is_empty(), "what failed is tried again");
}
