//! Which point of the ground lies under a pixel.

use glam::{DVec2, DVec3};
use terrain_core::CameraView;

/// Height of the ground as it is drawn (exaggerated), metres; `None` where there is no data.
pub type GroundHeight<'a> = &'a dyn Fn(DVec2) -> Option<f64>;

/// How much farther every step of the search looks than the one before.
const STEP_GROWTH: f64 = 1.03;
/// Halvings of the last step: a thousandth of it is far below a pixel.
const REFINEMENTS: u32 = 12;

/// The first point of the ground along the ray through a pixel, searched from `near_m` to `far_m`
/// metres; `None` where the ray meets no data.
///
/// The steps grow with distance, as the size of what can be seen does: a ridge thinner than 3 % of
/// its distance may be missed.
pub fn pick_ground(
    view: &CameraView,
    pixel: [f64; 2],
    ground: GroundHeight<'_>,
    near_m: f64,
    far_m: f64,
) -> Option<DVec3> {
    pick_ground_at(view, pixel, ground, (near_m, far_m), |point| point)
}

/// [`pick_ground`] where the ray's points have other places on the ground than their own: `place_of` tells them, and
/// the heights of the points there.
pub fn pick_ground_at(
    view: &CameraView,
    pixel: [f64; 2],
    ground: GroundHeight<'_>,
    (near_m, far_m): (f64, f64),
    place_of: impl Fn(DVec3) -> DVec3,
) -> Option<DVec3> {
    let direction = view.ray_direction(pixel[0], pixel[1]);
    let at = |distance_m: f64| view.eye + distance_m * direction;
    let is_below = |distance_m: f64| {
        let place = place_of(at(distance_m));
        ground(place.truncate()).is_some_and(|height_m| place.z <= height_m)
    };
    let mut above_m = 0.0;
    let mut distance_m = near_m;
    while distance_m <= far_m {
        if is_below(distance_m) {
            return Some(at(crossing(above_m, distance_m, is_below)));
        }
        above_m = distance_m;
        distance_m *= STEP_GROWTH;
    }
    None
}

/// The distance between `above_m` and `below_m` at which the ray goes under the ground.
fn crossing(mut above_m: f64, mut below_m: f64, is_below: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..REFINEMENTS {
        let middle_m = 0.5 * (above_m + below_m);
        if is_below(middle_m) {
            below_m = middle_m;
        } else {
            above_m = middle_m;
        }
    }
    below_m
}

/// Where the ray through a pixel meets the level plane at `height_m`, for an eye above it.
///
/// A ray flatter than `least_slope` (metres down a metre ahead), or one that rises, is bent down to
/// that slope: near the horizon a pixel's width spans kilometres, and nobody can hold on to that.
pub fn pick_plane(view: &CameraView, pixel: [f64; 2], height_m: f64, least_slope: f64) -> DVec3 {
    let direction = view.ray_direction(pixel[0], pixel[1]);
    let ahead = direction.truncate();
    let down = (-direction.z).max(least_slope * ahead.length());
    let drop_m = (view.eye.z - height_m).max(0.0);
    (view.eye.truncate() + ahead * (drop_m / down)).extend(view.eye.z - drop_m)
}

#[cfg(test)]
mod tests {
    use glam::{dvec2, dvec3};

    use super::*;

    fn view(pitch_deg: f64) -> CameraView {
        CameraView {
            eye: dvec3(500_000.0, 6_800_000.0, 2_000.0),
            heading_deg: 30.0,
            pitch_deg,
            fov_y_deg: 60.0,
            viewport_px: [800, 600],
        }
    }

    #[test]
    fn the_pick_of_a_plane_is_the_intersection() {
        let view = view(-25.0);
        let slope = |xy: DVec2| Some(300.0 + 0.1 * (xy.x - 500_000.0));
        let pixel = [600.0, 350.0];
        let hit = pick_ground(&view, pixel, &slope, 10.0, 1.0e6).unwrap();
        // The ray eye + t d meets z = 300 + 0.1 (x - x0) where 2000 + t dz = 300 + 0.1 t dx.
        let direction = view.ray_direction(pixel[0], pixel[1]);
        let expected = view.eye + direction * (1_700.0 / (0.1 * direction.x - direction.z));
        assert!((hit - expected).length() < 0.1, "{hit} {expected}");
    }

    #[test]
    fn the_nearer_ridge_is_picked() {
        let view = view(-10.0);
        let ahead = dvec2(0.5, 0.75_f64.sqrt());
        let ridge = |xy: DVec2| {
            let along_m = (xy - dvec2(500_000.0, 6_800_000.0)).dot(ahead);
            Some(if (3_000.0..4_000.0).contains(&along_m) { 1_900.0 } else { 0.0 })
        };
        let hit = pick_ground(&view, [400.0, 300.0], &ridge, 10.0, 1.0e6).unwrap();
        let along_m = (hit - view.eye).truncate().dot(ahead);
        assert!((2_999.0..3_010.0).contains(&along_m), "{along_m}");
    }

    #[test]
    fn sky_and_ground_without_data_are_no_pick() {
        let flat = |_: DVec2| Some(0.0);
        let nothing = |_: DVec2| None;
        assert_eq!(pick_ground(&view(20.0), [400.0, 10.0], &flat, 10.0, 1.0e6), None);
        assert_eq!(pick_ground(&view(-20.0), [400.0, 300.0], &nothing, 10.0, 1.0e6), None);
    }

    #[test]
    fn a_plane_is_met_exactly_and_rays_into_the_sky_are_bent_down() {
        let view = view(-25.0);
        let point = pick_plane(&view, [600.0, 350.0], 100.0, 0.05);
        let pixel = view.pixel_from_world(point).unwrap();
        assert!((pixel[0] - 600.0).abs() < 1e-6 && (pixel[1] - 350.0).abs() < 1e-6, "{pixel:?}");
        let far = pick_plane(&view, [600.0, -5_000.0], 100.0, 0.05);
        let ahead_m = (far - view.eye).truncate().length();
        assert!((ahead_m - 1_900.0 / 0.05).abs() < 1e-6, "{ahead_m}");
    }
}
