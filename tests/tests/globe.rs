//! The globe from the ground to far away: pictures without seams at the date line and the poles, ground in every
//! pixel from the first frame on, rest.

#![allow(clippy::unwrap_used, reason = "a step that fails fails the test")]
#![allow(clippy::print_stdout, reason = "measured values are to be seen")]

use std::sync::Arc;

use glam::{DVec2, DVec3, dvec2};
use terrain_core::geodesy::{Geodetic, PlateCarree, Wgs84};
use terrain_core::selection::Strategy;
use terrain_core::{AntiAliasing, CameraView, RendererSettings};
use terrain_tests::{AnalyticSource, Bench, Picture, Surface};

const SIZE_PX: [u32; 2] = [320, 180];

/// The point of the unit ball at metres on the plate carrée: what is smooth there has neither poles nor date line.
fn on_ball(point: DVec2) -> DVec3 {
    Geodetic::from_plate_carree(point.extend(0.0)).normal()
}

fn colour(point: DVec2) -> [u8; 3] {
    let at = on_ball(point);
    let waves = |scale: f64| {
        let at = at * scale;
        (at.x + 0.3).sin() * (at.y - 0.2).cos() + (at.z * 1.1 + at.x).sin()
    };
    let code = |level: f64, value: f64| (level + value).clamp(0.0, 255.0) as u8;
    [
        code(120.0, 40.0 * waves(7.0) + 12.0 * waves(61.0)),
        code(115.0, 30.0 * waves(11.0) + 12.0 * waves(83.0)),
        code(100.0, 35.0 * waves(5.0)),
    ]
}

fn level_source() -> Arc<AnalyticSource> {
    let surface = Surface { height_m: |_| 0.0, colour };
    Arc::new(AnalyticSource::globe(surface, [1, 5], [128, 256]))
}

fn hilly_source() -> Arc<AnalyticSource> {
    let height_m = |point: DVec2| {
        let at = on_ball(point) * 40.0;
        2_000.0 + 2_500.0 * (at.x + 0.5).sin() * (at.y * 1.3).cos() * (0.7 * at.z).sin()
    };
    Arc::new(AnalyticSource::globe(Surface { height_m, colour }, [5, 5], [128, 256]))
}

fn settings() -> RendererSettings {
    RendererSettings {
        strategy: Strategy::PageTable,
        cache_columns: 12,
        cache_rows: 12,
        max_tiles: 126,
        anisotropy: 4,
        anti_aliasing: AntiAliasing::Off,
        ..Default::default()
    }
}

fn view(longitude_deg: f64, latitude_deg: f64, height_m: f64, pitch_deg: f64) -> CameraView {
    CameraView {
        eye: PlateCarree::metres_from_degrees(dvec2(longitude_deg, latitude_deg)).extend(height_m),
        heading_deg: 20.0,
        pitch_deg,
        fov_y_deg: 50.0,
        viewport_px: SIZE_PX,
    }
}

/// From space to the ground: over the middle of a face of the cube, across the date line and at both poles.
fn views() -> [CameraView; 9] {
    [
        view(10.0, 47.0, 1.0e8, -90.0),
        view(10.0, 47.0, 1.0e7, -90.0),
        view(180.0, -15.0, 3.0e6, -70.0),
        view(-179.999, 66.0, 2.0e5, -25.0),
        view(0.0, 90.0, 1.0e6, -60.0),
        view(120.0, -89.99, 3.0e4, -20.0),
        view(45.0, 35.264, 9.0e3, -4.0),
        view(86.9, 28.0, 5.2e3, -1.0),
        view(8.0, 46.0, 4.7e3, -90.0),
    ]
}

/// The point of the globe under each pixel in the eye's axes, metres; NaN where there is none.
fn relative_points(bench: &mut Bench, view: &CameraView) -> Vec<DVec3> {
    let points = bench.renderer.drawn_coordinates(view).unwrap();
    points.into_iter().map(|point| DVec3::from_array(point) - view.eye).collect()
}

/// Earth-centred places of the eye and of points in its axes.
fn ecef(view: &CameraView, relative: DVec3) -> DVec3 {
    let eye = Geodetic::from_plate_carree(view.eye);
    Wgs84::ecef_from_geodetic(&eye) + eye.ecef_from_local() * relative
}

