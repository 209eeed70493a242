//! Clipmaps: what their pictures, bytes and windows promise.

#![allow(clippy::unwrap_used, reason = "a step that fails fails the test")]
#![allow(clippy::print_stdout, reason = "measured values are to be seen")]

use std::sync::Arc;
use std::time::Duration;

use glam::{DVec2, DVec3, dvec2};
use terrain_core::dataset::TileSource;
use terrain_core::gpu::{GpuContext, OFFSCREEN_FORMAT, OffscreenTarget};
use terrain_core::measure::FrameRecord;
use terrain_core::selection::Strategy;
use terrain_core::{CameraView, RendererSettings, TerrainRenderer};
use terrain_tests::{AnalyticSource, Picture, Reluctant, Surface, gpu};

const SIZE_PX: [u32; 2] = [320, 180];
const ROOT_M: f64 = 65_536.0;

/// Mountains with a pattern on them that shows which level a place is drawn from.
fn hills() -> Surface {
    Surface {
        height_m: |p| {
            900.0 * (p.x / 4000.0).sin() * (p.y / 5000.0).cos() + 200.0 * (p.x / 900.0).sin()
        },
        colour: |p| {
            let waves = (p.x / 37.0).sin() * (p.y / 53.0).cos() + (p.x / 610.0).sin();
            [(140.0 + 40.0 * waves) as u8, 130, (50.0 - 15.0 * waves) as u8]
        },
    }
}

fn source_at(centre: DVec2) -> Arc<AnalyticSource> {
    Arc::new(AnalyticSource::new(hills(), centre, ROOT_M, [6, 6]))
}

fn settings() -> RendererSettings {
    RendererSettings {
        strategy: Strategy::Clipmap,
        upload_budget_bytes: 64 << 20,
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
        self.renderer.render_settled(view, self.target.view(), OFFSCREEN_FORMAT).unwrap()
    }

    fn picture(&mut self, view: &CameraView) -> Picture {
        self.settle(view);
        self.shown()
    }

    fn shown(&self) -> Picture {
        Picture::read(&self.gpu, &self.target).unwrap()
    }
}

/// Mean and greatest difference of the values of two pictures, of 255.
fn difference(a: &Picture, b: &Picture) -> (f64, u8) {
    let differences = a.rgba.iter().zip(&b.rgba).map(|(a, b)| a.abs_diff(*b));
    let sum = differences.clone().map(f64::from).sum::<f64>();
    (sum / a.rgba.len() as f64, differences.max().unwrap_or(0))
}

fn assert_same(a: &Picture, b: &Picture) {
    let (_, most) = difference(a, b);
    let count = a.rgba.iter().zip(&b.rgba).filter(|(a, b)| a != b).count();
    assert!(most <= 1, "the pictures differ by up to {most} of 255");
    assert!(count * 1_000 <= a.rgba.len(), "the pictures differ in {count} values");
}

#[test]
fn the_picture_is_that_of_the_tiles() {
    // Where filters are to be as sharp as they can be, how levels are chosen matters least.
    let filtered = RendererSettings { anisotropy: 8, ..settings() };
    let Some(mut clipmap) = Bench::new(source_at(DVec2::ZERO), filtered) else { return };
    let roomy = RendererSettings {
        strategy: Strategy::RttQuadtree,
        cache_columns: 12,
        cache_rows: 12,
        max_tiles: 144,
        ..filtered
    };
    let Some(mut tiles) = Bench::new(source_at(DVec2::ZERO), roomy) else { return };
    for view in [
        view(20.0, -18.0, 2_500.0),
        view(200.0, -5.0, 1_300.0),
        view(95.0, -60.0, 6_000.0),
        view(0.0, -90.0, 40_000.0),
    ] {
        let (mean, most) = difference(&clipmap.picture(&view), &tiles.picture(&view));
        println!("heading {}: mean {mean:.3} of 255, at most {most}", view.heading_deg);
        // Filters between levels differ; places do not.
        assert!(mean < 1.5, "{mean} of 255 in the mean");
    }
}

