use std::f32::consts::FRAC_1_SQRT_2;

use glam::Vec3;
use rayon::prelude::*;

use super::colour_space::grey_from_opponent;
use super::separable::{Four, along_columns, along_rows};

/// Width of the eye's edge detector in degrees (4.2, w).
const EDGE_WIDTH_DEG: f32 = 0.082;
/// The power that lets features count (q_f).
const FEATURE_POWER: f32 = 0.5;

/// How much the edges and points at each pixel differ, 0 to 1.
pub(super) fn difference(
    [reference, test]: &[Vec<Vec3>; 2],
    size: [usize; 2],
    pixels_per_degree: f32,
) -> Vec<f32> {
    let weights = FeatureWeights::new(pixels_per_degree);
    let reference = features(reference, size, &weights);
    let test = features(test, size, &weights);
    let pairs = reference.into_par_iter().zip(test);
    let differ = |(a, b): (Features, Features)| {
        let most = (a.edge - b.edge).abs().max((a.point - b.point).abs());
        (FRAC_1_SQRT_2 * most).powf(FEATURE_POWER)
    };
    pairs.map(differ).collect()
}

/// What is found at a pixel: sizes of the first and of the second derivative of luminance.
struct Features {
    edge: f32,
    point: f32,
}

fn features(opponent: &[Vec3], size: [usize; 2], weights: &FeatureWeights) -> Vec<Features> {
    let grey = opponent.par_iter().map(|&c| [grey_from_opponent(c); 4]).collect::<Vec<_>>();
    // Derivatives along x are Gaussian along y, and the other way round.
    let rows = along_rows(&grey, size, &weights.along_x);
    let derivatives = along_columns(&rows, size, &weights.along_y);
    derivatives
        .into_par_iter()
        .map(|[dx, dy, dxx, dyy]| Features { edge: dx.hypot(dy), point: dxx.hypot(dyy) })
        .collect()
}

/// Weights for the derivatives (x, y, xx, yy).
struct FeatureWeights {
    along_x: Vec<Four>,
    along_y: Vec<Four>,
}

impl FeatureWeights {
    fn new(pixels_per_degree: f32) -> Self {
        let deviation = 0.5 * EDGE_WIDTH_DEG * pixels_per_degree;
        let radius = (3.0 * deviation).ceil() as i32;
        let line = |weight: fn(f32) -> f32| {
            let weights = (-radius..=radius).map(|step| {
                let x = step as f32 / deviation;
                weight(x) * (-0.5 * x * x).exp()
            });
            normalised(&weights.collect::<Vec<_>>())
        };
        let (plain, first, second) = (line(|_| 1.0), line(|x| -x), line(|x| x * x - 1.0));
        let steps = || 0..plain.len();
        Self {
            along_x: steps().map(|i| [first[i], plain[i], second[i], plain[i]]).collect(),
            along_y: steps().map(|i| [plain[i], first[i], plain[i], second[i]]).collect(),
        }
    }
}

/// Positive weights sum to 1, negative ones to -1.
fn normalised(weights: &[f32]) -> Vec<f32> {
    let above = weights.iter().filter(|weight| **weight > 0.0).sum::<f32>();
    let below = -weights.iter().filter(|weight| **weight < 0.0).sum::<f32>();
    let scale = |weight: f32| {
        if weight > 0.0 { weight / above } else { weight / below.max(f32::MIN_POSITIVE) }
    };
    weights.iter().map(|&weight| scale(weight)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flat_grey_has_no_features_and_a_full_edge_has_size_one() {
        let size = [60, 8];
        let column = |step: usize| if step % 60 < 30 { -16.0 } else { 100.0 };
        let edge = (0..480).map(|step| Vec3::new(column(step), 0.0, 0.0)).collect::<Vec<_>>();
        let weights = FeatureWeights::new(67.0);
        let found = features(&edge, size, &weights);
        // Half of the weights, all of one sign, lie on white: between two pixels the edge is whole.
        let strongest = found.iter().map(|feature| feature.edge).fold(0.0, f32::max);
        assert!((0.85..=1.0).contains(&strongest), "{strongest}");
        let flat = &found[4 * 60 + 5];
        assert!(flat.edge < 1.0e-6 && flat.point < 1.0e-6);
    }
}
