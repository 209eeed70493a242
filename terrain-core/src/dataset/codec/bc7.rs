//! BC7 blocks in mode 6 only: one line through colour space with coverage, 16 steps along it.
//!
//! Mode 6 has the finest steps and the finest ends of the format's eight modes and needs no search
//! over partitions, which makes it two orders faster than trying them all; aerial pictures, whose
//! blocks mostly lie along one line, lose little by it. Layout of the bits: Khronos Data Format
//! Specification 1.3, section 18.8 (BPTC).
//!
//! 1. The line is the principal axis of the 16 texels (power iteration on their covariance).
//! 2. The ends are those of the texels' projections, rounded to 7 bits and one shared lowest bit.
//! 3. Every texel takes the nearest of the 16 steps.
//! 4. The ends are fitted anew to the steps taken (least squares); kept if that is nearer.
//!
//! Opaque blocks, most of all imagery, are fitted in three channels; their coverage needs no fit.

use super::lanes::{
    Lanes, largest, mapped, product_sum, rounded, small_integers, smallest, sum, zipped,
};

/// Sum of squared errors of a block that is not worth refining: half a code a channel.
const NO_VISIBLE_ERROR: f32 = 16.0;

/// The step whose weight is next below one half.
const MIDDLE_STEP: f32 = 7.0;

/// One candidate for a block, in N channels: red, green, blue and, where it varies, coverage.
#[derive(Clone, Copy)]
struct Fit<const N: usize> {
    /// Seven upper bits of both ends' channels.
    ends: [[u8; N]; 2],
    /// The lowest bit all channels of an end share.
    low_bits: [u8; 2],
    /// Whole numbers from 0 to 15.
    steps: Lanes,
    error: f32,
}

/// Compresses a square of RGBA8 texels, a multiple of 4 a side, block row by block row.
pub fn compress(rgba: &[u8], size_texels: u32) -> Vec<u8> {
    let size = size_texels as usize;
    let mut blocks = Vec::with_capacity(size * size);
    for block_row in rgba.chunks_exact(4 * 4 * size) {
        for column in (0..4 * size).step_by(16) {
            let mut texels = [0; 16];
            for (row, line) in texels.as_chunks_mut::<4>().0.iter_mut().enumerate() {
                let at = 4 * size * row + column;
                let bytes = block_row[at..at + 16].as_chunks::<4>().0;
                for (texel, &bytes) in line.iter_mut().zip(bytes) {
                    *texel = u32::from_le_bytes(bytes);
                }
            }
            blocks.extend(block(&texels).to_le_bytes());
        }
    }
    blocks
}

/// The block of 16 texels, red in their lowest byte.
fn block(texels: &[u32; 16]) -> u128 {
    const COVERED: u32 = 0xff00_0000;
    let channel = |channel: usize| {
        let mut lanes = [0.0; 16];
        for (lane, texel) in lanes.iter_mut().zip(texels) {
            // Signed, for which there is a vector instruction.
            *lane = (texel >> (8 * channel) & 0xff) as i32 as f32;
        }
        lanes
    };
    let is_opaque = texels.iter().fold(COVERED, |all, texel| all & texel) == COVERED;
    if !is_opaque {
        let fit = best_fit(&[channel(0), channel(1), channel(2), channel(3)]);
        return pack(fit.ends, fit.low_bits, &fit.steps);
    }
    let differences = texels.iter().fold(0, |all, texel| all | (texel ^ texels[0]));
    let fit = match differences == 0 {
        true => fit_of_one_colour(texels[0].to_le_bytes()),
        false => best_fit(&[channel(0), channel(1), channel(2)]),
    };
    let covered = |[r, g, b]: [u8; 3]| [r, g, b, 127];
    pack(fit.ends.map(covered), fit.low_bits, &fit.steps)
}

/// The ends of an opaque colour are odd in every channel, so that an even one lies halfway between
/// two of them. Only 0 has none below it, and becomes 1.
fn fit_of_one_colour([r, g, b, _]: [u8; 4]) -> Fit<3> {
    let colour = [r, g, b];
    let ends = [colour.map(|code| code.saturating_sub(1) >> 1), colour.map(|code| code >> 1)];
    Fit { ends, low_bits: [1, 1], steps: [MIDDLE_STEP; 16], error: 0.0 }
}