/// Draws the view's coordinates and gives the distances of the answers from their pixels' centres and,
/// in pixels there, from the true surface: the 99th percentile and the greatest.
fn place_errors(
    source: &Arc<AnalyticSource>,
    triangle_px: f64,
    view: &CameraView,
) -> Option<(f64, [f64; 2])> {
    let settings = RendererSettings { triangle_px, ..settings() };
    let mut bench = Bench::new(Arc::clone(source) as _, settings)?;
    let points = bench.renderer.ground_coordinates(view).unwrap();
    let (mut place_px, mut heights_px) = (0.0_f64, Vec::new());
    for (index, point) in points.iter().map(|&point| DVec3::from_array(point)).enumerate() {
        if point.is_nan() {
            continue;
        }
        let width = view.viewport_px[0] as usize;
        let centre = dvec2((index % width) as f64 + 0.5, (index / width) as f64 + 0.5);
        place_px =
            place_px.max(DVec2::from(view.pixel_from_world(point).unwrap()).distance(centre));
        // Ground ends level within its outermost texels, which are large far away; the formula goes on.
        let extent = bench.renderer.tree().data_extent;
        let to_edge = (point.truncate() - extent.min).min(extent.max - point.truncate());
        if to_edge.min_element() < 3_000.0 {
            continue;
        }
        let footprint_m = point.distance(view.eye) * view.pixel_angle_rad();
        heights_px.push((point.z - source.height_m(point.truncate())).abs() / footprint_m);
    }
    assert!(heights_px.len() > 10_000, "{} pixels of ground", heights_px.len());
    heights_px.sort_by(f64::total_cmp);
    let part = |part: f64| heights_px[((heights_px.len() - 1) as f64 * part) as usize];
    Some((place_px, [part(0.99), part(1.0)]))
}

#[test]
fn a_plane_is_met_within_a_hundredth_of_a_pixel_near_and_far_and_at_far_origins() {
    let plane =
        || Surface { height_m: |p| 300.0 + 0.05 * p.x - 0.02 * p.y, colour: |_| [128, 128, 128] };
    let at = |x: f64, y: f64, z: f64, heading_deg: f64, pitch_deg: f64| CameraView {
        eye: DVec3::new(x, y, z),
        heading_deg,
        pitch_deg,
        ..view(0.0, 0.0, 0.0)
    };
    for centre in [DVec2::ZERO, dvec2(10_000_000.0, -10_000_000.0)] {
        let source = Arc::new(AnalyticSource::new(plane(), centre, ROOT_M, [7, 5]));
        for view in [
            at(0.0, 0.0, 320.0, 45.0, -10.0),
            at(100.0, -200.0, 2_000.0, 200.0, -30.0),
            at(-500.0, 0.0, 60_000.0, 0.0, -89.0),
        ] {
            let view = CameraView { eye: view.eye + centre.extend(0.0), ..view };
            let Some((place_px, [_, worst])) = place_errors(&source, 10.0, &view) else { return };
            assert!(place_px < 0.01 && worst < 0.01, "{view:?}: {place_px} px, {worst} px");
        }
    }
}

#[test]
fn a_cone_is_met_within_a_part_of_a_pixel() {
    let cone = Surface {
        height_m: |p| 2000.0 - 0.3 * (p.length_squared() + 4.0e4).sqrt().min(6_000.0),
        colour: |_| [128, 128, 128],
    };
    let source = Arc::new(AnalyticSource::new(cone, DVec2::ZERO, ROOT_M, [7, 5]));
    for (triangle_px, p99_bound, worst_bound) in [(10.0, 0.5, 1.0), (2.0, 0.1, 0.25)] {
        let view = CameraView { eye: DVec3::new(0.0, -9_000.0, 2_500.0), ..view(0.0, -12.0, 0.0) };
        let Some((place_px, [p99, worst])) = place_errors(&source, triangle_px, &view) else {
            return;
        };
        println!("cone, triangles of {triangle_px} px: p99 {p99:.4} px, worst {worst:.4} px");
        assert!(place_px < 0.01, "{place_px} px");
        assert!(p99 < p99_bound && worst < worst_bound, "p99 {p99} px, worst {worst} px");
    }
}

