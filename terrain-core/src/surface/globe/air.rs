use glam::{DMat3, DVec3, dvec3};

use crate::frame_setup::{HAZE_COLOUR, ZENITH_COLOUR};
use crate::geodesy::{Geodetic, Wgs84};

/// The air round the globe as an eye looks through it: one layer whose density falls with height by a constant
/// factor (Beer's law along straight rays; light is not scattered twice). The twin in f64 of
/// `common/globe_air.wgsl`.
///
/// The sky has the colours of that over a plane on the ground, overhead and at the horizon, and from there goes to
/// black with the air that is left: so it is blue below and black above, and from far away the air is a thin rim.
/// Before the ground it is clearer than it is before space, so that the ground keeps its colours.
#[derive(Clone, Copy, Debug)]
pub struct GlobeAir {
    /// Metres in the eye's axes to units in which the ellipsoid is a ball of radius 1.
    pub unit_from_relative: DMat3,
    /// The eye there.
    pub unit_eye: DVec3,
    /// Scale heights to a unit.
    pub air_per_unit: f64,
    /// Light that a metre of the densest air takes and gives before space: red, green, blue.
    pub sky_per_m: DVec3,
    /// The same before the ground.
    pub haze_per_m: DVec3,
}

impl GlobeAir {
    /// Scale heights above the ellipsoid where the air ends.
    pub const TOP: f64 = 10.0;
    /// Height in metres over which the air thins out to 1/e.
    const SCALE_HEIGHT_M: f64 = 8_000.0;
    /// Metres of the densest air that take 1 - 1/e of the ground's light, all colours together.
    const HAZE_DISTANCE_M: f64 = 140_000.0;
    /// Parts that a way is taken in.
    const PARTS: u32 = 256;

    /// As seen from a place; heights are multiplied by the exaggeration, and so is the air's.
    pub fn new(eye: &Geodetic, exaggeration: f64) -> Self {
        let (a, b) = (Wgs84::EQUATOR_RADIUS_M, Wgs84::POLAR_RADIUS_M);
        let unit_from_ecef = DMat3::from_diagonal(dvec3(a, a, b).recip());
        let scale_height_m = Self::SCALE_HEIGHT_M * exaggeration;
        // What a zenith of full air takes so that its light, as a part of the haze's, is the zenith's.
        let zenith =
            (DVec3::ONE - ZENITH_COLOUR.as_dvec3() / HAZE_COLOUR.as_dvec3()).map(|rest| -rest.ln());
        let mean = zenith.element_sum() / 3.0;
        Self {
            unit_from_relative: unit_from_ecef * eye.ecef_from_local(),
            unit_eye: unit_from_ecef * Wgs84::ecef_from_geodetic(eye),
            air_per_unit: a / scale_height_m,
            sky_per_m: zenith / scale_height_m,
            // Half way between the sky's colours and grey.
            haze_per_m: 0.5 * (zenith / mean + 1.0) / (Self::HAZE_DISTANCE_M * exaggeration),
        }
    }

    /// Metres of full air that are as much air as lies before a distance in a unit direction.
    pub fn air_m(&self, direction: DVec3, distance_m: f64) -> f64 {
        let along = self.unit_from_relative * direction;
        let speed = along.length();
        let nearest = -self.unit_eye.dot(along) / (speed * speed);
        let low = self.unit_eye + nearest * along;
        let top = 1.0 + Self::TOP / self.air_per_unit;
        let half = (top * top - low.length_squared()).max(0.0).sqrt();
        let first = (-nearest * speed).max(-half);
        let last = ((distance_m - nearest) * speed).min(half);
        if last <= first {
            return 0.0;
        }
        let part = (last - first) / f64::from(Self::PARTS);
        let density = |index: u32| {
            let place = first + (f64::from(index) + 0.5) * part;
            let above = (low.length_squared() + place * place).sqrt() - 1.0;
            (-above.max(0.0) * self.air_per_unit).exp()
        };
        (0..Self::PARTS).map(density).sum::<f64>() * part / speed
    }

    /// Parts of the light of ground at metres from the eye that reach it.
    pub fn clear(&self, relative_m: DVec3) -> DVec3 {
        let distance_m = relative_m.length();
        (-self.haze_per_m * self.air_m(relative_m / distance_m.max(1.0e-3), distance_m)).exp()
    }

    /// Light of the sky in a unit direction that meets no ground.
    pub fn sky(&self, direction: DVec3) -> DVec3 {
        let taken = (-self.sky_per_m * self.air_m(direction, 1.0e9)).exp();
        HAZE_COLOUR.as_dvec3() * (DVec3::ONE - taken)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(height_m: f64) -> GlobeAir {
        GlobeAir::new(&Geodetic { longitude_rad: 0.3, latitude_rad: 0.8, height_m }, 1.0)
    }

    #[test]
    fn straight_up_there_is_one_scale_height_of_air_and_less_from_above() {
        for (height_m, part) in [(0.0, 1.0), (8_000.0, (-1.0_f64).exp()), (2.0e5, 0.0)] {
            let air_m = at(height_m).air_m(DVec3::Z, 1.0e9);
            assert!((air_m / 8_000.0 - part).abs() < 0.01, "{height_m}: {air_m}");
        }
        let sky = at(0.0).sky(DVec3::Z);
        assert!((sky - ZENITH_COLOUR.as_dvec3()).length() < 0.01, "{sky}");
    }

    #[test]
    fn the_horizon_is_white_on_the_ground_and_space_is_black() {
        let horizon = at(2.0).sky(DVec3::X);
        assert!((horizon - HAZE_COLOUR.as_dvec3()).length() < 0.01, "{horizon}");
        assert_eq!(at(1.0e7).sky(DVec3::Z), DVec3::ZERO);
        assert_eq!(at(1.0e7).sky(DVec3::X), DVec3::ZERO);
        // Along the ground a tangent ray meets about sqrt(2 pi R h) of air.
        let expected_m = 0.5 * (std::f64::consts::TAU * 6.37e6 * 8_000.0).sqrt();
        let air_m = at(0.0).air_m(DVec3::X, 1.0e9);
        assert!((air_m / expected_m - 1.0).abs() < 0.03, "{air_m} {expected_m}");
    }
}
