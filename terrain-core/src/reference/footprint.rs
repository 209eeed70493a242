//! The ground that a piece of a pixel covers.

use glam::{DVec2, DVec3};

/// The ellipse on the map that stands for a piece of a pixel on the ground: the image of a circle
/// under the pixel's own mapping, as in Paul Heckbert, "Fundamentals of Texture Mapping and Image
/// Warping", 1989.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Footprint {
    /// Its longer axis, from end to end, in metres east and north.
    pub long_axis_m: DVec2,
    /// Length of its shorter axis in metres.
    pub width_m: f64,
}

impl Footprint {
    /// Of a parallelogram with these sides.
    pub fn of_parallelogram(a: DVec2, b: DVec2) -> Self {
        // Half axes are the singular values of the matrix (a b).
        let (xx, xy, yy) = (a.x * a.x + b.x * b.x, a.x * a.y + b.x * b.y, a.y * a.y + b.y * b.y);
        let mean = 0.5 * (xx + yy);
        let spread = (0.5 * (xx - yy)).hypot(xy);
        let angle = 0.5 * xy.atan2(0.5 * (xx - yy));
        let length_m = (mean + spread).sqrt();
        let area_m2 = a.perp_dot(b).abs();
        Self {
            long_axis_m: DVec2::from_angle(angle) * length_m,
            width_m: if length_m > 0.0 { area_m2 / length_m } else { 0.0 },
        }
    }

    /// Length of its longer axis in metres.
    pub fn length_m(&self) -> f64 {
        self.long_axis_m.length()
    }
}

/// How the point where a ray meets a plane moves when the ray does: `direction` of any length, its
/// change `step`, the plane's upward `normal` and the way along the ray in units of `direction`.
/// Metres east and north. A plane seen edge on is taken to be tilted by a thousandth.
pub(super) fn ground_step(direction: DVec3, step: DVec3, normal: DVec3, way: f64) -> DVec2 {
    let least = 1e-3 * normal.length() * direction.length();
    let facing = -(normal.dot(direction).abs().max(least));
    (way * (step - direction * (normal.dot(step) / facing))).truncate()
}

#[cfg(test)]
mod tests {
    use glam::{dvec2, dvec3};

    use super::*;

    #[test]
    fn a_rectangle_keeps_its_sides_however_it_is_turned() {
        for turn in [0.0, 0.3, 1.2, 2.5] {
            let axis = DVec2::from_angle(turn);
            let footprint = Footprint::of_parallelogram(axis * 5.0, axis.perp() * 2.0);
            assert!((footprint.length_m() - 5.0).abs() < 1e-12);
            assert!((footprint.width_m - 2.0).abs() < 1e-12);
            assert!(footprint.long_axis_m.perp_dot(axis).abs() < 1e-12, "{turn}");
        }
        let none = Footprint::of_parallelogram(DVec2::ZERO, DVec2::ZERO);
        assert_eq!((none.length_m(), none.width_m), (0.0, 0.0));
    }

    #[test]
    fn the_step_on_the_ground_is_the_difference_of_two_rays() {
        let (direction, step) = (dvec3(0.3, 1.0, -0.4), dvec3(1e-6, -2e-6, 3e-6));
        let normal = dvec3(-0.2, 0.1, 1.0);
        // A plane through a point 100 directions away.
        let way = |ray: DVec3| 100.0 * direction.dot(normal) / ray.dot(normal);
        let moved = way(direction + step) * (direction + step) - 100.0 * direction;
        let found = ground_step(direction, step, normal, 100.0);
        assert!((found - dvec2(moved.x, moved.y)).length() < 1e-5 * found.length(), "{found}");
    }
}
