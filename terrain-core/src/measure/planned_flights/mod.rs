//! Flights made for a dataset instead of recorded over it: each asks something else of a renderer.
//!
//! Speeds and heights go by the dataset's size and its finest samples, so that a flight means the same
//! over a valley and over a continent. All of them are the same on every run, and stay above the ground.

mod forward;
mod globe;
mod ground;
mod height_profile;
mod standing;
mod tour;
mod valley;

use glam::{DVec2, DVec3, dvec2};
use serde::{Deserialize, Serialize};

use crate::by_name::by_name;

pub use self::ground::FlightGround;
use super::{Flight, FlightError, Keyframe};

/// Frames a second and vertical field of view of the flights made here.
const FPS: f64 = 60.0;
const FOV_DEG: f64 = 50.0;

/// A flight that can be made for any dataset.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PlannedFlight {
    /// From a view of the whole down to the highest ground, round it and out again: to show a dataset.
    Tour,
    /// Straight ahead close above the ground: a steady flow of fine tiles.
    ForwardLow,
    /// Straight across the dataset, high above it: a steady flow of coarse tiles.
    ForwardHigh,
    /// Once round on the spot: everything in view changes, the ground around the eye does not.
    Spin,
    /// Once round the highest ground, looking at it.
    Orbit,
    /// Straight up from the ground until the whole dataset is in view, and down again: every level.
    ClimbAndDescend,
    /// Along the floor of a valley: what ridges hide need not be there.
    Valley,
    /// From one place to another far from it, and held there: everything is new at once.
    Teleport,
    /// Standing still: nothing may move.
    Hover,
}

/// There is no flight of this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no flight {0:?}; there are {names}", names = PlannedFlight::names())]
pub struct UnknownFlight(pub String);

impl PlannedFlight {
    /// Every flight.
    pub const ALL: [Self; 9] = [
        Self::Tour,
        Self::ForwardLow,
        Self::ForwardHigh,
        Self::Spin,
        Self::Orbit,
        Self::ClimbAndDescend,
        Self::Valley,
        Self::Teleport,
        Self::Hover,
    ];

    /// Those that each put one question to a renderer: all but the tour, which is for showing.
    pub fn measuring() -> impl Iterator<Item = Self> {
        Self::ALL.into_iter().filter(|flight| *flight != Self::Tour)
    }

    /// The name on the command line and in reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Tour => "tour",
            Self::ForwardLow => "forward-low",
            Self::ForwardHigh => "forward-high",
            Self::Spin => "spin",
            Self::Orbit => "orbit",
            Self::ClimbAndDescend => "climb-and-descend",
            Self::Valley => "valley",
            Self::Teleport => "teleport",
            Self::Hover => "hover",
        }
    }

    /// All names, with commas between them.
    pub fn names() -> String {
        Self::ALL.map(Self::name).join(", ")
    }

    /// The flight over this ground.
    ///
    /// # Errors
    /// [`FlightError::NoArea`] where the ground's extent has no area or is not finite.
    pub fn over(self, ground: &FlightGround) -> Result<Flight, FlightError> {
        if !ground.has_area() {
            return Err(FlightError::NoArea);
        }
        match self {
            Self::Tour => tour::tour(ground),
            Self::ForwardLow => forward::low(ground),
            Self::ForwardHigh => forward::high(ground),
            Self::Spin => standing::spin(ground),
            Self::Orbit => forward::orbit(ground),
            Self::ClimbAndDescend => standing::climb_and_descend(ground),
            Self::Valley => valley::along(ground),
            Self::Teleport => standing::teleport(ground),
            Self::Hover => standing::hover(ground),
        }
    }
}

by_name!(PlannedFlight, UnknownFlight);

/// South of a point, as an angle counter-clockwise from east.
const SOUTH_RAD: f64 = -0.5 * std::f64::consts::PI;

fn on_circle(centre: DVec2, radius_m: f64, angle_rad: f64) -> DVec2 {
    centre + radius_m * dvec2(angle_rad.cos(), angle_rad.sin())
}

/// Degrees clockwise from north of a way over the ground.
fn heading_deg(way: DVec2) -> f64 {
    way.x.atan2(way.y).to_degrees()
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
        heading: heading_deg(way.truncate()),
        pitch: way.z.atan2(way.truncate().length()).to_degrees(),
        fov: FOV_DEG,
    }
}

#[cfg(test)]
mod tests;