fn best_fit<const N: usize>(channels: &[Lanes; N]) -> Fit<N> {
    let mean = channels.each_ref().map(|lanes| sum(lanes) / 16.0);
    let offsets: [Lanes; N] =
        std::array::from_fn(|c| mapped(&channels[c], |value| value - mean[c]));
    let axis = principal_axis(&offsets);
    let along = combined(&offsets, &axis);
    let inverse = 1.0 / dot(&axis, &axis);
    let end = |along: f32| std::array::from_fn(|c| mean[c] + axis[c] * along * inverse);
    let first = fit_to_ends(channels, end(smallest(&along)), end(largest(&along)));
    if first.error <= NO_VISIBLE_ERROR {
        return first;
    }
    match refined_ends(channels, &first.steps) {
        Some([a, b]) => {
            let second = fit_to_ends(channels, a, b);
            if second.error < first.error { second } else { first }
        }
        None => first,
    }
}

/// The direction in which the texels spread most, of any length but 0; any where they do not.
fn principal_axis<const N: usize>(offsets: &[Lanes; N]) -> [f32; N] {
    let mut covariance = [[0.0_f32; N]; N];
    for row in 0..N {
        for column in 0..=row {
            let product = product_sum(&offsets[row], &offsets[column]);
            covariance[row][column] = product;
            covariance[column][row] = product;
        }
    }
    // The longest row is a fair start: it is the covariance with the most varied channel.
    let mut axis = covariance[0];
    for row in &covariance[1..] {
        if dot(row, row) > dot(&axis, &axis) {
            axis = *row;
        }
    }
    // Products of the covariances stay in range where these are at most 1.
    let trace: f32 = (0..N).map(|c| covariance[c][c]).sum();
    if trace < 1e-6 {
        return [0.5; N];
    }
    let scale = 1.0 / trace;
    let covariance = covariance.map(|row| row.map(|part| part * scale));
    axis = axis.map(|part| part * scale);
    for _ in 0..4 {
        axis = covariance.each_ref().map(|row| dot(row, &axis));
    }
    axis
}

/// Rounds the ends and gives each texel its nearest step between them.
fn fit_to_ends<const N: usize>(channels: &[Lanes; N], from: [f32; N], to: [f32; N]) -> Fit<N> {
    let ends = [rounded_end(from), rounded_end(to)];
    let [first, second] = ends.map(|(upper, low_bit)| whole_end(upper, low_bit));
    let line: [f32; N] = std::array::from_fn(|c| second[c] - first[c]);
    let offsets: [Lanes; N] =
        std::array::from_fn(|c| mapped(&channels[c], |value| value - first[c]));
    let length = dot(&line, &line);
    let scale = if length > 0.0 { 15.0 / length } else { 0.0 };
    let along = combined(&offsets, &line.map(|part| part * scale));
    let steps = mapped(&along, |along| rounded(along.clamp(0.0, 15.0)));
    let weights = mapped(&steps, weight);
    let mut error = 0.0;
    for (offsets, part) in offsets.iter().zip(line) {
        let misses = zipped(offsets, &weights, |offset, weight| offset - part * weight);
        error += product_sum(&misses, &misses);
    }
    let [(first, low_first), (second, low_second)] = ends;
    let low_bits = [low_first, low_second];
    Fit { ends: [first, second], low_bits, steps, error }
}

/// How far along the line a step lies: the format's whole 64ths.
fn weight(step: f32) -> f32 {
    rounded(step * (64.0 / 15.0)) / 64.0
}

/// Seven bits a channel and the shared lowest bit that together come nearest to the colour. Opaque
/// blocks keep full coverage, which only a set lowest bit can say.
fn rounded_end<const N: usize>(end: [f32; N]) -> ([u8; N], u8) {
    let rounded = |low_bit: u8| -> [u8; N] {
        end.map(|part| ((part - f32::from(low_bit)) * 0.5 + 0.5).clamp(0.0, 127.0) as u8)
    };
    let is_opaque = N == 3;
    if is_opaque {
        return (rounded(1), 1);
    }
    let miss = |low_bit: u8| {
        let whole = whole_end(rounded(low_bit), low_bit);
        let offset: [f32; N] = std::array::from_fn(|c| whole[c] - end[c]);
        dot(&offset, &offset)
    };
    let low_bit = u8::from(miss(1) <= miss(0));
    (rounded(low_bit), low_bit)
}