/// Distance in metres at which a ray meets the ellipsoid raised by so much.
fn ellipsoid_distance_m(view: &CameraView, direction: DVec3, raised_m: f64) -> Option<f64> {
    let (a, b) = (Wgs84::EQUATOR_RADIUS_M + raised_m, Wgs84::POLAR_RADIUS_M + raised_m);
    let axes = DVec3::new(a, a, b);
    let from = ecef(view, DVec3::ZERO) / axes;
    let along = (ecef(view, direction) - ecef(view, DVec3::ZERO)) / axes;
    let nearest = -from.dot(along) / along.length_squared();
    let low = from + nearest * along;
    let half = (1.0 - low.length_squared()) / along.length_squared();
    let first = nearest - half.max(0.0).sqrt();
    (half >= 0.0 && first > 0.0).then_some(first)
}

fn pixel_centre(index: usize) -> [f64; 2] {
    let width = SIZE_PX[0] as usize;
    [(index % width) as f64 + 0.5, (index / width) as f64 + 0.5]
}

#[test]
fn there_is_ground_in_every_pixel_of_the_globe_from_the_first_frame_on() {
    for (source, [low_m, high_m]) in
        [(level_source(), [0.0, 0.0]), (hilly_source(), [-500.0, 4_500.0])]
    {
        let Some(mut bench) = Bench::new(source, settings()).unwrap() else { return };
        for view in views() {
            // A pixel at the limb may go either way, and a horizon of few triangles lies within it.
            let raised = |height_m: f64, pixels: f64| {
                height_m + pixels * view.eye.z.max(1.0e4) * view.pixel_angle_rad()
            };
            for frame in 0..6 {
                bench.draw(&view).unwrap();
                let points = relative_points(&mut bench, &view);
                for (index, point) in points.iter().enumerate() {
                    let [x, y] = pixel_centre(index);
                    let direction = view.ray_direction(x, y);
                    let surely = ellipsoid_distance_m(&view, direction, raised(low_m, -2.0));
                    let never = ellipsoid_distance_m(&view, direction, raised(high_m, 2.0));
                    let has_ground = !point.is_nan();
                    assert!(has_ground || surely.is_none(), "a hole: {view:?} {frame} {x} {y}");
                    let is_over = view.eye.z > raised(high_m, 2.0);
                    assert!(!has_ground || never.is_some() || !is_over, "{view:?} {frame} {x} {y}");
                }
            }
        }
    }
}

#[test]
fn every_pixel_shows_the_ground_that_is_there_to_a_sixteenth_of_a_pixel() {
    let Some(mut bench) = Bench::new(level_source(), settings()).unwrap() else { return };
    let (mut worst_px, mut farthest_px) = (0.0_f64, 0.0_f64);
    for exponent in 0..=14 {
        let height_m = 10.0_f64.powf(0.5 * f64::from(exponent));
        for (longitude, latitude) in [(20.0, 5.0), (180.0, 50.0), (0.0, 90.0), (77.0, -89.999)] {
            for pitch in [-90.0, -30.0, -3.0] {
                let view = view(longitude, latitude, height_m, pitch);
                bench.settle(&view).unwrap();
                for (index, point) in relative_points(&mut bench, &view).into_iter().enumerate() {
                    if point.is_nan() {
                        continue;
                    }
                    let [x, y] = pixel_centre(index);
                    let Some([seen_x, seen_y]) = view.pixel_from_world(view.eye + point) else {
                        panic!("{point} is behind the eye");
                    };
                    worst_px = worst_px.max((seen_x - x).hypot(seen_y - y));
                    // Off the ellipsoid by what its triangles cut off.
                    let off_m = Wgs84::geodetic_from_ecef(ecef(&view, point)).height_m.abs();
                    let off_px = off_m / point.length() / view.pixel_angle_rad();
                    farthest_px = farthest_px.max(off_px);
                }
            }
        }
    }
    println!(
        "pixels are {worst_px:.5} px off at the most, and {farthest_px:.3} px off the ellipsoid"
    );
    assert!(worst_px < 1.0 / 16.0, "{worst_px}");
    assert!(farthest_px < 0.3, "{farthest_px}");
}

/// The mean difference of all channels, the largest, and how many of them are more than 3.
fn difference(a: &Picture, b: &Picture) -> (f64, u8, usize) {
    let channels = || a.rgba.iter().zip(&b.rgba).map(|(a, b)| a.abs_diff(*b));
    let sum: f64 = channels().map(f64::from).sum();
    let large = channels().filter(|difference| *difference > 3).count();
    (sum / a.rgba.len() as f64, channels().max().unwrap_or(0), large)
}

