//! Where the edges of nearer ground run.

use super::camera_rays::CameraRays;
use super::tracer::Tracer;

/// Halvings of a pixel's side: rays end up a thousandth of a pixel apart.
const HALVINGS: u32 = 10;

/// Tells pixels through which the edge of something nearer runs.
///
/// Such an edge enters and leaves a pixel across its sides. A side is crossed by one if of the rays
/// through its two ends one sees sky and the other ground, or if they see ground at distances that
/// differ by more than a pixel's width there, and halving the side again and again, each time
/// keeping the half with the larger difference, leaves such a difference between two rays 1/1024 of
/// a pixel apart. Ground without an edge shows such a difference only where it is seen at so small an
/// angle that a pixel spans a thousand times its width.
pub(super) struct SilhouetteTest<'a> {
    pub tracer: &'a dyn Tracer,
    pub rays: &'a CameraRays,
    /// Angle that a pixel subtends.
    pub pixel_angle_rad: f64,
}

impl SilhouetteTest<'_> {
    /// Distance to the ground through a position in the picture; infinite where there is sky.
    pub fn distance_m(&self, [x, y]: [f64; 2]) -> f64 {
        let seen = self.tracer.seen(self.rays.direction(x, y));
        seen.map_or(f64::INFINITY, |seen| seen.distance_m)
    }

    /// Whether an edge crosses the line between two positions at which distances are known.
    pub fn is_crossed(&self, mut ends: [[f64; 2]; 2], mut distances_m: [f64; 2]) -> bool {
        for _ in 0..HALVINGS {
            match self.gap_m(distances_m) {
                None => return false,
                Some(gap_m) if gap_m.is_infinite() => return true,
                Some(_) => {}
            }
            let middle = [0.5 * (ends[0][0] + ends[1][0]), 0.5 * (ends[0][1] + ends[1][1])];
            let distance_m = self.distance_m(middle);
            let (near, far) = ([distances_m[0], distance_m], [distance_m, distances_m[1]]);
            let gap_of = |pair: [f64; 2]| self.gap_m(pair).unwrap_or(0.0);
            if gap_of(near) >= gap_of(far) {
                (ends[1], distances_m) = (middle, near);
            } else {
                (ends[0], distances_m) = (middle, far);
            }
        }
        self.gap_m(distances_m).is_some()
    }

    /// The difference of two distances, where it is more than a pixel's width.
    fn gap_m(&self, [a, b]: [f64; 2]) -> Option<f64> {
        if a.is_infinite() && b.is_infinite() {
            return None;
        }
        let gap_m = (a - b).abs();
        (gap_m > a.min(b) * self.pixel_angle_rad).then_some(gap_m)
    }
}
