use glam::{DVec3, dvec3};

use super::patch::{GlobePatch, Sphere};
use crate::CameraView;
use crate::geodesy::{Geodetic, Wgs84};

/// What an eye over the globe can see: the pyramid of its picture, and what the globe does not hide.
pub struct GlobeSight {
    /// Earth-centred, metres.
    pub eye: DVec3,
    /// Unit normals of the picture's sides and of the plane through the eye, pointing to what is seen.
    planes: [DVec3; 5],
    pixel_angle_rad: f64,
    unit_eye: DVec3,
    /// Radius of the ball that hides what is behind it, where the ellipsoid is one of radius 1.
    unit_solid: f64,
}

impl GlobeSight {
    /// Of a camera on a globe: its eye in metres on the plate carrée and above the ellipsoid. `lowest_m` is the
    /// lowest ground there is, at most 0.
    pub fn new(view: &CameraView, lowest_m: f64) -> Self {
        let place = Geodetic::from_plate_carree(view.eye);
        let eye = Wgs84::ecef_from_geodetic(&place);
        let ecef_from_view = place.ecef_from_local() * view.view_from_world().transpose();
        let half_height = (0.5 * view.fov_y_deg.to_radians()).tan();
        let half_width = half_height * view.aspect();
        let sides = [
            dvec3(-1.0, 0.0, -half_width),
            dvec3(1.0, 0.0, -half_width),
            dvec3(0.0, -1.0, -half_height),
            dvec3(0.0, 1.0, -half_height),
            dvec3(0.0, 0.0, -1.0),
        ];
        let (a, b) = (Wgs84::EQUATOR_RADIUS_M, Wgs84::POLAR_RADIUS_M);
        Self {
            eye,
            planes: sides.map(|side| ecef_from_view * side.normalize()),
            pixel_angle_rad: view.pixel_angle_rad(),
            unit_eye: eye / dvec3(a, a, b),
            unit_solid: (1.0 + lowest_m / b).max(0.0),
        }
    }

    /// Whether any of the patch may be in view.
    pub fn sees(&self, patch: &GlobePatch) -> bool {
        self.is_in_picture(&patch.bounds) && !self.is_behind_globe(&patch.unit_bounds)
    }

    /// The size in pixels that a cell of the patch has at the most.
    pub fn cell_px(&self, patch: &GlobePatch) -> f64 {
        patch.cell_m / (patch.distance_m(self.eye) * self.pixel_angle_rad)
    }

    /// How far in pixels the middle of a cell of the patch may be seen from the ellipsoid it spans.
    pub fn curve_px(&self, patch: &GlobePatch) -> f64 {
        // The middle of a diagonal, where the ellipsoid is bent most.
        let sagitta_m = 2.0 * patch.cell_m.powi(2) / (8.0 * Wgs84::meridian_radius_m(0.0));
        sagitta_m / (patch.distance_m(self.eye) * self.pixel_angle_rad)
    }

    fn is_in_picture(&self, ball: &Sphere) -> bool {
        let from_eye = ball.centre - self.eye;
        self.planes.iter().all(|plane| plane.dot(from_eye) >= -ball.radius)
    }

    /// Whether the globe hides all of a ball. Angles at the centre: what is no farther round than the eye's horizon
    /// and its own horizon together is seen.
    fn is_behind_globe(&self, ball: &Sphere) -> bool {
        let eye_distance = self.unit_eye.length();
        let distance = ball.centre.length();
        if eye_distance <= self.unit_solid || distance <= ball.radius {
            return false;
        }
        let horizon = |from_centre: f64| (self.unit_solid / from_centre).min(1.0).acos();
        let apart = self.unit_eye.angle_between(ball.centre) - (ball.radius / distance).asin();
        // Angles near 0 that come from cosines are exact to some 1e-8.
        apart > horizon(eye_distance) + horizon(distance + ball.radius) + 1.0e-7
    }
}
