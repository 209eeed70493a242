//! Ground made of triangles, drawn with a dataset's imagery: the picture against the exact one of the samples that the
//! triangles were made of. What it is off follows from the error that the triangles were allowed.

#![allow(clippy::unwrap_used, reason = "a step that fails fails the test")]
#![allow(clippy::print_stdout, reason = "measured values are to be seen")]

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::{DVec2, DVec3, dvec2};
use terrain_core::measure::error::{DEFAULT_PIXELS_PER_DEGREE, flip_errors, percentile};
use terrain_core::reference::{
    ReferencePicture, ReferenceScene, ReferenceSettings, render_reference,
};
use terrain_core::surface::models::Model;
use terrain_core::surface::tin::{GlbPlace, SampleGrid, TinGround, tin_of_grid, write_glb};
use terrain_core::tiling::Extent;
use terrain_core::{AntiAliasing, CameraView, NoProgress, RendererSettings};
use terrain_tests::{AnalyticSource, Bench, Surface};

const SIZE_PX: [u32; 2] = [320, 180];
const ROOT_M: f64 = 4_096.0;
const SAMPLES: usize = 256;

fn height_m(p: DVec2) -> f64 {
    500.0 + 120.0 * (p.x / 260.0).sin() * (p.y / 330.0).cos() + 25.0 * (p.x / 90.0).cos()
}

/// Ground of samples 16 m apart.
fn source() -> Arc<AnalyticSource> {
    let colour = |p: DVec2| {
        let waves = (p.x / 37.0).sin() * (p.y / 53.0).cos();
        [(140.0 + 60.0 * waves) as u8, 130, (90.0 - 50.0 * waves) as u8]
    };
    Arc::new(AnalyticSource::new(Surface { height_m, colour }, DVec2::ZERO, ROOT_M, [2, 3]))
}

/// The same samples as triangles within an error, written and read back.
fn tin(max_error_m: f64) -> Arc<TinGround> {
    let step = DVec2::splat(ROOT_M / SAMPLES as f64);
    let first = dvec2(-0.5, 0.5) * (ROOT_M - step.x);
    let place =
        |index: usize| first + step * dvec2((index % SAMPLES) as f64, -((index / SAMPLES) as f64));
    let heights_m =
        (0..SAMPLES * SAMPLES).map(|index| height_m(place(index)) as f32).collect::<Vec<_>>();
    let grid = SampleGrid { columns: SAMPLES, rows: SAMPLES, heights_m: &heights_m, first, step };
    let tin = tin_of_grid(&grid, max_error_m, &[], &mut |_, _| true).unwrap();
    let extent = Extent::new(-first.abs(), first.abs());
    let place = GlbPlace { crs: None, metres_per_unit: DVec2::ONE, extent };
    let file = write_glb(&tin, &place).unwrap();
    let model = Model::from_bytes(&file, Path::new("tin.glb")).unwrap();
    Arc::new(TinGround::of_model(&model).unwrap())
}

fn view(heading_deg: f64, pitch_deg: f64, height_m: f64) -> CameraView {
    CameraView {
        eye: dvec2(-300.0, -1_400.0).extend(height_m),
        heading_deg,
        pitch_deg,
        fov_y_deg: 50.0,
        viewport_px: SIZE_PX,
    }
}

fn settings() -> RendererSettings {
    RendererSettings {
        cache_columns: 12,
        cache_rows: 12,
        max_tiles: 144,
        anisotropy: 16,
        anti_aliasing: AntiAliasing::FourSamples,
        ..Default::default()
    }
}

fn exact(view: &CameraView) -> ReferencePicture {
    let scene = ReferenceScene::open(source()).unwrap();
    let settings = ReferenceSettings::default();
    render_reference(&scene, view, &settings, &NoProgress, &AtomicBool::new(false)).unwrap()
}

/// How far the picture is off: the mean of FLIP, and what 99 % of the pixels with ground are off in height, metres, and
/// on the screen, pixels.
struct Off {
    flip: f64,
    height_m: f64,
    screen_px: f64,
}

