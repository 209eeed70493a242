use glam::{DVec2, dvec2};

use super::grid::GROUND_SIZE_M;
use super::noise::{derived_seed, fractal_noise, mixed, smooth_step};

/// What shapes the mountains from below: how fast the ground rises against how fast rivers cut, and
/// how steep its slopes can stand.
///
/// The plan is that of the eastern edge of the Tibetan plateau: a plain in the south-east, a high
/// range along its edge, and a high, less deeply cut country behind.
#[derive(Clone, Copy, Debug)]
pub struct Uplift {
    seed: u32,
}

/// At one place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UpliftAt {
    /// Steepness of rivers in balance: uplift over erodibility, in metres. A river that drains an
    /// area A in balance has the slope of this over the root of A.
    pub steepness_m: f32,
    /// Steepest slope that stands, metres a metre.
    pub critical_slope: f32,
}

/// Direction from the mountains to the plain, towards the south-east; y points south.
const TO_THE_PLAIN: DVec2 = dvec2(0.82, 0.572);
/// Where the edge of the mountains crosses the diagonal of the ground, as a share of its size.
const EDGE_SHARE: f64 = 0.76;

impl Uplift {
    pub fn new(seed: u32) -> Self {
        Self { seed }
    }

    /// At a place in metres east and south of the ground's north-west corner.
    pub fn at(&self, place_m: DVec2) -> UpliftAt {
        let noise = |purpose: u32, wavelength_m: f64, octaves: u32| {
            fractal_noise(place_m / wavelength_m, octaves, derived_seed(self.seed, purpose))
        };
        let edge_m = (place_m - EDGE_SHARE * GROUND_SIZE_M).dot(TO_THE_PLAIN);
        let behind_edge_m = 14_000.0 * noise(1, 60_000.0, 4) - edge_m as f32;
        let mountains = smooth_step(-1_500.0, 9_000.0, behind_edge_m);
        let plateau = smooth_step(60_000.0, 170_000.0, behind_edge_m);
        let highlands = mixed(620.0, 440.0, plateau) * (1.0 + 0.7 * noise(2, 45_000.0, 6));
        let plain = 4.0 + 40.0 * noise(3, 22_000.0, 3).max(0.0);
        UpliftAt {
            steepness_m: mixed(plain, highlands.max(120.0), mountains),
            critical_slope: mixed(0.86, 0.55, plateau) * (1.0 + 0.25 * noise(4, 6_000.0, 3)),
        }
    }
}
