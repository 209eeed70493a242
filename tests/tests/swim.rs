//! Swim: how far the ground drawn at a fixed place moves while the camera does and the data does not.
//! The mesh's vertices move with the camera; were heights not filtered to their spacing, they would
//! catch other bumps in every frame.

#![allow(clippy::unwrap_used, reason = "a step that fails fails the test")]
#![allow(clippy::print_stdout, reason = "measured values are to be seen")]

use std::sync::Arc;

use glam::{DVec2, DVec3, dvec2};
use terrain_core::{CameraView, RendererSettings, TerrainRenderer};
use terrain_tests::{AnalyticSource, Surface, gpu};

const SIZE_PX: [u32; 2] = [320, 180];
/// Steps of the camera, each a quarter of a pixel of the ground below.
const STEPS: i32 = 16;

/// Bumps of 100 m, some 700 m apart: shorter than the mesh's spacing under the camera.
fn bumps() -> Surface {
    Surface {
        height_m: |p| 100.0 * (p.x / 111.0).sin() * (p.y / 117.0).sin(),
        colour: |_| [128, 128, 128],
    }
}

fn down(east_m: f64) -> CameraView {
    CameraView {
        eye: DVec3::new(east_m, 0.0, 20_000.0),
        heading_deg: 0.0,
        pitch_deg: -90.0,
        fov_y_deg: 50.0,
        viewport_px: SIZE_PX,
    }
}

/// Height drawn at a place: bilinear between the pixels round it.
fn drawn_height_m(points: &[[f64; 3]], view: &CameraView, place: DVec2) -> f64 {
    let pixel = view.pixel_from_world(place.extend(0.0)).unwrap();
    let at = DVec2::from(pixel) - 0.5;
    let low = at.floor();
    let part = at - low;
    let z = |right: f64, down: f64| {
        points[(low.y + down) as usize * SIZE_PX[0] as usize + (low.x + right) as usize][2]
    };
    let north = z(0.0, 0.0) * (1.0 - part.x) + z(1.0, 0.0) * part.x;
    let south = z(0.0, 1.0) * (1.0 - part.x) + z(1.0, 1.0) * part.x;
    north * (1.0 - part.y) + south * part.y
}

#[test]
fn bumps_finer_than_the_mesh_do_not_make_the_ground_swim() {
    let Some(gpu) = gpu() else { return };
    // One level only: the data in use stays the same whatever the camera does.
    let source = Arc::new(AnalyticSource::new(bumps(), DVec2::ZERO, 32_768.0, [1, 1]));
    let settings = RendererSettings { triangle_px: 8.0, ..Default::default() };
    let mut renderer = TerrainRenderer::new(gpu, source, settings).unwrap();
    let pixel_m = 20_000.0 * down(0.0).pixel_angle_rad();
    let places = (-20..=20).map(|i| dvec2(f64::from(i) * 231.0, f64::from(i % 7) * 411.0));
    let places = places.collect::<Vec<_>>();
    let mut swim_px = Vec::new();
    let mut before: Option<Vec<f64>> = None;
    for step in 0..STEPS {
        let view = down(f64::from(step) * 0.25 * pixel_m);
        let points = renderer.ground_coordinates(&view).unwrap();
        let now =
            places.iter().map(|&place| drawn_height_m(&points, &view, place)).collect::<Vec<_>>();
        if let Some(before) = before {
            let moved = before.iter().zip(&now).map(|(a, b)| (a - b).abs() / pixel_m);
            swim_px.extend(moved);
        }
        before = Some(now);
    }
    swim_px.sort_by(f64::total_cmp);
    let [median, worst] = [swim_px[swim_px.len() / 2], swim_px[swim_px.len() - 1]];
    println!("swim a frame: median {median:.4} px, worst {worst:.4} px of {} m", pixel_m.round());
    assert!(worst < 0.03 && median < 0.006, "median {median} px, worst {worst} px");
}
