//! The camera: where it stands, where it looks, and the matrices that follow from it.

use glam::{DMat3, DVec3, Mat4, Vec4, dvec3};
use serde::{Deserialize, Serialize};

/// One view of the terrain. World coordinates are f64 in the dataset's CRS; everything derived for
/// the GPU is relative to the eye.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CameraView {
    /// The eye: x east and y north in metres of the CRS, z metres above the datum.
    pub eye: DVec3,
    /// Degrees clockwise from grid north.
    pub heading_deg: f64,
    /// Degrees above the horizon; negative looks down. Within -90..=90.
    pub pitch_deg: f64,
    /// Vertical field of view in degrees, within (0, 180).
    pub fov_y_deg: f64,
    /// Width and height of the picture in pixels, both at least 1.
    pub viewport_px: [u32; 2],
}

/// Why a camera sees nothing that could be drawn.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum CameraError {
    /// The eye or the heading is no number.
    #[error(
        "the camera stands at {eye}, heading {heading_deg} degrees: that is no place or direction"
    )]
    NotFinite {
        /// The eye asked for.
        eye: DVec3,
        /// The heading asked for, degrees.
        heading_deg: f64,
    },
    /// The pitch lies beyond straight up or straight down.
    #[error("the camera's pitch is {0} degrees: it must lie between -90 and 90")]
    Pitch(f64),
    /// The field of view is empty, or too wide for a plane picture.
    #[error("the camera's field of view is {0} degrees: it must lie between 0 and 180")]
    FieldOfView(f64),
    /// The picture has no pixels.
    #[error("the camera's picture has {} x {} pixels: there is nothing to draw", .0[0], .0[1])]
    Empty([u32; 2]),
}

impl CameraView {
    /// Whether every value lies within its range.
    ///
    /// # Errors
    /// [`CameraError`] with the first value that does not.
    pub fn check(&self) -> Result<(), CameraError> {
        if !(self.eye.is_finite() && self.heading_deg.is_finite()) {
            return Err(CameraError::NotFinite { eye: self.eye, heading_deg: self.heading_deg });
        }
        if !(-90.0..=90.0).contains(&self.pitch_deg) {
            return Err(CameraError::Pitch(self.pitch_deg));
        }
        if !(self.fov_y_deg > 0.0 && self.fov_y_deg < 180.0) {
            return Err(CameraError::FieldOfView(self.fov_y_deg));
        }
        if self.viewport_px.contains(&0) {
            return Err(CameraError::Empty(self.viewport_px));
        }
        Ok(())
    }

    /// Rows are the camera's right, up and backward directions in world axes.
    pub fn view_from_world(&self) -> DMat3 {
        let (sin_h, cos_h) = self.heading_deg.to_radians().sin_cos();
        let (sin_p, cos_p) = self.pitch_deg.to_radians().sin_cos();
        let right = dvec3(cos_h, -sin_h, 0.0);
        let forward = dvec3(sin_h * cos_p, cos_h * cos_p, sin_p);
        let up = right.cross(forward);
        DMat3::from_cols(right, up, -forward).transpose()
    }

    /// The unit direction of view in world axes.
    pub fn forward(&self) -> DVec3 {
        -self.view_from_world().transpose().z_axis
    }

    /// Width over height of the picture.
    pub fn aspect(&self) -> f64 {
        f64::from(self.viewport_px[0]) / f64::from(self.viewport_px[1])
    }

    /// Angle in radians that one pixel subtends at the centre of the picture.
    pub fn pixel_angle_rad(&self) -> f64 {
        2.0 * (0.5 * self.fov_y_deg.to_radians()).tan() / f64::from(self.viewport_px[1])
    }

    /// Clip space from *eye-relative* world axes (metres): reverse depth, infinite far plane, so
    /// depth is 1 at `near_m` and falls to 0 at infinity.
    pub fn clip_from_relative(&self, near_m: f64) -> Mat4 {
        let focal = 1.0 / (0.5 * self.fov_y_deg.to_radians()).tan();
        let view = self.view_from_world();
        let (right, up, back) = (view.row(0), view.row(1), view.row(2));
        let x = right * (focal / self.aspect());
        let y = up * focal;
        let w = -back;
        let row = |v: DVec3, last: f64| Vec4::new(v.x as f32, v.y as f32, v.z as f32, last as f32);
        Mat4::from_cols(row(x, 0.0), row(y, 0.0), row(DVec3::ZERO, near_m), row(w, 0.0)).transpose()
    }

    /// Whether a sphere of so many metres round a world point may be seen: false only where it lies beyond a side
    /// of the view as a whole, or behind the eye.
    pub fn may_see_sphere(&self, centre: DVec3, radius_m: f64) -> bool {
        let in_view = self.view_from_world() * (centre - self.eye);
        let half_height = (0.5 * self.fov_y_deg.to_radians()).tan();
        let depth_m = -in_view.z;
        // Distance beyond the nearer of two opposite planes through the eye.
        let beyond_m =
            |across_m: f64, slope: f64| (across_m.abs() - depth_m * slope) / slope.hypot(1.0);
        let sides = [(in_view.x, half_height * self.aspect()), (in_view.y, half_height)];
        let is_beyond = sides.iter().any(|&(across_m, slope)| beyond_m(across_m, slope) > radius_m);
        !is_beyond && -depth_m <= radius_m
    }

