use glam::DVec3;

use crate::CameraView;

/// The rays of a view: [`CameraView::ray_direction`] with what all pixels share computed once, and
/// without bringing it to length 1.
pub(super) struct CameraRays {
    pub eye: DVec3,
    corner: DVec3,
    /// Change of the direction from a pixel to the next one on the right, and below.
    pub step_right: DVec3,
    /// See `step_right`.
    pub step_down: DVec3,
}

impl CameraRays {
    pub fn new(view: &CameraView) -> Self {
        let half_height = (0.5 * view.fov_y_deg.to_radians()).tan();
        let axes = view.view_from_world();
        let to_right = axes.row(0) * (half_height * view.aspect());
        let to_top = axes.row(1) * half_height;
        let [width, height] = view.viewport_px.map(f64::from);
        Self {
            eye: view.eye,
            corner: -axes.row(2) - to_right + to_top,
            step_right: to_right * (2.0 / width),
            step_down: to_top * (-2.0 / height),
        }
    }

    /// The direction through a position in the picture: x right, y down, in pixels from its corner.
    pub fn direction(&self, x: f64, y: f64) -> DVec3 {
        self.corner + x * self.step_right + y * self.step_down
    }
}

#[cfg(test)]
mod tests {
    use glam::dvec3;

    use super::*;

    #[test]
    fn directions_are_those_of_the_view() {
        let view = CameraView {
            eye: dvec3(1.0, 2.0, 3.0),
            heading_deg: 200.0,
            pitch_deg: -35.0,
            fov_y_deg: 70.0,
            viewport_px: [320, 180],
        };
        let rays = CameraRays::new(&view);
        for (x, y) in [(0.0, 0.0), (160.0, 90.0), (319.5, 0.5), (17.25, 170.0)] {
            let difference = rays.direction(x, y).normalize() - view.ray_direction(x, y);
            assert!(difference.length() < 1e-14, "{x} {y}");
        }
    }
}
