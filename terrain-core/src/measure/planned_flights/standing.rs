use glam::{DVec2, DVec3, dvec2};

use super::{FOV_DEG, FPS, FlightGround, eased, heading_deg, looking_at};
use crate::measure::{Flight, FlightError, Keyframe};

const HOVER_S: f64 = 5.0;
const SPIN_S: u32 = 12;
const SPIN_PITCH_DEG: f64 = -8.0;
const CLIMB_S: u32 = 12;
const CLIMB_PITCH_DEG: f64 = -50.0;
/// Height of the highest place, in parts of the shorter side.
const TOP: f64 = 0.9;
const PLACES: u32 = 8;
const HOLD_S: f64 = 1.5;
const TELEPORT_PITCH_DEG: f64 = -15.0;

/// Standing south of the summit, looking at it.
pub(super) fn hover(ground: &FlightGround) -> Result<Flight, FlightError> {
    let start = viewpoint(ground);
    let end = Keyframe { t: HOVER_S, ..start };
    Flight::new(ground.crs.clone(), FPS, vec![start, end])
}

/// Once round, clockwise, on the spot.
pub(super) fn spin(ground: &FlightGround) -> Result<Flight, FlightError> {
    let start = viewpoint(ground);
    let keyframes = (0..=SPIN_S).map(|second| {
        let heading = start.heading + 360.0 * f64::from(second) / f64::from(SPIN_S);
        Keyframe { t: f64::from(second), heading, pitch: SPIN_PITCH_DEG, ..start }
    });
    Flight::new(ground.crs.clone(), FPS, keyframes.collect())
}

/// Straight up and down again. The height above ground grows by the same factor in equal times, the way
/// a climb looks steady.
pub(super) fn climb_and_descend(ground: &FlightGround) -> Result<Flight, FlightError> {
    let start = viewpoint(ground);
    let low_m = ground.low_clearance_m();
    let floor_m = start.height - low_m;
    let top_m = TOP * ground.side_m();
    let keyframes = (0..=2 * CLIMB_S).map(|second| {
        let climbed = 1.0 - (f64::from(second) / f64::from(CLIMB_S) - 1.0).abs();
        let above_m = low_m * (top_m / low_m).powf(eased(climbed));
        let t = f64::from(second);
        Keyframe { t, height: floor_m + above_m, pitch: CLIMB_PITCH_DEG, ..start }
    });
    Flight::new(ground.crs.clone(), FPS, keyframes.collect())
}

/// From place to place, each held for a while; between two places there is nothing.
pub(super) fn teleport(ground: &FlightGround) -> Result<Flight, FlightError> {
    let keyframes = (0..PLACES).flat_map(|number| {
        let place = far_place(ground, number);
        let height = ground.finest_m(place) + 2.0 * ground.low_clearance_m();
        let there = Keyframe {
            t: f64::from(number) * HOLD_S,
            x: place.x,
            y: place.y,
            height,
            heading: heading_deg(ground.extent.centre() - place),
            pitch: TELEPORT_PITCH_DEG,
            fov: FOV_DEG,
        };
        [there, Keyframe { t: there.t + HOLD_S - 0.5 * Flight::CUT_S, ..there }]
    });
    Flight::new(ground.crs.clone(), FPS, keyframes.collect())
}

/// Low over the ground south of the summit, looking at it.
fn viewpoint(ground: &FlightGround) -> Keyframe {
    let summit = ground.summit();
    let place = ground.round(summit, 0.0);
    let target = DVec3 { z: ground.finest_m(summit.truncate()), ..summit };
    let eye = place.extend(ground.finest_m(place) + ground.low_clearance_m());
    looking_at(0.0, eye, target)
}

/// Places spread evenly over the inner part of the extent, each far from the one before: multiples of
/// the two powers of the plastic number, whose fractions fill a square (M. Roberts, "The unreasonable
/// effectiveness of quasirandom sequences", 2018).
fn far_place(ground: &FlightGround, number: u32) -> DVec2 {
    const STEP: DVec2 = dvec2(0.754_877_666_246_692_7, 0.569_840_290_998_053_3);
    let place = (DVec2::splat(0.5) + f64::from(number) * STEP).fract();
    ground.extent.min + ground.extent.size_m() * (0.15 + 0.7 * place)
}
