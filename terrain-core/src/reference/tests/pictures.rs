//! Whole pictures: sky, silhouettes, tolerance, and what is refused.

use std::sync::atomic::AtomicBool;

use glam::{DVec2, dvec2};

use super::Case;
use crate::CameraView;
use crate::progress::NoProgress;
use crate::reference::{ReferenceError, ReferencePicture, ReferenceSettings, render_reference};

fn picture(case: &Case, view: &CameraView, settings: &ReferenceSettings) -> ReferencePicture {
    let going_on = AtomicBool::new(false);
    render_reference(&case.scene, view, settings, &NoProgress, &going_on).unwrap()
}

fn view(case: &Case, place: DVec2, height_m: f64, heading_deg: f64, pitch_deg: f64) -> CameraView {
    let eye = case.world(place).extend(height_m);
    CameraView { eye, heading_deg, pitch_deg, fov_y_deg: 50.0, viewport_px: [64, 48] }
}

#[test]
fn an_empty_view_is_all_sky() {
    let case = Case::bumpy(24, 24, 1, 20.0, false);
    let up = picture(&case, &view(&case, dvec2(12.0, 12.0), 50.0, 0.0, 60.0), &Default::default());
    assert!(up.coordinates.iter().all(|point| point.is_nan()));
    assert!(up.distance_m.iter().all(|distance| *distance == f64::INFINITY));
    assert!(!up.silhouette.contains(&true));
    assert!(up.rgba.iter().all(|pixel| pixel[3] == 255 && pixel[2] > pixel[0]), "blue");
}

#[test]
fn coordinates_lie_under_their_pixels_and_on_the_surface() {
    let case = Case::bumpy(40, 40, 2, 40.0, false);
    let view = view(&case, dvec2(20.0, 36.0), 160.0, -10.0, -35.0);
    let settings = ReferenceSettings { vertical_exaggeration: 1.5, ..Default::default() };
    let seen = picture(&case, &view, &settings);
    let mut ground = 0;
    for (index, point) in seen.coordinates.iter().enumerate().filter(|(_, p)| !p.is_nan()) {
        let pixel = view.pixel_from_world(*point).unwrap();
        let expected = [(index % 64) as f64 + 0.5, (index / 64) as f64 + 0.5];
        assert!((pixel[0] - expected[0]).hypot(pixel[1] - expected[1]) < 1e-6);
        let height_m = case.height_m(point.truncate()).unwrap();
        assert!((point.z - 1.5 * height_m).abs() < 1e-6);
        assert!((seen.distance_m[index] - point.distance(view.eye)).abs() < 1e-6);
        ground += 1;
    }
    assert!(ground > 1000, "{ground}");
}

#[test]
fn silhouettes_are_where_the_ground_breaks_off() {
    // A plateau 30 m high before a plain: seen from above it, its far edge hides a strip.
    let cliff = |row: usize, _: usize| if row >= 24 { 30.0 } else { 0.0 };
    let case = Case::new(48, 48, cliff);
    let from_plateau = view(&case, dvec2(24.0, 34.0), 90.0, 0.0, -25.0);
    let seen = picture(&case, &from_plateau, &Default::default());
    // In the middle column one pixel at the plateau's edge, and one or two where the plain ends.
    let column: Vec<usize> = (0..48).filter(|row| seen.silhouette[row * 64 + 32]).collect();
    let edge = from_plateau.pixel_from_world(case.world(dvec2(24.25, 24.5)).extend(30.0)).unwrap();
    let horizon = from_plateau.pixel_from_world(case.world(dvec2(24.25, 0.0)).extend(0.0)).unwrap();
    for expected in [edge[1], horizon[1]] {
        assert!(
            column.iter().any(|&row| (row as f64 + 0.5 - expected).abs() <= 1.0),
            "{column:?} has nothing at {expected}"
        );
    }
    assert!(column.len() <= 4, "{column:?}");
    // Grazing ground without an edge has none.
    let plain = Case::new(48, 48, |_, _| 0.0);
    let low = view(&plain, dvec2(24.0, 47.0), 0.5, 0.0, -20.0);
    let seen = picture(&plain, &low, &Default::default());
    let horizon = low.pixel_from_world(plain.world(dvec2(24.0, 0.0)).extend(0.0)).unwrap()[1];
    for (index, _) in seen.silhouette.iter().enumerate().filter(|(_, is_edge)| **is_edge) {
        assert!(((index / 64) as f64 + 0.5 - horizon).abs() < 2.0, "row {}", index / 64);
    }
    assert!(seen.silhouette.contains(&true));
}

/// Mean and largest difference of two pictures in 8-bit steps.
fn difference(a: &ReferencePicture, b: &ReferencePicture) -> (f64, u8) {
    let steps = a.rgba.iter().flatten().zip(b.rgba.iter().flatten()).map(|(a, b)| a.abs_diff(*b));
    let sum: u32 = steps.clone().map(u32::from).sum();
    (f64::from(sum) / a.rgba.len() as f64 / 3.0, steps.max().unwrap_or(0))
}

#[test]
fn more_rays_bring_the_picture_nearer_to_the_truth() {
    let case = Case::bumpy(48, 48, 3, 30.0, false);
    let view = view(&case, dvec2(24.0, 46.0), 70.0, 5.0, -20.0);
    let view = CameraView { viewport_px: [32, 24], ..view };
    let with = |tolerance: f64, most_rays: u32| {
        let settings =
            ReferenceSettings { colour_tolerance: tolerance, most_rays, ..Default::default() };
        picture(&case, &view, &settings)
    };
    let truth = with(0.0, 1024);
    let errors = [4, 16, 64].map(|rays| difference(&with(0.0, rays), &truth).0);
    println!("mean errors with 4, 16, 64 rays: {errors:?}");
    assert!(errors.windows(2).all(|pair| pair[1] < 0.6 * pair[0]), "{errors:?}");
    let (mean, worst) = difference(&with(1.0, 256), &truth);
    println!("adaptive, tolerance 1: mean {mean}, worst {worst}");
    assert!(mean < 0.5 && worst <= 6, "mean {mean}, worst {worst}");
}

#[test]
fn the_picture_does_not_depend_on_the_number_of_threads() {
    let case = Case::bumpy(40, 40, 4, 40.0, true);
    let view = view(&case, dvec2(20.0, 36.0), 160.0, -10.0, -35.0);
    let taken = [1, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| picture(&case, &view, &Default::default()))
    });
    assert_eq!(taken[0].rgba, taken[1].rgba);
    assert_eq!(taken[0].silhouette, taken[1].silhouette);
}

#[test]
fn what_is_no_view_is_refused_and_work_can_be_called_off() {
    let case = Case::bumpy(16, 16, 5, 40.0, false);
    let good = view(&case, dvec2(8.0, 8.0), 100.0, 0.0, -30.0);
    let take = |view: CameraView, cancelled: bool| {
        let cancelled = AtomicBool::new(cancelled);
        render_reference(&case.scene, &view, &Default::default(), &NoProgress, &cancelled)
    };
    assert!(take(good, false).is_ok());
    let bad = [
        CameraView { viewport_px: [0, 10], ..good },
        CameraView { viewport_px: [10, 1 << 31], ..good },
        CameraView { eye: good.eye.with_z(f64::NAN), ..good },
        CameraView { fov_y_deg: 180.0, ..good },
        CameraView { pitch_deg: f64::INFINITY, ..good },
    ];
    for view in bad {
        assert!(matches!(take(view, false), Err(ReferenceError::View(_))), "{view:?}");
    }
    assert!(matches!(take(good, true), Err(ReferenceError::Cancelled)));
}
