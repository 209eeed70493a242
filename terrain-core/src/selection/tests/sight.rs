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

/// Whether any of a box is in the picture, by clipping its faces: a box that meets the view without a
/// face of it doing so would have to hold all the view sees, which has no end. `margin_m` widens the
/// view on all sides.
pub fn is_seen(view: &CameraView, bounds: &WorldBox, margin_m: f64) -> bool {
    let [width, height] = view.viewport_px.map(f64::from);
    let rays = [[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]]
        .map(|[x, y]| view.ray_direction(x, y));
    let inward = [0, 1, 2, 3].map(|i| rays[i].cross(rays[(i + 1) % 4]).normalize());
    let (min, max) = (bounds.min - view.eye, bounds.max - view.eye);
    let faces = (0..6).map(|face| {
        let (axis, end) = (face / 2, if face % 2 == 0 { min } else { max });
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        [[min[u], min[v]], [max[u], min[v]], [max[u], max[v]], [min[u], max[v]]].map(|[a, b]| {
            let mut corner = DVec3::ZERO;
            (corner[axis], corner[u], corner[v]) = (end[axis], a, b);
            corner
        })
    });
    faces.into_iter().any(|face| {
        let clipped = inward
            .iter()
            .fold(face.to_vec(), |polygon, normal| clipped(&polygon, *normal, margin_m));
        !clipped.is_empty()
    })
}

/// What of a polygon lies inside of a plane moved outward by `margin_m`. After I. Sutherland and
/// G. Hodgman, "Reentrant Polygon Clipping", 1974.
fn clipped(polygon: &[DVec3], inward: DVec3, margin_m: f64) -> Vec<DVec3> {
    let depth = |point: DVec3| inward.dot(point) + margin_m;
    let mut inside = Vec::new();
    for (index, &to) in polygon.iter().enumerate() {
        let from = polygon[(index + polygon.len() - 1) % polygon.len()];
        let (before, after) = (depth(from), depth(to));
        if (before < 0.0) != (after < 0.0) {
            inside.push(from.lerp(to, before / (before - after)));
        }
        if after >= 0.0 {
            inside.push(to);
        }
    }
    inside
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
    #![proptest_config(ProptestConfig::with_cases(2_000))]

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
        if grid(bounds).any(|point| is_in_picture(&view, point)) {
            prop_assert!(meets && is_seen(&view, &bounds, 1.0e-6), "a point in the picture");
        }
        prop_assert!(!meets || is_seen(&view, &bounds, 1.0e-6), "they are apart");
        prop_assert!(meets || !is_seen(&view, &bounds, -1.0e-6), "they meet");
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
