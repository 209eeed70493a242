use glam::{DVec2, DVec3, Vec3};

use super::footprint::disc_part_beyond;
use super::{Footprint, FootprintIntegral};
use crate::CameraView;

/// A horizontal plane of two colours: black on one side of a straight border, white on the other. The
/// published experiment's surface; everything about it is exact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfPlane {
    /// A point of the border, metres.
    pub on_border: DVec2,
    /// Unit vector across the border, to the white side.
    pub to_white: DVec2,
}

impl HalfPlane {
    /// Distance in metres from the border to a point, positive on the white side.
    pub fn beyond_m(&self, point: DVec2) -> f64 {
        (point - self.on_border).dot(self.to_white)
    }

    /// The white part of a square, exactly: north-western corner and side in metres.
    pub fn white_part_of_square(&self, north_west: DVec2, side_m: f64) -> f64 {
        let corners = [DVec2::ZERO, DVec2::X, DVec2::new(1.0, -1.0), DVec2::NEG_Y];
        let beyond = corners.map(|corner| self.beyond_m(north_west + corner * side_m) / side_m);
        part_of_square_beyond(beyond)
    }

    /// The ideal filter: the white part of a pixel's square in the picture, exactly. In a picture a
    /// plane's straight border is a straight line. `None` where the plane is not before the pixel.
    pub fn white_part_of_pixel(&self, view: &CameraView, pixel: [u32; 2]) -> Option<f64> {
        let [x, y] = pixel.map(f64::from);
        let corners = [[x, y], [x + 1.0, y], [x + 1.0, y + 1.0], [x, y + 1.0]];
        let mut beyond = [0.0; 4];
        for (beyond, [x, y]) in beyond.iter_mut().zip(corners) {
            let direction = view.ray_direction(x, y);
            if direction.z >= 0.0 {
                return None;
            }
            let along = -view.forward().dot(direction) * view.eye.z / direction.z;
            let point = view.eye - direction * (view.eye.z / direction.z);
            // Divided by the depth, distances from the border are linear in the picture.
            *beyond = self.beyond_m(point.truncate()) / along;
        }
        let scale = beyond.iter().fold(0.0_f64, |most, part| most.max(part.abs()));
        Some(part_of_square_beyond(beyond.map(|part| part / scale)))
    }
}

/// The part of the unit square in which a function is positive that is linear over it, given its
/// values at the corners in order round the square.
fn part_of_square_beyond(values: [f64; 4]) -> f64 {
    const CORNERS: [DVec2; 4] = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
    let mut polygon: Vec<DVec2> = Vec::with_capacity(5);
    for corner in 0..4 {
        let next = (corner + 1) % 4;
        let (value, next_value) = (values[corner], values[next]);
        if value > 0.0 {
            polygon.push(CORNERS[corner]);
        }
        if (value > 0.0) != (next_value > 0.0) {
            let part = value / (value - next_value);
            polygon.push(CORNERS[corner].lerp(CORNERS[next], part));
        }
    }
    let doubled: f64 =
        (0..polygon.len()).map(|i| polygon[i].perp_dot(polygon[(i + 1) % polygon.len()])).sum();
    0.5 * doubled.abs()
}

/// The footprint of a point of the plane is a circle, and the white part of it a segment.
impl FootprintIntegral for HalfPlane {
    fn mean_colour(&self, footprint: &Footprint) -> Vec3 {
        let line_m = -self.beyond_m(DVec3::truncate(footprint.centre));
        Vec3::splat(disc_part_beyond(line_m, footprint.radius_m()) as f32)
    }
}

#[cfg(test)]
mod tests {
    use glam::{dvec2, dvec3};

    use super::*;

    fn tilted(angle_deg: f64) -> HalfPlane {
        let to_white = DVec2::from_angle(angle_deg.to_radians());
        HalfPlane { on_border: dvec2(10.1, -3.7), to_white }
    }

    #[test]
    fn the_white_part_of_a_square_is_that_of_a_fine_count() {
        for step in 0..40 {
            let plane = tilted(9.7 * f64::from(step));
            let north_west = plane.on_border + dvec2(-2.0, 2.0) * (0.9 * f64::from(step)).sin();
            let side = 400;
            let inside = |x: i32, y: i32| {
                let at = |i: i32| (f64::from(i) + 0.5) / f64::from(side) * 3.0;
                plane.beyond_m(north_west + dvec2(at(x), -at(y))) > 0.0
            };
            let count = (0..side * side).filter(|i| inside(i % side, i / side)).count();
            let expected = count as f64 / f64::from(side * side);
            let found = plane.white_part_of_square(north_west, 3.0);
            assert!((found - expected).abs() < 2e-3, "{step}: {found} {expected}");
        }
    }

    #[test]
    fn the_white_part_of_a_pixel_is_that_of_many_rays_also_when_tilted() {
        let plane = tilted(23.0);
        let eye = plane.on_border.extend(0.0) + dvec3(3.0, -40.0, 25.0);
        let fov_y_deg = 30.0;
        let view =
            CameraView { eye, heading_deg: 5.0, pitch_deg: -33.0, fov_y_deg, viewport_px: [9, 9] };
        for (x, y) in (0..9).flat_map(|x| (0..9).map(move |y| (x, y))) {
            let side = 100;
            let is_white = |i: u32| {
                let [dx, dy] = [i % side, i / side].map(|i| (f64::from(i) + 0.5) / f64::from(side));
                let direction = view.ray_direction(f64::from(x) + dx, f64::from(y) + dy);
                let point = eye - direction * (eye.z / direction.z);
                plane.beyond_m(point.truncate()) > 0.0
            };
            let white = (0..side * side).filter(|&i| is_white(i)).count();
            let expected = white as f64 / f64::from(side * side);
            let found = plane.white_part_of_pixel(&view, [x, y]).unwrap();
            assert!((found - expected).abs() < 5e-3, "{x} {y}: {found} {expected}");
        }
    }
}
