//! The mesh made on the CPU and sent as geometry: true to the ground to within its tolerance, and sent a
//! little at a time.

#![allow(clippy::unwrap_used, reason = "a step that fails fails the test")]
#![allow(clippy::print_stdout, reason = "measured values are to be seen")]

use glam::{DVec3, dvec3};
use terrain_core::selection::Strategy;
use terrain_core::{CameraView, RendererSettings};
use terrain_tests::{Bench, Picture, Ridges};

/// Pixels that the ground may look off by, texels being drawn a pixel large.
const TOLERANCE_PX: f64 = 1.5;

fn open(settings: RendererSettings) -> Option<Bench> {
    Bench::new(Ridges::source(), settings).unwrap()
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

/// Largest distance in pixels of the ground drawn from the true ground at the same place.
fn worst_error_px(points: &[DVec3], view: &CameraView, exaggeration: f64) -> f64 {
    let error_px = |point: &DVec3| {
        let true_m = Ridges::height_m(point.truncate()) * exaggeration;
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
    let Some(mut bench) = open(settings()) else { return };
    for (heading_deg, pitch_deg, height_m) in [
        (20.0, -18.0, 2_500.0),
        (200.0, -5.0, 1_300.0),
        (95.0, -60.0, 6_000.0),
        (0.0, -90.0, 40_000.0),
    ] {
        let view = Ridges::view(heading_deg, pitch_deg, height_m);
        let record = bench.settle(&view).unwrap();
        let points = bench.ground_points(&view).unwrap();
        let error_px = worst_error_px(&points, &view, 1.0);
        println!(
            "{heading_deg} deg, {height_m} m: {} triangles, {error_px:.2} px",
            record.triangles_drawn
        );
        assert!(error_px < 1.05 * TOLERANCE_PX, "{error_px} px");
        assert!(record.triangles_drawn < 60_000, "{record:?}");
    }
}

#[test]
fn the_picture_is_that_of_the_displaced_mesh_but_for_triangles() {
    let Some(mut mesh) = open(settings()) else { return };
    let displaced =
        RendererSettings { strategy: Strategy::CpuFrustum, triangle_px: 4.0, ..settings() };
    let mut displaced = open(displaced).unwrap();
    for view in [Ridges::view(20.0, -18.0, 2_500.0), Ridges::view(95.0, -60.0, 6_000.0)] {
        let part = part_off(
            &mesh.settled_picture(&view).unwrap(),
            &displaced.settled_picture(&view).unwrap(),
            12,
        );
        println!("{part} of the values are off by more than 12 of 255");
        assert!(part < 0.03, "{part}");
    }
}

#[test]
fn a_trembling_camera_sends_no_geometry() {
    let Some(mut bench) = open(settings()) else { return };
    let still = Ridges::view(20.0, -18.0, 2_500.0);
    let settled = bench.settle(&still).unwrap();
    assert!(settled.upload_mesh_bytes > 10_000 && settled.upload_dem_bytes == 0, "{settled:?}");
    let mut moved = still;
    moved.eye += dvec3(4.0, 3.0, -1.0);
    bench.settle(&moved).unwrap();
    for _ in 0..4 {
        for view in [still, moved] {
            assert_eq!(bench.settle(&view).unwrap().upload_mesh_bytes, 0);
        }
    }
}

#[test]
fn flying_on_sends_a_little_of_the_mesh_within_the_budget() {
    let budget = 96 << 10;
    let Some(mut bench) = open(RendererSettings { upload_budget_bytes: budget, ..settings() })
    else {
        return;
    };
    let at = |step: u32| {
        let mut view = Ridges::view(20.0, -18.0, 2_500.0);
        view.eye += dvec3(10.0, 25.0, 0.0) * f64::from(step);
        view
    };
    // One tile of imagery always goes through; tables and uniforms are beside the budget.
    let most = budget + 392 * 392 * 4 + 40_000;
    let mut first = 0;
    for _ in 0..400 {
        let record = bench.draw(&at(0)).unwrap();
        assert!(record.upload_bytes < most, "{record:?}");
        first += record.upload_mesh_bytes;
        if !bench.renderer.needs_frame(&at(0)) {
            break;
        }
    }
    bench.settle(&at(0)).unwrap();
    let mut sent = 0;
    for step in 1..=40 {
        sent += bench.settle(&at(step)).unwrap().upload_mesh_bytes;
    }
    println!("{first} bytes for the first view, {} for each of the next", sent / 40);
    assert!(sent / 40 < first / 50, "{sent} bytes after {first}");
    assert!(sent > 0);
}

#[test]
fn a_switch_to_the_mesh_and_back_draws_what_each_draws_alone() {
    let Some(mut bench) = open(settings()) else { return };
    let view = Ridges::view(20.0, -18.0, 2_500.0);
    let alone = bench.settled_picture(&view).unwrap();
    for strategy in [Strategy::CpuFrustum, Strategy::CpuMesh] {
        bench.change(|settings| settings.strategy = strategy).unwrap();
        assert!(bench.renderer.needs_frame(&view), "the switch shows at once");
        let record = bench.draw(&view).unwrap();
        assert_eq!(record.strategy, strategy.name());
    }
    assert!(part_off(&bench.settled_picture(&view).unwrap(), &alone, 1) < 1.0e-4);
}

#[test]
fn a_change_of_exaggeration_and_of_detail_takes_hold() {
    let Some(mut bench) = open(settings()) else { return };
    let view = Ridges::view(20.0, -25.0, 9_000.0);
    let coarse = bench.settle(&view).unwrap().triangles_drawn;
    bench
        .change(|settings| (settings.vertical_exaggeration, settings.texel_px) = (3.0, 0.5))
        .unwrap();
    let fine = bench.settle(&view).unwrap().triangles_drawn;
    assert!(fine > 2 * coarse, "{fine} triangles after {coarse}");
    let error_px = worst_error_px(&bench.ground_points(&view).unwrap(), &view, 3.0);
    assert!(error_px < 0.55 * TOLERANCE_PX, "{error_px} px");
}
