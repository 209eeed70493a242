//! Ground is drawn where it is, and only where it is.

use std::sync::Arc;

use glam::{DVec2, DVec3, dvec2, dvec3};
use terrain_core::dataset::TileSource;
use terrain_core::gpu::GpuContext;
use terrain_core::selection::Strategy;
use terrain_core::{CameraView, RendererSettings};
use terrain_tests::{AnalyticSource, Bench, Ridges, Surface};

use crate::drawn::{Drawn, check, pixel_centre, settle_to_rest};

/// Ground ends level within its outermost texels, which are large far away; formulas go on.
const EDGE_M: f64 = 3_000.0;

fn plane() -> Surface {
    Surface { height_m: |p| 300.0 + 0.05 * p.x - 0.02 * p.y, colour: |_| [128, 128, 128] }
}

fn cone() -> Surface {
    Surface {
        height_m: |p| 2000.0 - 0.3 * (p.length_squared() + 4.0e4).sqrt().min(6_000.0),
        colour: |_| [128, 128, 128],
    }
}

/// Vertical distances of the points drawn from the true surface, in pixels there: the 99th percentile
/// and the greatest.
fn height_errors_px(source: &AnalyticSource, drawn: &Drawn) -> [f64; 2] {
    let (view, extent) = (&drawn.view, source.manifest().data_extent);
    let error_px = |point: DVec3| {
        let footprint_m = point.distance(view.eye) * view.pixel_angle_rad();
        (point.z - source.height_m(point.truncate())).abs() / footprint_m
    };
    let is_inside = |point: &DVec3| {
        let place = point.truncate();
        (place - extent.min).min(extent.max - place).min_element() > EDGE_M
    };
    let mut errors_px = drawn.ground().filter(is_inside).map(error_px).collect::<Vec<_>>();
    assert!(errors_px.len() > 10_000, "{} pixels of ground", errors_px.len());
    errors_px.sort_by(f64::total_cmp);
    [0.99, 1.0].map(|part| errors_px[((errors_px.len() - 1) as f64 * part) as usize])
}

pub fn a_plane_is_met_near_and_far_and_at_far_origins(gpu: &Arc<GpuContext>, strategy: Strategy) {
    let settings = RendererSettings { strategy, triangle_px: 10.0, ..Default::default() };
    for centre in [DVec2::ZERO, dvec2(10_000_000.0, -10_000_000.0)] {
        let source = Arc::new(AnalyticSource::new(plane(), centre, Ridges::ROOT_M, [7, 5]));
        let mut bench = Bench::on(gpu, Arc::clone(&source) as _, settings).unwrap();
        for (x, y, z, heading_deg, pitch_deg) in [
            (0.0, 0.0, 320.0, 45.0, -10.0),
            (100.0, -200.0, 2_000.0, 200.0, -30.0),
            (-500.0, 0.0, 60_000.0, 0.0, -89.0),
        ] {
            let eye = centre.extend(0.0) + dvec3(x, y, z);
            let view = CameraView { eye, ..Ridges::view(heading_deg, pitch_deg, z) };
            let drawn = check(&mut bench, "plane", &view);
            let (place_px, [_, worst_px]) =
                (drawn.place_error_px(), height_errors_px(&source, &drawn));
            assert!(place_px < 0.01 && worst_px < 0.01, "{place_px} px, {worst_px} px");
        }
    }
}

pub fn a_cone_is_met_within_a_part_of_a_pixel(gpu: &Arc<GpuContext>, strategy: Strategy) {
    let source = Arc::new(AnalyticSource::new(cone(), DVec2::ZERO, Ridges::ROOT_M, [7, 5]));
    for (triangle_px, p99_bound, worst_bound) in [(10.0, 0.5, 1.0), (2.0, 0.1, 0.3)] {
        let settings = RendererSettings { strategy, triangle_px, ..Default::default() };
        let mut bench = Bench::on(gpu, Arc::clone(&source) as _, settings).unwrap();
        let view =
            CameraView { eye: dvec3(0.0, -9_000.0, 2_500.0), ..Ridges::view(0.0, -12.0, 0.0) };
        let drawn = check(&mut bench, "cone", &view);
        let (place_px, [p99, worst]) = (drawn.place_error_px(), height_errors_px(&source, &drawn));
        println!("triangles of {triangle_px} px: p99 {p99:.4} px, worst {worst:.4} px");
        assert!(place_px < 0.01, "{place_px} px");
        assert!(p99 < p99_bound && worst < worst_bound, "p99 {p99} px, worst {worst} px");
    }
}

pub fn ground_without_data_is_left_out_and_no_other(gpu: &Arc<GpuContext>, strategy: Strategy) {
    const RADIUS_M: f64 = 3_000.0;
    let island = Surface {
        height_m: |p| if p.length() < RADIUS_M { 200.0 } else { f64::NAN },
        colour: |_| [120, 140, 60],
    };
    let source = Arc::new(AnalyticSource::new(island, DVec2::ZERO, Ridges::ROOT_M, [6, 6]));
    let settings = RendererSettings { strategy, ..Default::default() };
    let mut bench = Bench::on(gpu, source, settings).unwrap();
    let view = CameraView { eye: dvec3(0.0, 0.0, 9_000.0), ..Ridges::view(0.0, -90.0, 0.0) };
    settle_to_rest(&mut bench, &view);
    // The island's outline against a circle: its radius in pixels.
    let radius_px = RADIUS_M / (8_800.0 * view.pixel_angle_rad());
    let middle = 0.5 * dvec2(f64::from(view.viewport_px[0]), f64::from(view.viewport_px[1]));
    let picture = bench.picture().unwrap();
    let is_wrong = |(index, pixel): &(usize, &[u8])| {
        let to_shore_px = pixel_centre(*index, &view).distance(middle) - radius_px;
        let is_ground = pixel[1] > pixel[2];
        to_shore_px.abs() > 2.0 && is_ground != (to_shore_px < 0.0)
    };
    let wrong = picture.rgba.chunks_exact(4).enumerate().filter(is_wrong).count();
    assert_eq!(wrong, 0, "pixels on the wrong side of the shore");
    let points = bench.ground_points(&view).unwrap();
    let mut ground = points.iter().filter(|point| point.is_finite());
    assert!(ground.all(|point| point.truncate().length() < RADIUS_M + 80.0));
}
