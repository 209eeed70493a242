use block_compression::CompressionVariant;
use block_compression::encode::compress_rgba8;

use super::bc7;
use crate::dataset::ColourFormat;

/// Texels with less coverage than this are clear in BC1, which has one bit for it.
const BC1_COVERED: u8 = 128;

/// Compresses a square of RGBA8 texels (a multiple of 4 a side) to the format.
pub fn blocks_of_rgba(rgba: &[u8], size_texels: u32, format: ColourFormat) -> Vec<u8> {
    match format {
        ColourFormat::Rgba8 => rgba.to_vec(),
        ColourFormat::Bc7 => bc7::compress(rgba, size_texels),
        ColourFormat::Bc1 => {
            let mut blocks = vec![0; format.byte_len(size_texels) as usize];
            let (variant, stride) = (CompressionVariant::BC1, 4 * size_texels);
            compress_rgba8(variant, rgba, &mut blocks, size_texels, size_texels, stride);
            clear_uncovered(rgba, size_texels as usize, &mut blocks);
            blocks
        }
    }
}

/// Encodes anew, with a clear texel among their four choices, the BC1 blocks that need one.
fn clear_uncovered(rgba: &[u8], size: usize, blocks: &mut [u8]) {
    let blocks_a_row = size / 4;
    for (index, block) in blocks.chunks_exact_mut(8).enumerate() {
        let corner = (index / blocks_a_row * 4 * size + index % blocks_a_row * 4) * 4;
        let texels: [[u8; 4]; 16] = std::array::from_fn(|texel| {
            let at = corner + (texel / 4 * size + texel % 4) * 4;
            [rgba[at], rgba[at + 1], rgba[at + 2], rgba[at + 3]]
        });
        if texels.iter().any(|texel| texel[3] < BC1_COVERED) {
            block.copy_from_slice(&clear_block(&texels));
        }
    }
}

/// A BC1 block in its three-colour form: the darkest and lightest covered texel, the colour halfway
/// between them, and clear.
fn clear_block(texels: &[[u8; 4]; 16]) -> [u8; 8] {
    let luma = |t: &[u8; 4]| 2 * u32::from(t[0]) + 5 * u32::from(t[1]) + u32::from(t[2]);
    let covered = || texels.iter().filter(|texel| texel[3] >= BC1_COVERED);
    let ends = covered().min_by_key(|t| luma(t)).zip(covered().max_by_key(|t| luma(t)));
    let (dark, light) = ends.map_or((0, 0), |(dark, light)| (packed_565(dark), packed_565(light)));
    // The first end not above the second is what selects the three-colour form.
    let (first, second) = (dark.min(light), dark.max(light));
    let (a, b) = (unpacked_565(first), unpacked_565(second));
    let palette = [a, b, std::array::from_fn(|c| (a[c] + b[c]) / 2)];
    let mut indices = 0_u32;
    for (position, texel) in texels.iter().enumerate() {
        let choice = if texel[3] < BC1_COVERED { 3 } else { nearest(&palette, texel) };
        indices |= choice << (2 * position);
    }
    let mut block = [0; 8];
    block[..2].copy_from_slice(&first.to_le_bytes());
    block[2..4].copy_from_slice(&second.to_le_bytes());
    block[4..].copy_from_slice(&indices.to_le_bytes());
    block
}

fn packed_565(texel: &[u8; 4]) -> u16 {
    let part = |value: u8, top: u32| ((u32::from(value) * top + 127) / 255) as u16;
    part(texel[0], 31) << 11 | part(texel[1], 63) << 5 | part(texel[2], 31)
}

fn unpacked_565(packed: u16) -> [i32; 3] {
    let packed = i32::from(packed);
    let (r, g, b) = (packed >> 11, packed >> 5 & 63, packed & 31);
    [r << 3 | r >> 2, g << 2 | g >> 4, b << 3 | b >> 2]
}

fn nearest(palette: &[[i32; 3]; 3], texel: &[u8; 4]) -> u32 {
    let distance = |colour: &[i32; 3]| -> i32 {
        colour.iter().zip(texel).map(|(c, &t)| (c - i32::from(t)).pow(2)).sum()
    };
    let best = (0..3).min_by_key(|&choice| distance(&palette[choice]));
    best.unwrap_or(0) as u32
}
