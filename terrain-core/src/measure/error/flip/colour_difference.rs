use std::f32::consts::PI;

use glam::{Vec3, vec3};
use rayon::prelude::*;

use super::colour_space::{hunt_lab_from_linear, hyab, screen_colour_from_opponent};
use super::separable::{Four, along_columns, along_rows};

/// A Gaussian of the contrast sensitivity function: `a sqrt(pi / b) exp(-pi² x² / b)`, x in degrees.
struct Gaussian {
    a: f32,
    b: f32,
}

/// Table 1 of the paper. Blue-yellow has two.
const LUMINANCE: Gaussian = Gaussian { a: 1.0, b: 0.0047 };
const RED_GREEN: Gaussian = Gaussian { a: 1.0, b: 0.0053 };
const BLUE_YELLOW: [Gaussian; 2] = [Gaussian { a: 34.1, b: 0.04 }, Gaussian { a: 13.5, b: 0.025 }];
/// The greatest b of all.
const WIDEST_B: f32 = 0.04;

/// The power that makes distances of large differences comparable to small ones (4.1, q_c).
const COLOUR_POWER: f32 = 0.7;
/// Distances below this part of the greatest (p_c) fill the errors up to `SMALL_ERRORS` (p_t).
const SMALL_DISTANCES: f32 = 0.4;
const SMALL_ERRORS: f32 = 0.95;

/// The difference of colour of each pixel, 0 to 1, as an eye sees it that cannot resolve single
/// pixels.
pub(super) fn difference(
    [reference, test]: &[Vec<Vec3>; 2],
    size: [usize; 2],
    pixels_per_degree: f32,
) -> Vec<f32> {
    let weights = contrast_weights(pixels_per_degree);
    let reference = filtered_lab(reference, size, &weights);
    let test = filtered_lab(test, size, &weights);
    let most = greatest_distance();
    let pairs = reference.into_par_iter().zip(test);
    pairs.map(|(a, b)| error_from_distance(hyab(a, b).powf(COLOUR_POWER), most)).collect()
}

fn filtered_lab(opponent: &[Vec3], size: [usize; 2], weights: &[Four]) -> Vec<Vec3> {
    // The two Gaussians of blue-yellow are separable each by itself, not their sum.
    let channels = opponent.par_iter().map(|c| [c.x, c.y, c.z, c.z]).collect::<Vec<_>>();
    let filtered = along_columns(&along_rows(&channels, size, weights), size, weights);
    let lab = |[y, cx, cz_wide, cz_narrow]: Four| {
        hunt_lab_from_linear(screen_colour_from_opponent(vec3(y, cx, cz_wide + cz_narrow)))
    };
    filtered.into_par_iter().map(lab).collect()
}

/// Weights along a line, so that those over the square sum to 1 in each channel (the last two
/// together).
fn contrast_weights(pixels_per_degree: f32) -> Vec<Four> {
    let radius = (3.0 * (WIDEST_B / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as i32;
    let [wide, narrow] = &BLUE_YELLOW;
    let weights = (-radius..=radius).map(|step| {
        let x = step as f32 / pixels_per_degree;
        let fall = |gaussian: &Gaussian| (-PI * PI * x * x / gaussian.b).exp();
        // Over the square, a Gaussian's factor must count once, not once a direction.
        let root = |gaussian: &Gaussian| (gaussian.a * (PI / gaussian.b).sqrt()).sqrt();
        [fall(&LUMINANCE), fall(&RED_GREEN), root(wide) * fall(wide), root(narrow) * fall(narrow)]
    });
    let weights = weights.collect::<Vec<_>>();
    let sum = |channel: usize| weights.iter().map(|weight| weight[channel]).sum::<f32>();
    let both = sum(2).hypot(sum(3));
    let sums = [sum(0), sum(1), both, both];
    weights.iter().map(|weight| std::array::from_fn(|c| weight[c] / sums[c])).collect()
}

/// The distance of the two colours of a screen that lie farthest apart: green and blue.
fn greatest_distance() -> f32 {
    let [green, blue] = [Vec3::Y, Vec3::Z].map(hunt_lab_from_linear);
    hyab(green, blue).powf(COLOUR_POWER)
}

/// Spreads small distances over most of the range of errors.
fn error_from_distance(distance: f32, most: f32) -> f32 {
    let small = SMALL_DISTANCES * most;
    if distance < small {
        return distance * SMALL_ERRORS / small;
    }
    SMALL_ERRORS + (distance - small) / (most - small) * (1.0 - SMALL_ERRORS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_over_the_square_sum_to_one_and_are_the_papers_gaussians() {
        let ppd = 67.0;
        let weights = contrast_weights(ppd);
        assert_eq!(weights.len(), 21, "radius 10 at 67 pixels a degree");
        let over_square =
            |channel: usize| weights.iter().map(|weight| weight[channel]).sum::<f32>().powi(2);
        assert!((over_square(0) - 1.0).abs() < 1.0e-5);
        assert!((over_square(1) - 1.0).abs() < 1.0e-5);
        assert!((over_square(2) + over_square(3) - 1.0).abs() < 1.0e-5);
        // Blue-yellow at an offset against the centre, straight from the formula.
        let direct = |x: f32, y: f32| {
            let square = (x * x + y * y) / (ppd * ppd);
            BLUE_YELLOW
                .iter()
                .map(|g| g.a * (PI / g.b).sqrt() * (-PI * PI * square / g.b).exp())
                .sum::<f32>()
        };
        let at = |x: usize, y: usize| {
            weights[10 + x][2] * weights[10 + y][2] + weights[10 + x][3] * weights[10 + y][3]
        };
        let (expected, found) = (direct(4.0, 7.0) / direct(0.0, 0.0), at(4, 7) / at(0, 0));
        assert!((expected - found).abs() < 1.0e-6, "{expected} {found}");
    }

    #[test]
    fn errors_run_from_nothing_to_one_without_a_jump() {
        let most = greatest_distance();
        assert_eq!(error_from_distance(0.0, most), 0.0);
        assert!((error_from_distance(most, most) - 1.0).abs() < 1.0e-6);
        let knee = SMALL_DISTANCES * most;
        assert!((error_from_distance(knee * 0.999_99, most) - SMALL_ERRORS).abs() < 1.0e-4);
    }
}
