use glam::{DVec2, dvec2};

use super::height_profile::{above_ground, level_above_ground};
use super::{FOV_DEG, FlightGround, heading_deg};
use crate::measure::{Flight, FlightError, Keyframe};

/// Seconds of a straight flight, and of an orbit.
const STRAIGHT_S: u32 = 20;
const ORBIT_S: u32 = 24;
/// Keyframes a second.
const KEYFRAMES_A_SECOND: u32 = 4;
/// Clearances that a low flight makes in a second.
const LOW_SPEED: f64 = 2.0;
/// The most of the shorter side that a straight flight crosses.
const MOST_OF_SIDE: f64 = 0.8;
/// Height of a high flight over the highest ground below it, in parts of the shorter side.
const HIGH_CLEARANCE: f64 = 0.1;
const LOW_PITCH_DEG: f64 = -10.0;
const HIGH_PITCH_DEG: f64 = -35.0;

/// Straight ahead over the summit, close above the ground.
pub(super) fn low(ground: &FlightGround) -> Result<Flight, FlightError> {
    let clearance_m = ground.low_clearance_m();
    let way_m = LOW_SPEED * clearance_m * f64::from(STRAIGHT_S);
    let way_m = way_m.min(MOST_OF_SIDE * ground.side_m());
    let keyframes = straight(ground, ground.summit().truncate(), way_m, LOW_PITCH_DEG);
    above_ground(ground, keyframes, clearance_m)
}

/// Straight across the middle of the dataset at constant height.
pub(super) fn high(ground: &FlightGround) -> Result<Flight, FlightError> {
    let way_m = MOST_OF_SIDE * ground.side_m();
    let keyframes = straight(ground, ground.extent.centre(), way_m, HIGH_PITCH_DEG);
    level_above_ground(ground, keyframes, HIGH_CLEARANCE * ground.side_m())
}

/// Once clockwise round the summit at constant height, always looking at it, beginning south of it.
pub(super) fn orbit(ground: &FlightGround) -> Result<Flight, FlightError> {
    let summit = ground.summit();
    let clearance_m = 2.0 * ground.low_clearance_m();
    let keyframes = (0..=ORBIT_S * KEYFRAMES_A_SECOND).map(|step| {
        let t = f64::from(step) / f64::from(KEYFRAMES_A_SECOND);
        let place = ground.round(summit, t / f64::from(ORBIT_S));
        keyframe(t, place, summit.truncate() - place, 0.0)
    });
    let level = level_above_ground(ground, keyframes.collect(), clearance_m)?;
    let height_m = level.keyframes()[0].height;
    let target_m = ground.finest_m(summit.truncate());
    let pitch = (target_m - height_m).atan2(ground.circle_radius_m()).to_degrees();
    let aimed = level.keyframes().iter().map(|level| Keyframe { pitch, ..*level });
    Flight::new(ground.crs.clone(), super::FPS, aimed.collect())
}

/// A straight way through a place, along the longer side of the extent and as far inside it as its
/// length allows.
fn straight(ground: &FlightGround, through: DVec2, way_m: f64, pitch_deg: f64) -> Vec<Keyframe> {
    let extent = ground.extent;
    let size = extent.size_m();
    let way = if size.x >= size.y { dvec2(way_m, 0.0) } else { dvec2(0.0, way_m) };
    let margin = 0.5 * (size - way).min(DVec2::splat((1.0 - MOST_OF_SIDE) * ground.side_m()));
    let start = (through - 0.5 * way).clamp(extent.min + margin, extent.max - margin - way);
    let steps = STRAIGHT_S * KEYFRAMES_A_SECOND;
    let at = |step: u32| {
        let t = f64::from(step) / f64::from(KEYFRAMES_A_SECOND);
        keyframe(t, start + way * (f64::from(step) / f64::from(steps)), way, pitch_deg)
    };
    (0..=steps).map(at).collect()
}

/// A keyframe that looks along a way; its height is still to be found.
pub(super) fn keyframe(t: f64, place: DVec2, way: DVec2, pitch: f64) -> Keyframe {
    let heading = heading_deg(way);
    Keyframe { t, x: place.x, y: place.y, height: 0.0, heading, pitch, fov: FOV_DEG }
}