#[test]
fn a_still_camera_costs_nothing_and_a_turning_one_no_texels() {
    let Some(mut bench) = Bench::new(source_at(DVec2::ZERO), settings()) else { return };
    let still = view(20.0, -18.0, 2_500.0);
    let settled = bench.settle(&still);
    assert_eq!(settled.strategy, "clipmap");
    assert_eq!((settled.tiles_missing, settled.readback_bytes), (0, 0));
    assert!(!bench.renderer.needs_frame(&still), "a window need not draw again");
    let first = bench.shown();
    let record = bench.frame(&still);
    assert_eq!((record.upload_bytes, record.disk_bytes, record.tiles_new), (0, 0, 0));
    assert!(bench.shown() == first, "the picture changed");
    for heading in 1..12 {
        let turned = view(20.0 + 30.0 * f64::from(heading), -18.0, 2_500.0);
        assert!(bench.renderer.needs_frame(&turned));
        let record = bench.frame(&turned);
        assert_eq!((record.upload_dem_bytes, record.upload_dom_bytes), (0, 0), "{record:?}");
        assert_eq!((record.disk_bytes, record.upload_table_bytes), (0, 0), "{record:?}");
        assert!(record.upload_mesh_bytes < 4_000, "{record:?}");
        assert!(!bench.renderer.needs_frame(&turned));
    }
}

/// Of windows that move, only the texels that are new are sent: by arithmetic over all levels.
#[test]
fn a_moving_camera_sends_the_texels_its_windows_newly_cover() {
    let Some(mut bench) = Bench::new(source_at(DVec2::ZERO), settings()) else { return };
    let level = view(0.0, -18.0, 1_500.0);
    bench.settle(&level);
    // East by 4 texels of the finest imagery, 5.33 m each, and so on; windows follow in whole steps of 4.
    let texel_m = ROOT_M / (384.0 * 32.0);
    let steps = 48;
    let mut sent = [0, 0];
    for step in 1..=steps {
        let east = f64::from(step) * 4.0 * texel_m;
        let moved = CameraView { eye: level.eye + dvec2(east, 0.0).extend(0.0), ..level };
        let record = bench.settle(&moved);
        sent[0] += record.upload_dem_bytes;
        sent[1] += record.upload_dom_bytes;
    }
    // 4 / (2 tan(25 degrees) / 180) = 772 texels ask for windows of 768 texels of imagery at 4 bytes and
    // of 256 heights at 4 bytes.
    let windows = |count: f64, side: f64| {
        // Levels 0 and 1 are there as a whole; of the others each covers half the ground of the one before.
        (2..6).map(|level| count / 2.0_f64.powi(5 - level) * side * 4.0).sum::<f64>()
    };
    let texels = f64::from(4 * steps);
    let expected = [windows(texels / 3.0, 256.0), windows(texels, 768.0)];
    println!("{} and {} bytes where {expected:?} were expected", sent[0], sent[1]);
    // Whole steps of each level: coarse levels may be a step behind or ahead. Heights bring their jobs.
    for (sent, expected) in sent.into_iter().zip(expected) {
        let ratio = sent as f64 / expected;
        assert!((0.85..1.2).contains(&ratio), "{sent} bytes where {expected} were expected");
    }
}

#[test]
fn the_picture_depends_neither_on_the_way_there_nor_on_where_the_data_lies() {
    let low = view(20.0, -18.0, 2_500.0);
    let Some(mut bench) = Bench::new(source_at(DVec2::ZERO), settings()) else { return };
    let fresh = bench.picture(&low);
    for away in [
        CameraView { eye: low.eye + DVec3::new(4_000.0, 1_000.0, 0.0), ..low },
        view(0.0, -70.0, 60_000.0),
        CameraView { eye: low.eye + DVec3::new(-1.0e7, 4.0e6, 0.0), ..low },
        CameraView { fov_y_deg: 12.0, ..low },
    ] {
        // One frame only: the next view comes before anything has been answered.
        bench.frame(&away);
        assert_same(&fresh, &bench.picture(&low));
    }
    let far = dvec2(10_000_000.0, -10_000_000.0);
    let moved = CameraView { eye: low.eye + far.extend(0.0), ..low };
    let mut bench = Bench::new(source_at(far), settings()).unwrap();
    assert_same(&fresh, &bench.picture(&moved));
}