fn off(bench: &mut Bench, view: &CameraView, exact: &ReferencePicture) -> Off {
    let picture = bench.settled_picture(view).unwrap();
    let pixels = picture.rgba.as_chunks::<4>().0;
    let per_degree = DEFAULT_PIXELS_PER_DEGREE;
    let flip = flip_errors(&exact.rgba, pixels, SIZE_PX, per_degree).unwrap();
    let points = bench.ground_points(view).unwrap();
    let on_ground = || points.iter().filter(|point| !point.is_nan());
    assert!(on_ground().count() > points.len() / 3);
    let height_m_off = on_ground().map(|point| (point.z - height_m(point.truncate())).abs());
    let screen_px_off = on_ground().map(|point: &DVec3| {
        let true_point = point.truncate().extend(height_m(point.truncate()));
        let [a, b] = [*point, true_point].map(|point| view.pixel_from_world(point).unwrap());
        (a[0] - b[0]).hypot(a[1] - b[1])
    });
    Off {
        flip: flip.iter().map(|error| f64::from(*error)).sum::<f64>() / flip.len() as f64,
        height_m: percentile(height_m_off, 99.0).unwrap(),
        screen_px: percentile(screen_px_off, 99.0).unwrap(),
    }
}

#[test]
fn the_picture_is_as_true_as_the_triangles() {
    let Some(mut bench) = Bench::new(source(), settings()).unwrap() else { return };
    for view in [view(20.0, -15.0, 900.0), view(80.0, -60.0, 1_500.0)] {
        let exact = exact(&view);
        let mut before: Option<Off> = None;
        for max_error_m in [16.0, 4.0, 1.0, 0.25] {
            let tin = tin(max_error_m);
            let triangles = tin.indices.len() / 3;
            bench.renderer.set_tin(Some(tin)).unwrap();
            let record = bench.settle(&view).unwrap();
            assert_eq!(
                (&record.strategy[..], record.triangles_drawn),
                ("page-table", triangles as u64)
            );
            let off = off(&mut bench, &view, &exact);
            println!(
                "{max_error_m} m, {triangles} triangles: FLIP {:.4}, {:.3} m, {:.3} px",
                off.flip, off.height_m, off.screen_px
            );
            // Between samples the ground may lie a little beside the triangles' bound.
            assert!(off.height_m <= max_error_m + 0.3, "{}", off.height_m);
            let metre_px = 1.0 / (view.pixel_angle_rad() * 250.0);
            assert!(off.screen_px <= (max_error_m + 0.3) * metre_px, "{}", off.screen_px);
            if let Some(before) = before {
                assert!(off.screen_px < before.screen_px);
                // Of the last quarters most is not the triangles any more.
                assert!(off.flip < before.flip + 0.001, "{}", off.flip);
            }
            before = Some(off);
        }
        let last = before.unwrap();
        assert!(last.flip < 0.05 && last.screen_px < 1.0, "{} {}", last.flip, last.screen_px);
    }
}

#[test]
fn a_still_camera_comes_to_rest_over_triangles_and_the_dataset_comes_back() {
    let Some(mut bench) = Bench::new(source(), settings()).unwrap() else { return };
    let view = view(20.0, -15.0, 900.0);
    let gridded = bench.settled_picture(&view).unwrap();
    let ground = tin(2.0);
    bench.renderer.set_tin(Some(Arc::clone(&ground))).unwrap();
    bench.settle(&view).unwrap();
    assert!(!bench.renderer.needs_frame(&view));
    let still = bench.draw(&view).unwrap();
    assert_eq!((still.upload_bytes, still.disk_bytes, still.readback_bytes), (0, 0, 0));
    let below = view.eye.truncate();
    assert_eq!(bench.renderer.ground_height_m(below), ground.height_m(below));
    assert!(bench.renderer.ground_height_m(dvec2(ROOT_M, 0.0)).is_none());
    bench.change(|settings| settings.vertical_exaggeration = 2.0).unwrap();
    bench.change(|settings| settings.cache_columns = 11).unwrap();
    assert!(bench.renderer.tin().is_some(), "another cache, the same ground");
    let points = bench.ground_points(&view).unwrap();
    let on_ground = points.iter().filter(|point| !point.is_nan());
    for point in on_ground.step_by(97) {
        let off_m = (point.z - 2.0 * height_m(point.truncate())).abs();
        assert!(off_m < 2.0 * 2.0 + 0.6, "{off_m} m at {point}");
    }
    bench.renderer.set_tin(None).unwrap();
    bench.renderer.set_settings(settings()).unwrap();
    assert!(bench.settled_picture(&view).unwrap() == gridded);
}
