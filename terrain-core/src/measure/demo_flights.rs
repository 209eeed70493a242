//! Flights made for a dataset instead of recorded over it.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3, dvec2};

use super::{Flight, FlightError, Keyframe};
use crate::CameraView;
use crate::tiling::Extent;

/// Frames a second and vertical field of view of the flights made here.
const FPS: f64 = 60.0;
const FOV_DEG: f64 = 50.0;

impl Flight {
    /// The view standing still, for the cost of a frame in which nothing changes.
    ///
    /// # Errors
    /// Where the view or the duration (seconds, positive) is out of range.
    pub fn hover(
        crs: impl Into<String>,
        view: &CameraView,
        duration_s: f64,
    ) -> Result<Self, FlightError> {
        Self::forward(crs, view, 0.0, duration_s)
    }

    /// Straight ahead from the view at constant height and speed (metres a second), for the cost of
    /// a steady flow of new ground.
    ///
    /// # Errors
    /// Where the view, the speed or the duration (seconds, positive) is out of range.
    pub fn forward(
        crs: impl Into<String>,
        view: &CameraView,
        speed_m_s: f64,
        duration_s: f64,
    ) -> Result<Self, FlightError> {
        let start = Keyframe::of_view(0.0, view);
        let (sin, cos) = view.heading_deg.to_radians().sin_cos();
        let way_m = speed_m_s * duration_s;
        let end =
            Keyframe { t: duration_s, x: start.x + way_m * sin, y: start.y + way_m * cos, ..start };
        Self::new(crs, FPS, vec![start, end])
    }

    /// Once clockwise round `target` at constant height, always looking at it, beginning south of
    /// it: for the cost of a turning view.
    ///
    /// # Errors
    /// Where a number is not finite or the duration (seconds) not positive.
    pub fn orbit(
        crs: impl Into<String>,
        target: DVec3,
        radius_m: f64,
        height_m: f64,
        duration_s: f64,
    ) -> Result<Self, FlightError> {
        let keyframe = |step: u32| {
            let turn = f64::from(step) / f64::from(ORBIT_STEPS);
            let eye = on_circle(target.truncate(), radius_m, SOUTH_RAD - turn * TAU);
            looking_at(turn * duration_s, eye.extend(height_m), target)
        };
        Self::new(crs, FPS, (0..=ORBIT_STEPS).map(keyframe).collect())
    }

    /// A flight that shows a dataset: from a view of the whole down to its highest ground, low round
    /// that, and out again.
    ///
    /// `ground_height_m` gives the terrain's height as drawn; where it is not finite, 0 is taken.
    ///
    /// # Errors
    /// Where the extent has no area or is not finite.
    pub fn tour(
        crs: impl Into<String>,
        extent: &Extent,
        ground_height_m: &dyn Fn(DVec2) -> f64,
    ) -> Result<Self, FlightError> {
        let side_m = extent.size_m().min_element();
        if !(side_m > 0.0 && extent.min.is_finite() && extent.max.is_finite()) {
            return Err(FlightError::NoArea);
        }
        let ground_m = |point: DVec2| Some(ground_height_m(point)).filter(|h| h.is_finite());
        Self::new(crs, FPS, Tour::plan(extent, &|point| ground_m(point).unwrap_or(0.0)).keyframes())
    }
}

/// Keyframes of a full circle.
const ORBIT_STEPS: u32 = 32;
/// Seconds of a tour's three parts, a keyframe a second.
const APPROACH_S: u32 = 12;
const CIRCLE_S: u32 = 24;
const DEPARTURE_S: u32 = 8;
/// South of a point, as an angle counter-clockwise from east.
const SOUTH_RAD: f64 = -0.25 * TAU;
/// Radius of the low circle, and height of the eye over its ground, in parts of the shorter side.
const CIRCLE_RADIUS: f64 = 0.12;
const LOW_CLEARANCE: f64 = 0.025;
/// Place of the wide view, in parts of the shorter side: south of the centre, and above it.
const WIDE_DISTANCE: f64 = 0.75;
const WIDE_HEIGHT: f64 = 0.45;

/// The places a tour is made of.
struct Tour<'a> {
    ground_m: &'a dyn Fn(DVec2) -> f64,
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
    fn plan(extent: &Extent, ground_m: &'a dyn Fn(DVec2) -> f64) -> Self {
        let side_m = extent.size_m().min_element();
        let on_ground = |point: DVec2| point.extend(ground_m(point));
        let centre = on_ground(extent.centre());
        let summit = highest(inner_grid(extent).map(on_ground)).unwrap_or(centre);
        let radius_m = CIRCLE_RADIUS * side_m;
        let clearance_m = LOW_CLEARANCE * side_m;
        let circle = (0..4 * ORBIT_STEPS).map(|step| {
            let angle = TAU * f64::from(step) / f64::from(4 * ORBIT_STEPS);
            on_ground(on_circle(summit.truncate(), radius_m, angle))
        });
        let floor_m = highest(circle).map_or(summit.z, |point| point.z);
        let wide = centre + DVec3::new(0.0, -WIDE_DISTANCE * side_m, WIDE_HEIGHT * side_m);
        let low_height_m = floor_m + clearance_m;
        Self { ground_m, centre, summit, wide, radius_m, clearance_m, low_height_m }
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
        let ground_m = (self.ground_m)(position);
        let height_m = (floor_m + above_m).max(ground_m + self.clearance_m);
        looking_at(t, position.extend(height_m), self.centre.lerp(self.summit, way))
    }
}

/// A grid over the middle three fifths of the extent, where a circle round any point stays inside.
fn inner_grid(extent: &Extent) -> impl Iterator<Item = DVec2> + use<> {
    const SIDE: u32 = 48;
    let (min, size) = (extent.min, extent.size_m());
    (0..SIDE * SIDE).map(move |index| {
        let step = dvec2(f64::from(index % SIDE), f64::from(index / SIDE)) / f64::from(SIDE - 1);
        min + size * (0.2 + 0.6 * step)
    })
}

fn highest(points: impl Iterator<Item = DVec3>) -> Option<DVec3> {
    points.max_by(|a, b| a.z.total_cmp(&b.z))
}

fn on_circle(centre: DVec2, radius_m: f64, angle_rad: f64) -> DVec2 {
    centre + radius_m * dvec2(angle_rad.cos(), angle_rad.sin())
}

/// From 0 to 1 with no speed at either end.
fn eased(part: f64) -> f64 {
    part * part * (3.0 - 2.0 * part)
}

/// The keyframe of an eye that looks at a point.
fn looking_at(t: f64, eye: DVec3, target: DVec3) -> Keyframe {
    let way = target - eye;
    Keyframe {
        t,
        x: eye.x,
        y: eye.y,
        height: eye.z,
        heading: way.x.atan2(way.y).to_degrees(),
        pitch: way.z.atan2(way.truncate().length()).to_degrees(),
        fov: FOV_DEG,
    }
}
