use glam::{DVec3, dvec3};

use crate::CameraView;

/// How a view sees the triangles of a mesh: how large an error looks, and whether it is in the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight {
    eye: DVec3,
    /// Directions into the view, one from each side of the picture.
    sides: [DVec3; 4],
    pixels_per_radian: f64,
}

/// The ball that holds a triangle and the ground it stands for, and how far the two lie apart. Heights
/// exaggerated.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    pub centre: DVec3,
    pub radius_m: f32,
    pub error_m: f32,
}

impl Bounds {
    /// Of a triangle whose apex and ends of the longest edge these are.
    pub fn of(corners: [DVec3; 3], error_m: f32) -> Self {
        let [apex, left, right] = corners;
        let centre = 0.5 * (left + right);
        let radius_m = apex.distance(centre).max(left.distance(centre)) as f32;
        // An error that says "always cut" is no distance.
        let swell_m = if error_m.is_finite() { error_m } else { 0.0 };
        Self { centre, radius_m: radius_m + swell_m, error_m }
    }
}

impl Sight {
    /// The view's.
    pub fn new(view: &CameraView) -> Self {
        let [width, height] = view.viewport_px.map(f64::from);
        let corners = [(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)]
            .map(|(x, y)| view.ray_direction(x, y));
        // Clockwise in the picture: each cross product points outwards.
        let side = |index: usize| {
            let outwards = corners[index].cross(corners[(index + 1) % 4]);
            let into = if outwards.dot(view.forward()) < 0.0 { -outwards } else { outwards };
            into.try_normalize().unwrap_or(dvec3(0.0, 0.0, 0.0))
        };
        Self {
            eye: view.eye,
            sides: [side(0), side(1), side(2), side(3)],
            pixels_per_radian: 1.0 / view.pixel_angle_rad(),
        }
    }

    /// Whether the error may look larger than `tolerance_px`.
    pub(super) fn exceeds(&self, bounds: &Bounds, tolerance_px: f64) -> bool {
        if bounds.error_m <= 0.0 {
            return false;
        }
        let error_m = f64::from(bounds.error_m);
        let reach_m = f64::from(bounds.radius_m) + error_m * self.pixels_per_radian / tolerance_px;
        self.eye.distance_squared(bounds.centre) < reach_m * reach_m
    }

    /// At most so many pixels the error can look like: the angle it has across the line of sight at the
    /// ball's nearest point, at the picture's centre.
    pub(super) fn error_px(&self, bounds: &Bounds) -> f64 {
        if bounds.error_m <= 0.0 {
            return 0.0;
        }
        let distance_m = self.eye.distance(bounds.centre) - f64::from(bounds.radius_m);
        f64::from(bounds.error_m) * self.pixels_per_radian / distance_m.max(1.0e-3)
    }

    /// Whether any of the ball may be in the picture.
    pub(super) fn sees(&self, bounds: &Bounds) -> bool {
        let offset = bounds.centre - self.eye;
        let radius_m = f64::from(bounds.radius_m);
        self.sides.iter().all(|side| side.dot(offset) >= -radius_m)
    }
}
