//! The coordinates the GPU gives for each pixel, against the surface they should lie on.

#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a step that fails fails the test")]
#![allow(clippy::print_stdout, reason = "measured values are to be seen")]

use std::sync::Arc;

use glam::{DVec2, DVec3, dvec2};
use terrain_core::{CameraView, RendererSettings, TerrainRenderer};
use terrain_tests::{AnalyticSource, Surface, gpu};

const ROOT_M: f64 = 65_536.0;

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

fn measure(surface: Surface, centre: DVec2, triangle_px: f64, view: CameraView) -> Option<Errors> {
    let gpu = gpu()?;
    let source = Arc::new(AnalyticSource::new(surface, centre, ROOT_M, [7, 5]));
    let settings = RendererSettings { triangle_px, ..Default::default() };
    let mut renderer = TerrainRenderer::new(gpu, source.clone(), settings).unwrap();
    let view = CameraView { eye: view.eye + centre.extend(0.0), ..view };
    let points = renderer.ground_coordinates(&view).unwrap();
    let mut errors = Errors::default();
    for (index, point) in points.iter().map(|&point| DVec3::from_array(point)).enumerate() {
        if point.is_nan() {
            continue;
        }
        let width = view.viewport_px[0] as usize;
        let expected = [(index % width) as f64 + 0.5, (index / width) as f64 + 0.5];
        let place = view.pixel_from_world(point).expect("seen points lie before the eye");
        let off_px = (place[0] - expected[0]).hypot(place[1] - expected[1]);
        let footprint_m = point.distance(view.eye) * view.pixel_angle_rad();
        let height_error_m = (point.z - source.height_m(point.truncate())).abs();
        errors.ground_pixels += 1;
        errors.place_px = errors.place_px.max(off_px);
        errors.heights_px.push(height_error_m / footprint_m);
    }
    errors.heights_px.sort_by(f64::total_cmp);
    Some(errors)
}

fn view(x: f64, y: f64, z: f64, heading_deg: f64, pitch_deg: f64) -> CameraView {
    let eye = DVec3::new(x, y, z);
    CameraView { eye, heading_deg, pitch_deg, fov_y_deg: 50.0, viewport_px: [320, 180] }
}

fn plane() -> Surface {
    Surface { height_m: |p| 300.0 + 0.05 * p.x - 0.02 * p.y, colour: |_| [128, 128, 128] }
}

fn cone() -> Surface {
    Surface {
        height_m: |p| 2000.0 - 0.3 * (p.length_squared() + 4.0e4).sqrt().min(6_000.0),
        colour: |_| [128, 128, 128],
    }
}

fn far_origin() -> DVec2 {
    dvec2(10_000_000.0, -10_000_000.0)
}

#[test]
fn a_plane_is_met_within_a_hundredth_of_a_pixel_near_and_far_and_at_far_origins() {
    let views = [
        view(0.0, 0.0, 320.0, 45.0, -10.0),
        view(100.0, -200.0, 2_000.0, 200.0, -30.0),
        view(-500.0, 0.0, 60_000.0, 0.0, -89.0),
    ];
    for centre in [DVec2::ZERO, dvec2(500_000.0, 6_800_000.0), far_origin()] {
        for view in views {
            let Some(errors) = measure(plane(), centre, 10.0, view) else { return };
            assert!(errors.ground_pixels > 10_000, "{view:?}: {}", errors.ground_pixels);
            assert!(errors.place_px < 0.01, "{view:?} at {centre}: {} px", errors.place_px);
            let worst = errors.height_px(1.0);
            assert!(worst < 0.01, "{view:?} at {centre}: {worst} px");
        }
    }
}

#[test]
fn a_cone_is_met_within_a_part_of_a_pixel() {
    for centre in [DVec2::ZERO, far_origin()] {
        for (triangle_px, p99_bound, worst_bound) in [(10.0, 0.5, 1.0), (2.0, 0.1, 0.25)] {
            let view = view(0.0, -9_000.0, 2_500.0, 0.0, -12.0);
            let Some(errors) = measure(cone(), centre, triangle_px, view) else { return };
            let (p99, worst) = (errors.height_px(0.99), errors.height_px(1.0));
            println!("cone, triangles of {triangle_px} px: p99 {p99:.4} px, worst {worst:.4} px");
            assert!(errors.place_px < 0.01, "{} px", errors.place_px);
            assert!(p99 < p99_bound && worst < worst_bound, "p99 {p99} px, worst {worst} px");
        }
    }
}
