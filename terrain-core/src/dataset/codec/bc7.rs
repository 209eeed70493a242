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

type Colour = [f32; 4];

/// Weights of the steps in units of 1/64.
const STEP_WEIGHTS: [f32; 16] =
    [0.0, 4.0, 9.0, 13.0, 17.0, 21.0, 26.0, 30.0, 34.0, 38.0, 43.0, 47.0, 51.0, 55.0, 60.0, 64.0];

/// Sum of squared errors of a block that is not worth refining: half a code a channel.
const NO_VISIBLE_ERROR: f32 = 16.0;

/// One candidate for a block.
#[derive(Clone, Copy)]
struct Fit {
    /// Seven upper bits of both ends' channels.
    ends: [[u8; 4]; 2],
    /// The lowest bit all channels of an end share.
    low_bits: [u8; 2],
    steps: [u8; 16],
    error: f32,
}

/// Compresses a square of RGBA8 texels, a multiple of 4 a side, block row by block row.
pub fn compress(rgba: &[u8], size_texels: u32) -> Vec<u8> {
    let size = size_texels as usize;
    let mut blocks = Vec::with_capacity(size * size);
    for row in (0..size).step_by(4) {
        for column in (0..size).step_by(4) {
            let texels: [Colour; 16] = std::array::from_fn(|texel| {
                let at = ((row + texel / 4) * size + column + texel % 4) * 4;
                std::array::from_fn(|channel| f32::from(rgba[at + channel]))
            });
            blocks.extend(pack(&best_fit(&texels)).to_le_bytes());
        }
    }
    blocks
}

fn best_fit(texels: &[Colour; 16]) -> Fit {
    if texels.iter().all(|texel| texel == &texels[0]) {
        return fit_to_ends(texels, texels[0], texels[0]);
    }
    let mean = scaled(texels.iter().fold([0.0; 4], added), 1.0 / 16.0);
    let axis = principal_axis(texels, mean);
    let (low, high) = texels.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), t| {
        let along = dot(subtracted(*t, mean), axis);
        (low.min(along), high.max(along))
    });
    let end = |along: f32| added(mean, &scaled(axis, along));
    let first = fit_to_ends(texels, end(low), end(high));
    if first.error <= NO_VISIBLE_ERROR {
        return first;
    }
    match refined_ends(texels, &first.steps) {
        Some([a, b]) => {
            let second = fit_to_ends(texels, a, b);
            if second.error < first.error { second } else { first }
        }
        None => first,
    }
}

/// Unit vector along which the texels spread most; any where they do not.
fn principal_axis(texels: &[Colour; 16], mean: Colour) -> Colour {
    let mut covariance = [[0.0_f32; 4]; 4];
    for texel in texels {
        let offset = subtracted(*texel, mean);
        for (row, &part) in covariance.iter_mut().zip(&offset) {
            *row = added(*row, &scaled(offset, part));
        }
    }
    // The longest row is a fair start: it is the covariance with the most varied channel.
    let longest = |a: &&Colour, b: &&Colour| f32::total_cmp(&dot(**a, **a), &dot(**b, **b));
    let mut axis = covariance.iter().max_by(longest).copied().unwrap_or([0.0; 4]);
    for _ in 0..4 {
        let turned = covariance.map(|row| dot(row, axis));
        let largest = turned.iter().fold(0.0, |most: f32, part| most.max(part.abs()));
        if largest < 1e-6 {
            return [0.5; 4];
        }
        axis = scaled(turned, 1.0 / largest);
    }
    scaled(axis, 1.0 / dot(axis, axis).sqrt())
}

/// Rounds the ends and gives each texel its nearest step between them.
fn fit_to_ends(texels: &[Colour; 16], from: Colour, to: Colour) -> Fit {
    let opaque = texels.iter().all(|texel| texel[3] == 255.0);
    let (first, low_first) = rounded_end(from, opaque);
    let (second, low_second) = rounded_end(to, opaque);
    let ends = [whole_end(first, low_first), whole_end(second, low_second)];
    let line = subtracted(ends[1], ends[0]);
    let length = dot(line, line);
    let scale = if length > 0.0 { 15.0 / length } else { 0.0 };
    let mut fit = Fit {
        ends: [first, second],
        low_bits: [low_first, low_second],
        steps: [0; 16],
        error: 0.0,
    };
    for (step, texel) in fit.steps.iter_mut().zip(texels) {
        let along = dot(subtracted(*texel, ends[0]), line) * scale;
        *step = (along + 0.5).clamp(0.0, 15.0) as u8;
        let weight = STEP_WEIGHTS[usize::from(*step)] / 64.0;
        let miss = subtracted(*texel, added(ends[0], &scaled(line, weight)));
        fit.error += dot(miss, miss);
    }
    fit
}