    /// The unit world direction through a pixel position (x right, y down, pixel centres at .5).
    pub fn ray_direction(&self, pixel_x: f64, pixel_y: f64) -> DVec3 {
        let half_height = (0.5 * self.fov_y_deg.to_radians()).tan();
        let [width, height] = self.viewport_px.map(f64::from);
        let right = (2.0 * pixel_x / width - 1.0) * half_height * self.aspect();
        let up = (1.0 - 2.0 * pixel_y / height) * half_height;
        (self.view_from_world().transpose() * dvec3(right, up, -1.0)).normalize()
    }

    /// The pixel position of a world point, or `None` behind the eye.
    pub fn pixel_from_world(&self, point: DVec3) -> Option<[f64; 2]> {
        let in_view = self.view_from_world() * (point - self.eye);
        let depth_m = -in_view.z;
        if depth_m <= 0.0 {
            return None;
        }
        let half_height = (0.5 * self.fov_y_deg.to_radians()).tan();
        let ndc_x = in_view.x / (depth_m * half_height * self.aspect());
        let ndc_y = in_view.y / (depth_m * half_height);
        let [width, height] = self.viewport_px.map(f64::from);
        Some([(ndc_x + 1.0) * 0.5 * width, (1.0 - ndc_y) * 0.5 * height])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view() -> CameraView {
        CameraView {
            eye: dvec3(500_000.0, 6_800_000.0, 2_000.0),
            heading_deg: 90.0,
            pitch_deg: -30.0,
            fov_y_deg: 60.0,
            viewport_px: [1280, 720],
        }
    }

    #[test]
    fn heading_turns_clockwise_from_north_and_pitch_looks_down() {
        let forward = view().forward();
        assert!((forward - dvec3(0.75_f64.sqrt(), 0.0, -0.5)).length() < 1e-12, "{forward}");
    }

    #[test]
    fn pixel_and_ray_are_inverse() {
        let view = view();
        for (x, y) in [(0.5, 0.5), (640.0, 360.0), (1000.25, 17.75)] {
            let point = view.eye + 12_345.0 * view.ray_direction(x, y);
            let pixel = view.pixel_from_world(point).unwrap_or([f64::NAN; 2]);
            assert!((pixel[0] - x).abs() < 1e-6 && (pixel[1] - y).abs() < 1e-6, "{pixel:?}");
        }
        assert_eq!(view.pixel_from_world(view.eye - view.forward()), None);
    }

    #[test]
    fn the_matrix_agrees_with_the_pixel_position() {
        let view = view();
        let offset = 3_000.0 * view.ray_direction(200.0, 600.0);
        let clip = view.clip_from_relative(1.0) * offset.as_vec3().extend(1.0);
        let ndc = clip / clip.w;
        assert!((f64::from(ndc.x) - (200.0 / 640.0 - 1.0)).abs() < 1e-6);
        assert!((f64::from(ndc.y) - (1.0 - 600.0 / 360.0)).abs() < 1e-6);
        assert!((ndc.z - 1.0 / clip.w).abs() < 1e-9, "depth is near over distance");
    }

    #[test]
    fn a_sphere_is_left_out_only_where_no_pixel_meets_it() {
        let view = view();
        let pixels = (0..90)
            .flat_map(|y| (0..160).map(move |x| (8.0 * x as f64 + 4.0, 8.0 * y as f64 + 4.0)));
        let rays = pixels.map(|(x, y)| view.ray_direction(x, y)).collect::<Vec<_>>();
        let mut seen = 0;
        for index in 0..400 {
            let turn = f64::from(index) * 2.399_963;
            let offset = dvec3(turn.cos(), turn.sin(), 1.0 - f64::from(index) / 200.0)
                * (50.0 + f64::from(index));
            let met = rays.iter().any(|ray| {
                let along = ray.dot(offset).max(0.0);
                (offset - along * *ray).length() < 20.0
            });
            seen += usize::from(met);
            assert!(!met || view.may_see_sphere(view.eye + offset, 20.0), "{offset}");
        }
        assert!(seen > 20, "{seen}");
        assert!(!view.may_see_sphere(view.eye - 100.0 * view.forward(), 50.0), "behind the eye");
        let side = view.view_from_world().row(0);
        assert!(!view.may_see_sphere(view.eye + 300.0 * view.forward() + 500.0 * side, 50.0));
        assert!(view.may_see_sphere(view.eye, f64::INFINITY));
    }

    #[test]
    fn straight_down_has_a_defined_up_direction() {
        let down = CameraView { pitch_deg: -90.0, heading_deg: 0.0, ..view() };
        let up = down.view_from_world().row(1);
        assert!((up - dvec3(0.0, 1.0, 0.0)).length() < 1e-12, "{up}");
    }
}
