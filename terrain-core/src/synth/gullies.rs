use glam::{DVec2, Vec2, dvec2, vec2};

use super::noise::{cell_of, cos_sin_turns, derived_seed, hash, mixed, unit_pair};

/// Distance from gully to gully in metres, coarse to fine, each cut into the flanks of the one before.
const WAVELENGTHS_M: [f64; 4] = [430.0, 215.0, 112.0, 66.0];
/// Height of a gully's rib above its bed on a steep slope, as a share of its wavelength.
const RELIEF: [f32; 4] = [0.16, 0.12, 0.075, 0.04];
/// Size of the cells that give stripes their phase, in wavelengths.
const CELL_WAVELENGTHS: f64 = 1.6;

/// What gullies make of a slope.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gullies {
    /// Metres to add to the height.
    pub height_m: f32,
    /// -1 in a gully, 1 on a rib, 0 on even ground.
    pub rib: f32,
}

impl Gullies {
    /// Gullies and ribs that run down a slope with this gradient of the height (metres a metre, along
    /// x and y), scaled by `strength`, 0 for none.
    ///
    /// Erosion by point evaluation, as in R. Skovbo Johansen, "Fast and Gorgeous Erosion Filter",
    /// 2026, after C. John, "Eroded Terrain Noise", 2018: stripes of noise along the direction of
    /// descent, octave by octave, each following the gradient with all coarser ones in it, so that
    /// gullies branch.
    pub fn on_slope(place_m: DVec2, gradient: Vec2, strength: f32, seed: u32) -> Self {
        let mut gullies = Self::default();
        if strength <= 0.0 {
            return gullies;
        }
        let mut gradient = gradient;
        for (octave, (wavelength_m, relief)) in WAVELENGTHS_M.into_iter().zip(RELIEF).enumerate() {
            let slope = gradient.length();
            if slope < 1e-4 {
                break;
            }
            let across = vec2(-gradient.y, gradient.x) / slope;
            let seed = derived_seed(seed, octave as u32);
            let wave = stripes(place_m / wavelength_m, across, seed);
            // Gentle ground has few gullies, and shallow ones.
            let steepness = slope * slope / (slope * slope + 0.16);
            let height_m = 0.5 * strength * relief * steepness * wavelength_m as f32;
            // Ribs are sharper than the beds between them.
            gullies.height_m += height_m * (wave.x - 0.25 * wave.y * wave.y);
            gullies.rib = mixed(gullies.rib, wave.x * steepness, 0.45);
            let steepest = height_m * std::f32::consts::TAU / wavelength_m as f32;
            gradient -= steepest * wave.y * across;
        }
        gullies
    }
}

/// Cosine and sine of the phase of stripes a unit apart that lie across the direction `across`.
///
/// Every cell around the place has stripes through a pivot of its own; where their phases disagree,
/// stripes join.
fn stripes(place: DVec2, across: Vec2, seed: u32) -> Vec2 {
    let (x, y, at) = cell_of(place / CELL_WAVELENGTHS - dvec2(0.5, 0.5));
    let mut sum = Vec2::ZERO;
    for (dx, dy) in (-1..=2).flat_map(|dy| (-1..=2).map(move |dx| (dx, dy))) {
        let pivot = vec2(dx as f32, dy as f32) + 0.8 * unit_pair(hash(x + dx, y + dy, seed)) - 0.4;
        let from_pivot = at - pivot;
        let nearness = (1.0 - from_pivot.length_squared() * (1.0 / 2.25)).max(0.0);
        if nearness > 0.0 {
            let turns = CELL_WAVELENGTHS as f32 * from_pivot.dot(across);
            sum += nearness * nearness * nearness * cos_sin_turns(turns);
        }
    }
    sum / sum.length().max(0.25)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SLOPE: Vec2 = vec2(0.48, 0.36);

    fn gullies(place_m: DVec2) -> Gullies {
        Gullies::on_slope(place_m, SLOPE, 1.0, 5)
    }

    #[test]
    fn gullies_run_down_the_slope() {
        let (down, across) = (dvec2(0.8, 0.6), dvec2(-0.6, 0.8));
        let change = |step: DVec2| -> f32 {
            let places = (0..4_000).map(|i| dvec2(f64::from(i % 63), f64::from(i / 63)) * 87.0);
            places.map(|at| (gullies(at + 20.0 * step).height_m - gullies(at).height_m).abs()).sum()
        };
        let (along, athwart) = (change(down), change(across));
        assert!(athwart > 1.5 * along, "{athwart} m across, {along} m along");
    }

    #[test]
    fn gullies_are_bounded_and_even_out() {
        let places = (0..10_000).map(|i| dvec2(f64::from(i % 100), f64::from(i / 100)) * 61.7);
        let all: Vec<Gullies> = places.map(gullies).collect();
        let most_m: f32 =
            WAVELENGTHS_M.iter().zip(RELIEF).map(|(length, relief)| *length as f32 * relief).sum();
        assert!(all.iter().all(|one| one.height_m.abs() < most_m && one.rib.abs() <= 1.0));
        let mean_m = all.iter().map(|one| one.height_m).sum::<f32>() / all.len() as f32;
        assert!(mean_m.abs() < 0.15 * most_m, "{mean_m}");
    }

    #[test]
    fn even_ground_has_none() {
        assert_eq!(Gullies::on_slope(dvec2(5.0, 7.0), SLOPE, 0.0, 5), Gullies::default());
        let flat = Gullies::on_slope(dvec2(5.0, 7.0), Vec2::ZERO, 1.0, 5);
        assert_eq!(flat, Gullies::default());
    }
}