/// Seven bits a channel and the shared lowest bit that together come nearest to the colour. Opaque
/// blocks keep full coverage, which only a set lowest bit can say.
fn rounded_end(end: Colour, opaque: bool) -> ([u8; 4], u8) {
    let rounded = |low_bit: u8| -> [u8; 4] {
        end.map(|part| ((part - f32::from(low_bit)) * 0.5 + 0.5).clamp(0.0, 127.0) as u8)
    };
    let miss = |low_bit: u8| {
        let offset = subtracted(whole_end(rounded(low_bit), low_bit), end);
        dot(offset, offset)
    };
    let low_bit = u8::from(opaque || miss(1) <= miss(0));
    let mut upper = rounded(low_bit);
    if opaque {
        upper[3] = 127;
    }
    (upper, low_bit)
}

fn whole_end(upper: [u8; 4], low_bit: u8) -> Colour {
    upper.map(|part| f32::from(part << 1 | low_bit))
}

/// The ends that fit the texels best at the steps they have; `None` where all have the same.
fn refined_ends(texels: &[Colour; 16], steps: &[u8; 16]) -> Option<[Colour; 2]> {
    let (mut aa, mut ab, mut bb) = (0.0_f32, 0.0_f32, 0.0_f32);
    let (mut a_sum, mut b_sum) = ([0.0; 4], [0.0; 4]);
    for (texel, &step) in texels.iter().zip(steps) {
        let b = STEP_WEIGHTS[usize::from(step)] / 64.0;
        let a = 1.0 - b;
        (aa, ab, bb) = (aa + a * a, ab + a * b, bb + b * b);
        a_sum = added(a_sum, &scaled(*texel, a));
        b_sum = added(b_sum, &scaled(*texel, b));
    }
    let determinant = aa * bb - ab * ab;
    (determinant > 1e-4).then(|| {
        let inverse = 1.0 / determinant;
        let first = subtracted(scaled(a_sum, bb), scaled(b_sum, ab));
        let second = subtracted(scaled(b_sum, aa), scaled(a_sum, ab));
        [scaled(first, inverse), scaled(second, inverse)]
    })
}

/// The 128 bits of a block, lowest first: the mode, both ends channel by channel, their lowest
/// bits, and the steps. The first texel's step has no highest bit, so the ends change places where
/// it would be set.
fn pack(fit: &Fit) -> u128 {
    let mut fit = *fit;
    if fit.steps[0] >= 8 {
        fit.ends.swap(0, 1);
        fit.low_bits.swap(0, 1);
        fit.steps = fit.steps.map(|step| 15 - step);
    }
    let mut bits = 1_u128 << 6;
    let mut at = 7;
    for channel in 0..4 {
        for end in &fit.ends {
            bits |= u128::from(end[channel]) << at;
            at += 7;
        }
    }
    for low_bit in fit.low_bits {
        bits |= u128::from(low_bit) << at;
        at += 1;
    }
    for (texel, &step) in fit.steps.iter().enumerate() {
        bits |= u128::from(step) << at;
        at += if texel == 0 { 3 } else { 4 };
    }
    bits
}

fn dot(a: Colour, b: Colour) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]
}

fn added(a: Colour, b: &Colour) -> Colour {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]]
}

fn subtracted(a: Colour, b: Colour) -> Colour {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3]]
}

fn scaled(a: Colour, by: f32) -> Colour {
    [a[0] * by, a[1] * by, a[2] * by, a[3] * by]
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
        let texels: [Colour; 16] =
            std::array::from_fn(|t| std::array::from_fn(|c| f32::from(rgba[4 * t + c])));
        let fit = best_fit(&texels);
        let back = decoded(&pack(&fit).to_le_bytes(), 4);
        let error: f32 =
            rgba.iter().zip(&back).map(|(a, b)| f32::from(a.abs_diff(*b)).powi(2)).sum();
        // The decoder rounds each channel to whole codes, the estimate does not.
        assert!((error - fit.error).abs() <= 0.1 * error + 64.0, "{error} {}", fit.error);
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