fn whole_end<const N: usize>(upper: [u8; N], low_bit: u8) -> [f32; N] {
    upper.map(|part| f32::from(part << 1 | low_bit))
}

/// The ends that fit the texels best at the steps they have; `None` where all have the same.
fn refined_ends<const N: usize>(channels: &[Lanes; N], steps: &Lanes) -> Option<[[f32; N]; 2]> {
    // A texel is (1 - b) of the first end and b of the second.
    let b = mapped(steps, weight);
    let (b_sum, bb) = (sum(&b), product_sum(&b, &b));
    let ab = b_sum - bb;
    let aa = 16.0 - b_sum - ab;
    let determinant = aa * bb - ab * ab;
    if determinant <= 1e-4 {
        return None;
    }
    let ends = channels.each_ref().map(|lanes| {
        let of_b = product_sum(lanes, &b);
        let of_a = sum(lanes) - of_b;
        [(of_a * bb - of_b * ab) / determinant, (of_b * aa - of_a * ab) / determinant]
    });
    Some([ends.map(|[first, _]| first), ends.map(|[_, second]| second)])
}

/// The 128 bits of a block, lowest first: the mode, both ends channel by channel, their lowest
/// bits, and the steps. The first texel's step has no highest bit, so the ends change places where
/// it would be set.
fn pack(mut ends: [[u8; 4]; 2], mut low_bits: [u8; 2], steps: &Lanes) -> u128 {
    let mut steps = small_integers(steps);
    if steps[0] >= 8 {
        ends.swap(0, 1);
        low_bits.swap(0, 1);
        steps = steps.map(|step| 15 - step);
    }
    let mut head = 1_u128 << 6;
    let mut at = 7;
    for channel in 0..4 {
        for end in &ends {
            head |= u128::from(end[channel]) << at;
            at += 7;
        }
    }
    head |= u128::from(low_bits[0]) << 63 | u128::from(low_bits[1]) << 64;
    let packed = (1..).zip(&steps[1..]).fold(u64::from(steps[0]), |packed, (texel, &step)| {
        packed | u64::from(step) << (4 * texel - 1)
    });
    head | u128::from(packed) << 65
}

/// The channels' lanes times a factor each, added up.
fn combined<const N: usize>(channels: &[Lanes; N], factors: &[f32; N]) -> Lanes {
    let mut total = [0.0; 16];
    for (lanes, &factor) in channels.iter().zip(factors) {
        total = zipped(&total, lanes, |total, value| total + value * factor);
    }
    total
}