#[test]
fn a_globe_turned_by_a_quarter_looks_the_same() {
    let turned = Surface {
        height_m: |_| 0.0,
        colour: |point| colour(dvec2(point.x - 0.25 * PlateCarree::EQUATOR_M, point.y)),
    };
    let turned = Arc::new(AnalyticSource::globe(turned, [1, 5], [128, 256]));
    let Some(mut bench) = Bench::new(level_source(), settings()).unwrap() else { return };
    let mut turned = Bench::on(&bench.gpu, turned, settings()).unwrap();
    for view in views() {
        let there = CameraView { eye: view.eye + DVec3::X * 0.25 * PlateCarree::EQUATOR_M, ..view };
        let a = bench.settled_picture(&view).unwrap();
        let b = turned.settled_picture(&there).unwrap();
        let (mean, worst, large) = difference(&a, &b);
        println!("{:?}: {mean:.4} in the mean, {worst} at the most", view.eye);
        // At the limb a sample may fall on either side.
        assert!(mean < 0.01 && large <= 12, "{view:?}: {mean} {large}");
    }
}

#[test]
fn a_still_camera_comes_to_rest_within_its_caches() {
    let small = RendererSettings { cache_columns: 3, cache_rows: 3, max_tiles: 8, ..settings() };
    for (what, settings) in [("roomy", settings()), ("small", small)] {
        let Some(mut bench) = Bench::new(hilly_source(), settings).unwrap() else { return };
        let slots = u64::from(settings.cache_columns * settings.cache_rows);
        for view in views() {
            for step in 0..4 {
                let on_the_way = CameraView { heading_deg: 30.0 * f64::from(step), ..view };
                let record = bench.draw(&on_the_way).unwrap();
                assert!(record.tiles_resident <= 2 * slots, "{what}: {record:?}");
                assert!(record.triangles_drawn <= 150_000, "{record:?}");
            }
            let settled = bench.settle(&view).unwrap();
            assert_eq!(settled.tiles_missing, 0, "{what}: {settled:?}");
            assert!(settled.tiles_resident <= 2 * slots, "{what}: {settled:?}");
            // The first picture of a view after pictures of none.
            bench.draw(&view).unwrap();
            assert!(!bench.renderer.needs_frame(&view), "{what}: goes on for ever: {view:?}");
            let still = bench.draw(&view).unwrap();
            let moved = (still.upload_bytes, still.disk_bytes, still.readback_bytes);
            assert_eq!((moved, still.tiles_new), ((0, 0, 0), 0), "{what}: {view:?}");
        }
    }
}

#[test]
fn the_way_to_a_view_does_not_show() {
    let Some(mut flown) = Bench::new(hilly_source(), settings()).unwrap() else { return };
    for step in 0..12 {
        flown.draw(&view(20.0 * f64::from(step), 40.0, 3.0e5, -30.0)).unwrap();
    }
    let here = view(180.0, -15.0, 1.0e5, -20.0);
    let in_flight = flown.settled_picture(&here).unwrap();
    let mut fresh = Bench::on(&flown.gpu, hilly_source(), settings()).unwrap();
    let (_, worst, _) = difference(&in_flight, &fresh.settled_picture(&here).unwrap());
    // Which slots the pages got goes by the order in which they came; filtering rounds accordingly.
    assert!(worst <= 1, "the picture depends on the way there: {worst}");
}

#[test]
fn heights_are_known_all_round() {
    let Some(mut bench) = Bench::new(hilly_source(), settings()).unwrap() else { return };
    bench.settle(&view(180.0, 10.0, 1.0e5, -90.0)).unwrap();
    for longitude in [179.999, 180.001, -179.999, 540.0] {
        let point = PlateCarree::metres_from_degrees(dvec2(longitude, 10.0));
        let height_m = bench.renderer.ground_height_m(point).unwrap();
        let same = PlateCarree::metres_from_degrees(dvec2(180.0, 10.0));
        let expected_m = bench.renderer.ground_height_m(same).unwrap();
        assert!((height_m - expected_m).abs() < 5.0, "{longitude}: {height_m} {expected_m}");
    }
}
