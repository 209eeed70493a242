//! What a view sees, by projections, and the pyramid of a view against it.

use glam::{DVec3, dvec3};
use proptest::prelude::*;

use crate::CameraView;
use crate::selection::view_pyramid::{ViewPyramid, WorldBox};

/// Whether a world point lies in the picture or on its border.
pub fn is_in_picture(view: &CameraView, point: DVec3) -> bool {
    let [width, height] = view.viewport_px.map(f64::from);
    view.pixel_from_world(point)
        .is_some_and(|[x, y]| (0.0..=width).contains(&x) && (0.0..=height).contains(&y))
}

/// The distance between a box and what the view sees, found by projecting a point onto one and the
/// other in turn until it is below `enough_m`: then an upper bound, else all but the distance itself.
pub fn distance_m(view: &CameraView, bounds: &WorldBox, enough_m: f64) -> f64 {
    let corners = corner_rays(view);
    let mut point = 0.5 * (bounds.min + bounds.max);
    let mut distance_m = f64::INFINITY;
    for _ in 0..4_000 {
        let seen = view.eye + nearest_seen(&corners, point - view.eye);
        point = seen.clamp(bounds.min, bounds.max);
        distance_m = point.distance(seen);
        if distance_m < enough_m {
            break;
        }
    }
    distance_m
}

/// The unit directions of the picture's corners, clockwise from the top left.
fn corner_rays(view: &CameraView) -> [DVec3; 4] {
    let [width, height] = view.viewport_px.map(f64::from);
    [[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]]
        .map(|[x, y]| view.ray_direction(x, y))
}

/// The point of the pyramid of these rays nearest to `point`, both relative to the eye: the point
/// itself, or one on a side or an edge, or the eye.
fn nearest_seen(rays: &[DVec3; 4], point: DVec3) -> DVec3 {
    let sides = [0, 1, 2, 3].map(|i| (rays[i], rays[(i + 1) % 4]));
    let inward = sides.map(|(a, b)| a.cross(b).normalize());
    if inward.iter().all(|normal| normal.dot(point) >= 0.0) {
        return point;
    }
    let mut nearest = DVec3::ZERO;
    let mut consider = |candidate: DVec3| {
        if candidate.distance(point) < nearest.distance(point) {
            nearest = candidate;
        }
    };
    for ((a, b), normal) in sides.into_iter().zip(inward) {
        consider(a * a.dot(point).max(0.0));
        let on_plane = point - normal * normal.dot(point);
        // On the side itself where it lies between the side's two edges.
        let between = a.cross(b);
        if a.cross(on_plane).dot(between) >= 0.0 && on_plane.cross(b).dot(between) >= 0.0 {
            consider(on_plane);
        }
    }
    nearest
}

fn view(heading_deg: f64, pitch_deg: f64, fov_y_deg: f64) -> CameraView {
    let eye = dvec3(4_000.0, -2_000.0, 700.0);
    CameraView { eye, heading_deg, pitch_deg, fov_y_deg, viewport_px: [1280, 720] }
}

/// Points of a box, a grid of 9 x 9 x 9.
fn grid(bounds: WorldBox) -> impl Iterator<Item = DVec3> {
    (0..729).map(move |i| {
        let part = dvec3(f64::from(i % 9), f64::from(i / 9 % 9), f64::from(i / 81)) / 8.0;
        bounds.min + part * (bounds.max - bounds.min)
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn a_box_meets_the_pyramid_where_they_share_a_point(
        (heading, pitch, fov) in (0.0..360.0f64, -90.0..=90.0f64, 5.0..150.0f64),
        offset in (-900.0..900.0f64, -900.0..900.0f64, -900.0..900.0f64),
        size in (0.0..600.0f64, 0.0..600.0f64, prop_oneof![Just(0.0), 0.0..600.0f64]),
    ) {
        let view = view(heading, pitch, fov);
        let min = view.eye + DVec3::from(offset);
        let bounds = WorldBox { min, max: min + DVec3::from(size) };
        let meets = ViewPyramid::new(&view).meets(&bounds);
        let distance_m = distance_m(&view, &bounds, 1.0e-6);
        if grid(bounds).any(|point| is_in_picture(&view, point)) {
            prop_assert!(meets && distance_m < 1.0e-6, "a point in the picture");
        }
        // Where the two all but touch, the projections have not told yet.
        prop_assert!(!meets || distance_m < 2.0, "{} m apart", distance_m);
        prop_assert!(meets || distance_m > 1.0e-6, "they meet");
    }
}

#[test]
fn a_box_beside_an_edge_of_the_pyramid_is_out_though_no_side_alone_tells() {
    // Level and square: at a distance d ahead the picture ends d above and 16/9 d beside the eye.
    let view = view(0.0, 0.0, 90.0);
    let from_eye = |min: [f64; 3], max: [f64; 3]| WorldBox {
        min: view.eye + DVec3::from(min),
        max: view.eye + DVec3::from(max),
    };
    let pyramid = ViewPyramid::new(&view);
    assert!(pyramid.meets(&from_eye([0.0, 10.0, 499.0], [9.0, 500.0, 900.0])));
    assert!(!pyramid.meets(&from_eye([0.0, 10.0, 501.0], [9.0, 500.0, 900.0])));
    // Before the eye and behind it, from far left to right: the sides' planes all pass through it.
    assert!(!pyramid.meets(&from_eye([-900.0, -50.0, 60.0], [900.0, 50.0, 90.0])));
    assert!(pyramid.meets(&from_eye([-900.0, -50.0, 40.0], [900.0, 50.0, 90.0])));
    assert!(!pyramid.meets(&from_eye([-9.0, -9.0, -9.0], [9.0, -1.0, 9.0])), "behind the eye");
}

#[test]
fn what_is_no_number_is_not_seen() {
    let bounds = WorldBox { min: DVec3::ZERO, max: DVec3::ONE };
    let lost = CameraView { eye: DVec3::NAN, ..view(0.0, 0.0, 50.0) };
    assert!(!ViewPyramid::new(&lost).meets(&bounds));
}
