//! FLIP: how different two pictures look when one flips between them.
//!
//! After Pontus Andersson, Jim Nilsson, Tomas Akenine-Möller, Magnus Oskarsson, Kalle Åström and Mark
//! D. Fairchild, "FLIP: A Difference Evaluator for Alternating Images" (2020), for pictures of low
//! dynamic range. In the paper's order: both pictures to an opponent colour space, a filter with the
//! eye's contrast sensitivity, the distance of colours (4.1), the difference of edges and points
//! (4.2), and both as one number from 0 to 1 (4.3).

mod colour_difference;
mod colour_space;
mod feature_difference;
mod separable;

use glam::Vec3;
use rayon::prelude::*;

use self::colour_space::opponent_from_srgb;
use super::SizeMismatch;

/// Pixels in a degree of the visual field: a monitor 0.7 m wide with 3840 pixels, seen from 0.7 m.
pub const DEFAULT_PIXELS_PER_DEGREE: f32 = 67.020_64;

/// The FLIP error of each pixel, from 0 (looks the same) to 1, row by row from the top left. Alpha is
/// passed over. Beyond its border a picture continues as its outermost pixels.
///
/// # Errors
/// [`SizeMismatch`] where a picture has not the pixels of its size.
pub fn flip_errors(
    reference: &[[u8; 4]],
    test: &[[u8; 4]],
    size_px: [u32; 2],
    pixels_per_degree: f32,
) -> Result<Vec<f32>, SizeMismatch> {
    SizeMismatch::check(size_px, reference.len())?;
    SizeMismatch::check(size_px, test.len())?;
    let size = size_px.map(|side| side as usize);
    let pictures = [reference, test].map(opponent_colours);
    let colours = colour_difference::difference(&pictures, size, pixels_per_degree);
    let features = feature_difference::difference(&pictures, size, pixels_per_degree);
    let both = colours.into_par_iter().zip(features);
    Ok(both.map(|(colour, feature)| colour.powf(1.0 - feature)).collect())
}

/// The pixels as luminance Y, red-green Cx and blue-yellow Cz.
fn opponent_colours(srgb: &[[u8; 4]]) -> Vec<Vec3> {
    srgb.par_iter().map(|&[red, green, blue, _]| opponent_from_srgb([red, green, blue])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flip(reference: &[[u8; 4]], test: &[[u8; 4]], size_px: [u32; 2]) -> Vec<f32> {
        flip_errors(reference, test, size_px, DEFAULT_PIXELS_PER_DEGREE).unwrap()
    }

    #[test]
    fn equal_pictures_have_no_error_and_black_on_white_all_there_is() {
        let black = vec![[0, 0, 0, 255]; 24 * 16];
        let white = vec![[255; 4]; 24 * 16];
        assert!(flip(&black, &black, [24, 16]).iter().all(|&error| error == 0.0));
        // The paper's normalisation: green against blue is as far as colours go, black against white
        // is nearly so, and flat pictures have no features.
        assert!(flip(&black, &white, [24, 16]).iter().all(|&error| error > 0.9 && error <= 1.0));
        let (green, blue) = ([0, 255, 0, 255], [0, 0, 255, 255]);
        let worst = flip(&[green; 9], &[blue; 9], [3, 3]);
        assert!(worst.iter().all(|error| (error - 1.0).abs() < 1.0e-3), "{worst:?}");
    }

    #[test]
    fn an_error_grows_with_the_difference_and_is_seen_from_both_sides_alike() {
        let grey = |value: u8| vec![[value, value, value, 255]; 64];
        let errors = [130, 140, 180].map(|value| flip(&grey(128), &grey(value), [8, 8])[27]);
        assert!(errors[0] < errors[1] && errors[1] < errors[2], "{errors:?}");
        assert_eq!(flip(&grey(180), &grey(128), [8, 8])[27], errors[2]);
    }

    #[test]
    fn an_edge_weighs_more_than_the_same_colours_without_one() {
        let size_px = [64, 64];
        let edge = (0..64 * 64)
            .map(|i| if i % 64 < 32 { [90, 90, 90, 255] } else { [110, 110, 110, 255] });
        let flat = vec![[100, 100, 100, 255]; 64 * 64];
        let errors = flip(&flat, &edge.collect::<Vec<_>>(), size_px);
        let (at_edge, far) = (errors[32 * 64 + 30], errors[32 * 64 + 4]);
        assert!(at_edge > 1.2 * far, "{at_edge} at the edge, {far} far from it");
    }

    #[test]
    fn pictures_of_other_sizes_are_refused_and_none_has_no_pixels() {
        let black = [[0; 4]; 6];
        assert!(flip_errors(&black, &black, [3, 3], 67.0).is_err());
        assert!(flip_errors(&black, &black[..4], [3, 2], 67.0).is_err());
        assert_eq!(flip_errors(&[], &[], [0, 0], 67.0), Ok(Vec::new()));
    }
}
