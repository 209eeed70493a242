//! A short, soft move of the camera from one view to another.

use terrain_core::CameraView;

/// How long a move takes, seconds.
const DURATION_S: f64 = 0.7;

/// A move under way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraGlide {
    from: CameraView,
    to: CameraView,
    elapsed_s: f64,
}

impl CameraGlide {
    /// Starts to move; the goal keeps the start's viewport.
    pub fn new(from: CameraView, to: CameraView) -> Self {
        Self { from, to: CameraView { viewport_px: from.viewport_px, ..to }, elapsed_s: 0.0 }
    }

    /// Moves on by `dt_s` seconds; returns the view there and whether it is the goal.
    pub fn advance(&mut self, dt_s: f64) -> (CameraView, bool) {
        self.elapsed_s += dt_s;
        let t = (self.elapsed_s / DURATION_S).clamp(0.0, 1.0);
        if t >= 1.0 {
            return (self.to, true);
        }
        let soft = t * t * (3.0 - 2.0 * t);
        let (from, to) = (&self.from, &self.to);
        let mix = |a: f64, b: f64| a + (b - a) * soft;
        let view = CameraView {
            eye: from.eye.lerp(to.eye, soft),
            heading_deg: from.heading_deg + turn_deg(from.heading_deg, to.heading_deg) * soft,
            pitch_deg: mix(from.pitch_deg, to.pitch_deg),
            fov_y_deg: mix(from.fov_y_deg, to.fov_y_deg),
            viewport_px: to.viewport_px,
        };
        (view, false)
    }
}

/// Degrees to turn from one heading to another by the shorter way, within -180..=180.
fn turn_deg(from_deg: f64, to_deg: f64) -> f64 {
    (to_deg - from_deg + 180.0).rem_euclid(360.0) - 180.0
}

#[cfg(test)]
mod tests {
    use glam::dvec3;

    use super::*;

    #[test]
    fn it_ends_at_the_goal_and_turns_the_shorter_way() {
        let from = CameraView {
            eye: dvec3(0.0, 0.0, 1_000.0),
            heading_deg: 350.0,
            pitch_deg: -30.0,
            fov_y_deg: 60.0,
            viewport_px: [640, 480],
        };
        let to = CameraView { heading_deg: 20.0, eye: dvec3(500.0, 0.0, 3_000.0), ..from };
        let mut glide = CameraGlide::new(from, to);
        let (half, arrived) = glide.advance(DURATION_S / 2.0);
        assert!(!arrived && (half.heading_deg - 365.0).abs() < 1e-9, "{}", half.heading_deg);
        assert!((half.eye - dvec3(250.0, 0.0, 2_000.0)).length() < 1e-9);
        assert_eq!(glide.advance(DURATION_S), (to, true));
    }
}
