//! The globe from the ground to far away: pictures without seams at the date line and the poles, ground in every
//! pixel from the first frame on, rest.

#![allow(clippy::unwrap_used, reason = "a step that fails fails the test")]
#![allow(clippy::print_stdout, reason = "measured values are to be seen")]

use std::sync::Arc;

use glam::{DVec2, DVec3, dvec2};
use terrain_core::geodesy::{Geodetic, PlateCarree};
use terrain_core::selection::Strategy;
use terrain_core::{AntiAliasing, CameraView, RendererSettings};
use terrain_tests::{AnalyticSource, Bench, Surface};

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

#[test]
fn look() {
    let dir = std::path::PathBuf::from(std::env::var("GLOBE_OUT").unwrap());
    for (name, source) in [("level", level_source()), ("hilly", hilly_source())] {
        let Some(mut bench) = Bench::new(source, settings()).unwrap() else { return };
        for (index, view) in [
            view(10.0, 47.0, 1.0e7, -90.0),
            view(10.0, 47.0, 1.0e6, -45.0),
            view(180.0, -10.0, 2.0e6, -60.0),
            view(0.0, 89.0, 2.0e6, -60.0),
            view(10.0, 47.0, 8.0e3, -5.0),
        ]
        .into_iter()
        .enumerate()
        {
            let started = std::time::Instant::now();
            let picture = bench.settled_picture(&view).unwrap();
            let record = bench.draw(&view).unwrap();
            println!(
                "{name} {index}: {} triangles, {:?}",
                record.triangles_drawn,
                started.elapsed()
            );
            picture.save(&dir.join(format!("{name}-{index}.png"))).unwrap();
        }
    }
}
