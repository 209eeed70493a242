use std::f64::consts::TAU;

use glam::{DVec2, DVec3, dvec2};

use super::{SOUTH_RAD, on_circle};
use crate::tiling::Extent;

/// The ground that flights are made over.
pub struct FlightGround<'a> {
    /// The CRS as flight files name it, such as `EPSG:32632`.
    pub crs: String,
    /// Where there is ground, metres of the CRS.
    pub extent: Extent,
    /// Metres between the finest samples of heights.
    pub sample_m: f64,
    /// Height in metres at a point as it is drawn (exaggeration included), from samples about so many
    /// metres apart; from the finest where that is 0. `None` where there is no ground.
    pub height_m: &'a dyn Fn(DVec2, f64) -> Option<f64>,
}

/// Height of a low eye over its ground: in parts of the shorter side, and at the most in samples.
const LOW_CLEARANCE: f64 = 0.02;
const LOW_CLEARANCE_SAMPLES: f64 = 16.0;
/// Radius of the circle round the summit, in parts of the shorter side and at the most in clearances.
const CIRCLE_RADIUS: f64 = 0.12;
const CIRCLE_CLEARANCES: f64 = 12.0;
/// Points a side of the grid that heights are surveyed on.
const SURVEY_SIDE: u32 = 48;

impl FlightGround<'_> {
    pub(super) fn has_area(&self) -> bool {
        let Extent { min, max } = self.extent;
        self.side_m() > 0.0 && min.is_finite() && max.is_finite()
    }

    /// The shorter side.
    pub(super) fn side_m(&self) -> f64 {
        self.extent.size_m().min_element()
    }

    /// How high above the ground a low flight goes: where the finest samples fill pixels.
    pub(super) fn low_clearance_m(&self) -> f64 {
        (LOW_CLEARANCE * self.side_m()).min(LOW_CLEARANCE_SAMPLES * self.sample_m)
    }

    /// Radius of the circle round the highest ground.
    pub(super) fn circle_radius_m(&self) -> f64 {
        (CIRCLE_RADIUS * self.side_m()).min(CIRCLE_CLEARANCES * self.low_clearance_m())
    }

    /// The height at a point by the finest samples; 0 where there is no ground.
    pub(super) fn finest_m(&self, point: DVec2) -> f64 {
        self.about_m(point, 0.0)
    }

    /// The height at a point by samples about so far apart; 0 where there is no ground.
    pub(super) fn about_m(&self, point: DVec2, spacing_m: f64) -> f64 {
        (self.height_m)(point, spacing_m).filter(|height| height.is_finite()).unwrap_or(0.0)
    }

    /// The highest point of a survey of the middle three fifths, where a circle round any point stays
    /// inside.
    pub(super) fn summit(&self) -> DVec3 {
        let (min, size) = (self.extent.min, self.extent.size_m());
        let spacing_m = 0.6 * self.side_m() / f64::from(SURVEY_SIDE);
        let surveyed = (0..SURVEY_SIDE * SURVEY_SIDE).map(|index| {
            let place = dvec2(f64::from(index % SURVEY_SIDE), f64::from(index / SURVEY_SIDE));
            let point = min + size * (0.2 + 0.6 * place / f64::from(SURVEY_SIDE - 1));
            point.extend(self.about_m(point, spacing_m))
        });
        let centre = self.extent.centre().extend(0.0);
        surveyed.max_by(|a, b| a.z.total_cmp(&b.z)).unwrap_or(centre)
    }

    /// The place a part (0..=1) of the clockwise way round the summit, from its southern point.
    pub(super) fn round(&self, summit: DVec3, turn: f64) -> DVec2 {
        on_circle(summit.truncate(), self.circle_radius_m(), SOUTH_RAD - turn * TAU)
    }
}
