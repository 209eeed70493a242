//! FLIP against the program of its authors, on pictures made to be awkward and on real ones.

#![allow(clippy::print_stdout, reason = "measured values are to be seen")]

use std::path::PathBuf;

use nv_flip::{FlipImageRgb8, flip};
use terrain_core::measure::error::{DEFAULT_PIXELS_PER_DEGREE, flip_errors};

/// Both work in floats of 32 bits, but add them up in another order; powers below 1 spread the
/// rounding of errors near 0.
const TOLERANCE: f32 = 2.0e-4;
/// Over a whole picture such differences cancel.
const TOLERANCE_OF_MEAN: f32 = 1.0e-5;

type Pixels = Vec<[u8; 4]>;

fn rgb(pixels: &[[u8; 4]], [width, height]: [u32; 2]) -> FlipImageRgb8 {
    let bytes = pixels.iter().flat_map(|pixel| &pixel[..3]).copied().collect::<Vec<_>>();
    FlipImageRgb8::with_data(width, height, &bytes)
}

fn assert_same_as_published(name: &str, reference: &Pixels, test: &Pixels, size_px: [u32; 2]) {
    for pixels_per_degree in [DEFAULT_PIXELS_PER_DEGREE, 20.0] {
        let published = flip(rgb(reference, size_px), rgb(test, size_px), pixels_per_degree);
        let published = published.to_vec();
        let found = flip_errors(reference, test, size_px, pixels_per_degree).unwrap_or_default();
        assert_eq!(found.len(), published.len());
        let differences = || found.iter().zip(&published).map(|(a, b)| (a - b).abs());
        let worst = differences().fold(0.0, f32::max);
        let mean = |errors: &[f32]| errors.iter().sum::<f32>() / errors.len() as f32;
        let (mean, published_mean) = (mean(&found), mean(&published));
        println!("{name} at {pixels_per_degree}: {worst:e} at most, mean {mean}");
        assert!(worst < TOLERANCE, "{name} at {pixels_per_degree}: a pixel is {worst} off");
        let off = (mean - published_mean).abs();
        assert!(off < TOLERANCE_OF_MEAN, "{name}: mean {mean}, published {published_mean}");
    }
}

/// The same numbers on every run (a multiplicative congruential generator of 64 bits).
fn noise(seed: u64, count: usize) -> Pixels {
    let mut state = seed | 1;
    let mut byte = || {
        state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
        (state >> 56) as u8
    };
    (0..count).map(|_| [byte(), byte(), byte(), 255]).collect()
}

#[test]
fn noise_of_any_size_has_the_published_errors() {
    for (seed, size_px) in [(1, [64, 48]), (2, [33, 7]), (3, [1, 40]), (4, [5, 1]), (5, [1, 1])] {
        let count = (size_px[0] * size_px[1]) as usize;
        let name = format!("noise of {size_px:?}");
        assert_same_as_published(&name, &noise(seed, count), &noise(seed + 100, count), size_px);
    }
}

#[test]
fn edges_points_and_every_kind_of_colour_have_the_published_errors() {
    let size_px = [80, 60];
    let picture = |colour: fn(u32, u32) -> [u8; 4]| -> Pixels {
        (0..80 * 60).map(|index| colour(index % 80, index / 80)).collect()
    };
    let ramps = picture(|x, y| [(3 * x) as u8, (4 * y) as u8, (255 - 3 * x) as u8, 255]);
    let edge = picture(|x, _| if x < 37 { [20, 30, 90, 255] } else { [240, 230, 120, 255] });
    let moved = picture(|x, _| if x < 38 { [20, 30, 90, 255] } else { [240, 230, 120, 255] });
    let points = picture(|x, y| if x % 13 == 4 && y % 11 == 5 { [255; 4] } else { [0, 0, 0, 255] });
    let black = picture(|_, _| [0, 0, 0, 255]);
    let pure = picture(|x, y| {
        let on = |bit: u32| if (x / 10 + y / 10) & bit == 0 { 0 } else { 255 };
        [on(1), on(2), on(4), 255]
    });
    assert_same_as_published("an edge a pixel off", &edge, &moved, size_px);
    assert_same_as_published("points lost", &points, &black, size_px);
    assert_same_as_published("ramps against pure colours", &ramps, &pure, size_px);
    assert_same_as_published("pure colours against black", &pure, &black, size_px);
}

#[test]
fn photographs_have_the_published_errors() -> anyhow::Result<()> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../docs/himalaya.jpg");
    let photograph = image::open(&path)?;
    let (width, height) = (320, 180);
    let scaled = photograph.thumbnail_exact(width, height).to_rgba8();
    // What a compressor does to a picture, and what a level of detail does to imagery.
    let coarse = photograph.thumbnail_exact(width / 3, height / 3);
    let coarse =
        coarse.resize_exact(width, height, image::imageops::FilterType::Triangle).to_rgba8();
    let pixels = |image: &image::RgbaImage| image.pixels().map(|pixel| pixel.0).collect::<Pixels>();
    let posterised = pixels(&scaled).iter().map(|p| p.map(|value| value & 0xe0)).collect();
    let (reference, coarse) = (pixels(&scaled), pixels(&coarse));
    assert_same_as_published("a coarser photograph", &reference, &coarse, [width, height]);
    assert_same_as_published("a posterised photograph", &reference, &posterised, [width, height]);
    Ok(())
}
