//! The globe as it is drawn against its exact picture: colours, and where the ground is seen.

#![allow(clippy::unwrap_used, reason = "a step that fails fails the test")]
#![allow(clippy::print_stdout, reason = "measured values are to be seen")]

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::{DVec2, DVec3, dvec2};
use terrain_core::geodesy::{Geodetic, PlateCarree, Wgs84};
use terrain_core::measure::error::{DEFAULT_PIXELS_PER_DEGREE, flip_errors, percentile};
use terrain_core::reference::{
    ReferencePicture, ReferenceScene, ReferenceSettings, render_reference,
};
use terrain_core::selection::Strategy;
use terrain_core::{AntiAliasing, CameraView, NoProgress, RendererSettings};
use terrain_tests::{AnalyticSource, Bench, Surface};

/// Mountains and patterns that have neither poles nor date line.
fn source() -> Arc<AnalyticSource> {
    fn on_ball(point: DVec2) -> DVec3 {
        Geodetic::from_plate_carree(point.extend(0.0)).normal()
    }
    let height_m = |point: DVec2| {
        let at = on_ball(point) * 40.0;
        2_000.0 + 2_500.0 * (at.x + 0.5).sin() * (at.y * 1.3).cos() * (0.7 * at.z).sin()
    };
    let colour = |point: DVec2| {
        let at = on_ball(point);
        let waves = |scale: f64| {
            let at = at * scale;
            (at.x + 0.3).sin() * (at.y - 0.2).cos() + (at.z * 1.1 + at.x).sin()
        };
        let code = |value: f64| (120.0 + value).clamp(0.0, 255.0) as u8;
        [
            code(35.0 * waves(7.0) + 15.0 * waves(61.0)),
            code(30.0 * waves(23.0)),
            code(35.0 * waves(5.0)),
        ]
    };
    Arc::new(AnalyticSource::globe(Surface { height_m, colour }, [5, 5], [128, 256]))
}

fn settings() -> RendererSettings {
    RendererSettings {
        strategy: Strategy::PageTable,
        cache_columns: 12,
        cache_rows: 12,
        max_tiles: 126,
        anisotropy: 8,
        triangle_px: 3.0,
        anti_aliasing: AntiAliasing::FourSamples,
        ..Default::default()
    }
}

fn view(longitude_deg: f64, latitude_deg: f64, height_m: f64, pitch_deg: f64) -> CameraView {
    CameraView {
        eye: PlateCarree::metres_from_degrees(dvec2(longitude_deg, latitude_deg)).extend(height_m),
        heading_deg: 20.0,
        pitch_deg,
        fov_y_deg: 50.0,
        viewport_px: [192, 108],
    }
}

fn exact(scene: &ReferenceScene, view: &CameraView) -> ReferencePicture {
    let settings = ReferenceSettings { most_rays: 16, ..Default::default() };
    render_reference(scene, view, &settings, &NoProgress, &AtomicBool::new(false)).unwrap()
}

/// How far in pixels ground that is drawn at a point is from where the exact surface has it, at the same longitude
/// and latitude.
fn screen_error_px(scene: &ReferenceScene, view: &CameraView, drawn: DVec3) -> Option<f64> {
    let eye = Geodetic::from_plate_carree(view.eye);
    let (frame, origin) = (eye.ecef_from_local(), Wgs84::ecef_from_geodetic(&eye));
    let at = Wgs84::geodetic_from_ecef(origin + frame * (drawn - view.eye));
    let height_m = scene.height_m(at.plate_carree())?;
    let place = Wgs84::ecef_from_geodetic(&Geodetic { height_m, ..at });
    let there = view.pixel_from_world(view.eye + frame.transpose() * (place - origin))?;
    let here = view.pixel_from_world(drawn)?;
    Some((there[0] - here[0]).hypot(there[1] - here[1]))
}

#[test]
fn the_globe_is_drawn_as_the_reference_has_it() {
    let source = source();
    let scene = ReferenceScene::open(Arc::clone(&source) as _).unwrap();
    let Some(mut bench) = Bench::new(source, settings()).unwrap() else { return };
    for (name, view) in [
        ("from space", view(10.0, 47.0, 1.0e7, -90.0)),
        ("the date line", view(180.0, -15.0, 1.5e6, -60.0)),
        ("the north pole", view(30.0, 89.5, 8.0e5, -70.0)),
        ("the south pole, low", view(0.0, -89.9, 6.0e4, -25.0)),
        ("the limb", view(-60.0, 20.0, 2.0e6, -40.0)),
        ("mountains", view(-179.9, 30.0, 1.2e4, -12.0)),
    ] {
        let picture = bench.settled_picture(&view).unwrap();
        let drawn: Vec<[u8; 4]> = picture.rgba.as_chunks::<4>().0.to_vec();
        let points = bench.renderer.drawn_coordinates(&view).unwrap();
        let seen = exact(&scene, &view);
        let flip =
            flip_errors(&seen.rgba, &drawn, view.viewport_px, DEFAULT_PIXELS_PER_DEGREE).unwrap();
        let flip = flip.iter().map(|&error| f64::from(error)).sum::<f64>() / flip.len() as f64;
        let pairs = || points.iter().zip(&seen.coordinates).zip(&seen.silhouette);
        let unlike = pairs().filter(|((a, b), _)| a[0].is_nan() != b.is_nan()).count();
        let sky_part = unlike as f64 / points.len() as f64;
        let off_px = pairs()
            .filter(|((a, b), is_edge)| !a[0].is_nan() && !b.is_nan() && !**is_edge)
            .filter_map(|((a, _), _)| screen_error_px(&scene, &view, DVec3::from_array(*a)));
        let p99_px = percentile(off_px, 99.0).unwrap();
        println!("{name}: FLIP {flip:.4}, sky {sky_part:.5}, ground {p99_px:.3} px off (p99)");
        assert!(flip < 0.04 && sky_part < 0.002 && p99_px < 0.1, "{name}");
    }
}