/// Pixels that are not ground: ground is greener or redder than blue here, what lies behind it blue.
fn holes(picture: &Picture) -> usize {
    let is_hole = |pixel: &[u8]| pixel[2] > pixel[0] && pixel[2] > pixel[1];
    picture.rgba.chunks_exact(4).filter(|pixel| is_hole(pixel)).count()
}

#[test]
fn there_is_never_a_hole_however_late_the_tiles_and_small_the_budget() {
    let down = view(0.0, -90.0, 6_000.0);
    for (refuses, upload_budget_bytes) in [(true, 64 << 20), (false, 0), (false, 300_000)] {
        let source = Reluctant::new(source_at(DVec2::ZERO), refuses);
        let settings = RendererSettings { upload_budget_bytes, ..settings() };
        let Some(mut bench) = Bench::new(source.clone(), settings) else { return };
        for frame in 0..30 {
            let record = bench.frame(&down);
            assert_eq!(holes(&bench.shown()), 0, "frame {frame}");
            assert!(refuses || record.tiles_missing > 0, "frame {frame}: nothing is late");
            // A strip a layer goes through whatever the budget; level 0 is one.
            let texels = record.upload_dem_bytes + record.upload_dom_bytes;
            assert!(texels <= upload_budget_bytes + 700_000, "{texels} bytes in frame {frame}");
            if frame > 8 {
                source.release();
                std::thread::sleep(Duration::from_millis(2));
            }
        }
        assert_eq!(holes(&bench.picture(&down)), 0);
        assert!(!bench.renderer.needs_frame(&down), "what failed is not asked for for ever");
        assert_eq!(!bench.renderer.take_failures().is_empty(), refuses);
    }
}

#[test]
fn the_edge_of_the_data_and_voids_are_left_out() {
    let island = Surface {
        height_m: |p| if p.length() < 9_000.0 { 200.0 } else { f64::NAN },
        colour: |_| [120, 140, 60],
    };
    let source = Arc::new(AnalyticSource::new(island, DVec2::ZERO, ROOT_M, [6, 6]));
    let Some(mut bench) = Bench::new(source, settings()) else { return };
    let down = CameraView { eye: DVec3::new(0.0, 0.0, 26_000.0), ..view(0.0, -90.0, 0.0) };
    let picture = bench.picture(&down);
    // The island's outline against a circle: its radius in pixels.
    let radius_px = 9_000.0 / (25_800.0 * down.pixel_angle_rad());
    let mut wrong = 0;
    for (index, pixel) in picture.rgba.chunks_exact(4).enumerate() {
        let width = SIZE_PX[0] as usize;
        let from_centre = dvec2(
            (index % width) as f64 + 0.5 - 0.5 * f64::from(SIZE_PX[0]),
            (index / width) as f64 + 0.5 - 0.5 * f64::from(SIZE_PX[1]),
        );
        let is_ground = pixel[1] > pixel[2];
        let to_shore = from_centre.length() - radius_px;
        wrong += usize::from(to_shore.abs() > 2.0 && is_ground != (to_shore < 0.0));
    }
    assert_eq!(wrong, 0, "pixels on the wrong side of the shore");
    let points = bench.renderer.ground_coordinates(&down).unwrap();
    let on_land = |point: &[f64; 3]| dvec2(point[0], point[1]).length() < 9_100.0;
    assert!(points.iter().filter(|point| !point[0].is_nan()).all(on_land));
}

#[test]
fn drawing_beside_the_frames_leaves_no_trace() {
    let Some(mut bench) = Bench::new(source_at(DVec2::ZERO), settings()) else { return };
    let here = view(20.0, -18.0, 2_500.0);
    let picture = bench.picture(&here);
    let other = view(140.0, -40.0, 9_000.0);
    bench.renderer.drawn_coordinates(&other).unwrap();
    bench.renderer.redraw(&other, bench.target.view(), OFFSCREEN_FORMAT).unwrap();
    assert!(!bench.renderer.needs_frame(&here));
    let record = bench.frame(&here);
    assert_eq!(record.upload_bytes, 0, "{record:?}");
    assert!(bench.shown() == picture);
}