fn dot<const N: usize>(a: &[f32; N], b: &[f32; N]) -> f32 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use block_compression::decode::decompress_blocks_as_rgba8;
    use block_compression::{BC7Settings, CompressionVariant};
    use proptest::prelude::*;

    use super::*;

    fn decoded(blocks: &[u8], size: u32) -> Vec<u8> {
        let mut rgba = vec![0; (4 * size * size) as usize];
        let variant = CompressionVariant::BC7(BC7Settings::alpha_basic());
        decompress_blocks_as_rgba8(variant, size, size, blocks, &mut rgba);
        rgba
    }

    #[test]
    fn every_opaque_colour_but_pure_black_parts_is_exact() {
        for code in 0..=255_u8 {
            let rgba = [code, 255 - code, code ^ 0x55, 255].repeat(16);
            let back = decoded(&compress(&rgba, 4), 4);
            let wanted = [code.max(1), (255 - code).max(1), (code ^ 0x55).max(1), 255];
            assert!(back.chunks(4).all(|texel| texel == wanted), "{wanted:?} {:?}", &back[..4]);
        }
    }

    #[test]
    fn steps_weigh_what_the_format_says() {
        let weights = [0, 4, 9, 13, 17, 21, 26, 30, 34, 38, 43, 47, 51, 55, 60, 64];
        for (step, in_64ths) in (0_u8..).zip(weights) {
            assert_eq!(weight(f32::from(step)) * 64.0, f32::from(in_64ths as u8));
        }
    }

    #[test]
    fn one_colour_and_full_coverage_come_back() {
        for colour in [[0, 0, 0, 255], [255, 255, 255, 255], [13, 200, 77, 255], [0, 0, 0, 0]] {
            let rgba = colour.repeat(16);
            let back = decoded(&compress(&rgba, 4), 4);
            for (a, b) in rgba.iter().zip(&back) {
                assert!(a.abs_diff(*b) <= 1, "{colour:?} became {:?}", &back[..4]);
            }
            assert_eq!(back[3], colour[3]);
        }
    }

    #[test]
    fn the_error_is_that_of_the_decoder() {
        let rgba: Vec<u8> = (0..64_u8).map(|i| i.wrapping_mul(37) ^ 0x5a).collect();
        let channels: [Lanes; 4] =
            std::array::from_fn(|c| std::array::from_fn(|t| f32::from(rgba[4 * t + c])));
        let fit = best_fit(&channels);
        let back = decoded(&pack(fit.ends, fit.low_bits, &fit.steps).to_le_bytes(), 4);
        let error: f32 =
            rgba.iter().zip(&back).map(|(a, b)| f32::from(a.abs_diff(*b)).powi(2)).sum();
        // The decoder rounds each channel to whole codes, the estimate does not.
        assert!((error - fit.error).abs() <= 0.1 * error + 64.0, "{error} {}", fit.error);
    }

    /// Peak signal-to-noise ratio in dB of the compressed demo picture, tile by tile of its source.
    fn psnr_of_the_demo_db() -> f64 {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../data/demo/dom.tif");
        let file = std::io::BufReader::new(std::fs::File::open(path).unwrap());
        let mut picture = tiff::decoder::Decoder::new(file).unwrap();
        let (mut squares, mut samples) = (0.0, 0.0);
        for chunk in 0..112 {
            let (width, height) = picture.chunk_data_dimensions(chunk);
            let tiff::decoder::DecodingResult::U8(rgb) = picture.read_chunk(chunk).unwrap() else {
                panic!("no 8-bit picture");
            };
            let size = (width.min(height) / 4 * 4) as usize;
            let rows = rgb.chunks(3 * width as usize).take(size);
            let texels = rows.flat_map(|row| row.chunks(3).take(size));
            let rgba: Vec<u8> = texels.flat_map(|t| [t[0], t[1], t[2], 255]).collect();
            let back = decoded(&compress(&rgba, size as u32), size as u32);
            squares +=
                rgba.iter().zip(&back).map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2)).sum::<f64>();
            samples += 0.75 * rgba.len() as f64;
        }
        10.0 * (255.0 * 255.0 * samples / squares).log10()
    }

    #[test]
    fn the_demos_picture_keeps_its_quality() {
        let psnr_db = psnr_of_the_demo_db();
        println!("{psnr_db:.2} dB");
        assert!(psnr_db > 40.0, "{psnr_db}");
    }

    proptest! {
        #[test]
        fn colours_along_a_line_come_back_near(
            a in prop::array::uniform3(0_u8..=255), b in prop::array::uniform3(0_u8..=255),
            along in prop::array::uniform16(0.0_f32..=1.0),
        ) {
            let rgba: Vec<u8> = along
                .iter()
                .flat_map(|&t| {
                    let part = |c: usize| f32::from(a[c]) * (1.0 - t) + f32::from(b[c]) * t;
                    [part(0).round() as u8, part(1).round() as u8, part(2).round() as u8, 255]
                })
                .collect();
            let back = decoded(&compress(&rgba, 4), 4);
            for (x, y) in rgba.chunks(4).zip(back.chunks(4)) {
                prop_assert_eq!(y[3], 255);
                // Half a step of a line across the whole of colour space is 8.5 codes.
                for channel in 0..3 {
                    prop_assert!(x[channel].abs_diff(y[channel]) <= 12, "{:?} {:?}", x, y);
                }
            }
        }
    }
}
