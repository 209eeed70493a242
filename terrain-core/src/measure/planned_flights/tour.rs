use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::{FPS, FlightGround, SOUTH_RAD, eased, looking_at, on_circle};
use crate::measure::{Flight, FlightError, Keyframe};

/// A flight that shows a dataset: from a view of the whole down to its highest ground, low round
/// that, and out again.
pub(super) fn tour(ground: &FlightGround) -> Result<Flight, FlightError> {
    Flight::new(ground.crs.clone(), FPS, Tour::plan(ground).keyframes())
}

/// Keyframes of a full circle.
const ORBIT_STEPS: u32 = 32;
/// Seconds of a tour's three parts, a keyframe a second.
const APPROACH_S: u32 = 12;
const CIRCLE_S: u32 = 24;
const DEPARTURE_S: u32 = 8;
/// Radius of the low circle, and height of the eye over its ground, in parts of the shorter side.
const CIRCLE_RADIUS: f64 = 0.12;
const LOW_CLEARANCE: f64 = 0.025;
/// Place of the wide view, in parts of the shorter side: south of the centre, and above it.
const WIDE_DISTANCE: f64 = 0.75;
const WIDE_HEIGHT: f64 = 0.45;
/// Distance of the samples that a flight as far above the ground is planned by, in parts of the side.
const SAMPLES: f64 = 1.0 / 1024.0;

/// The places a tour is made of.
struct Tour<'a> {
    ground: &'a FlightGround<'a>,
    /// Middle of the extent, on the ground.
    centre: DVec3,
    /// The highest ground found in the inner part of the extent.
    summit: DVec3,
    wide: DVec3,
    radius_m: f64,
    clearance_m: f64,
    /// Height of the eye on the circle.
    low_height_m: f64,
}

impl<'a> Tour<'a> {
    fn plan(ground: &'a FlightGround<'a>) -> Self {
        let side_m = ground.side_m();
        let centre = on_ground(ground, ground.extent.centre());
        let summit = ground.summit();
        let radius_m = CIRCLE_RADIUS * side_m;
        let clearance_m = LOW_CLEARANCE * side_m;
        let circle = (0..4 * ORBIT_STEPS).map(|step| {
            let angle = TAU * f64::from(step) / f64::from(4 * ORBIT_STEPS);
            on_ground(ground, on_circle(summit.truncate(), radius_m, angle)).z
        });
        let low_height_m = circle.fold(f64::NEG_INFINITY, f64::max) + clearance_m;
        let wide = centre + DVec3::new(0.0, -WIDE_DISTANCE * side_m, WIDE_HEIGHT * side_m);
        Self { ground, centre, summit, wide, radius_m, clearance_m, low_height_m }
    }

    fn keyframes(&self) -> Vec<Keyframe> {
        let mut keyframes = Vec::new();
        let entry = self.on_low_circle(0.0);
        for second in 0..APPROACH_S {
            let way = eased(f64::from(second) / f64::from(APPROACH_S));
            keyframes.push(self.between(f64::from(second), self.wide, entry, way));
        }
        for second in 0..=CIRCLE_S {
            let turn = eased(f64::from(second) / f64::from(CIRCLE_S));
            let t = f64::from(APPROACH_S + second);
            keyframes.push(looking_at(t, self.on_low_circle(turn), self.summit));
        }
        for second in 1..=DEPARTURE_S {
            let way = 1.0 - eased(f64::from(second) / f64::from(DEPARTURE_S));
            let t = f64::from(APPROACH_S + CIRCLE_S + second);
            keyframes.push(self.between(t, self.wide, entry, way));
        }
        keyframes
    }

    /// The eye a part (0..=1) of the clockwise way round the summit, from its southern point.
    fn on_low_circle(&self, turn: f64) -> DVec3 {
        on_circle(self.summit.truncate(), self.radius_m, SOUTH_RAD - turn * TAU)
            .extend(self.low_height_m)
    }

    /// A part of the way (0..=1) from the wide view to the low one. The height above the low one's
    /// falls by the same factor in equal times, the way descending from afar looks steady.
    fn between(&self, t: f64, wide: DVec3, low: DVec3, way: f64) -> Keyframe {
        let position = wide.truncate().lerp(low.truncate(), way);
        let floor_m = low.z - self.clearance_m;
        let top_m = (wide.z - floor_m).max(self.clearance_m);
        let above_m = top_m.powf(1.0 - way) * self.clearance_m.powf(way);
        let ground_m = on_ground(self.ground, position).z;
        let height_m = (floor_m + above_m).max(ground_m + self.clearance_m);
        looking_at(t, position.extend(height_m), self.centre.lerp(self.summit, way))
    }
}

fn on_ground(ground: &FlightGround, point: DVec2) -> DVec3 {
    point.extend(ground.about_m(point, SAMPLES * ground.side_m()))
}
