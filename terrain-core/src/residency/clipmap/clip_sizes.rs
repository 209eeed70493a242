use super::{clip_level_count, level_size_texels};
use crate::selection::TileTree;
use crate::tiling::LayerLayout;

/// Sides of the windows of both layers in texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ClipSizes {
    /// Of the height layer.
    pub heights: u32,
    /// Of the colour layer; 0 where there is none.
    pub colours: u32,
}

/// Longest side of a window, and most bytes of GPU memory that the windows of a layer may take.
const MOST_TEXELS: f64 = 4096.0;
const MOST_BYTES: f64 = 256.0 * 1024.0 * 1024.0;

/// Bytes that a texel of a height level takes on the GPU: its height as float32, and its slopes.
const HEIGHT_TEXEL_BYTES: f64 = 12.0;

/// The windows for texels of at most `texel_rad` (radians, as seen from the eye), judged by the
/// imagery where there is any.
///
/// A level begins where the window of the next finer one ends, a quarter of its own side from its
/// middle. There its texels are largest, and there they are to be of the size asked for: 4 / `texel_rad`
/// texels a side (Losasso and Hoppe, 2004, section 3, put the same the other way round). Rounded in
/// steps of half an octave, so that zooming does not bring new windows all the time, never more than the
/// finest level has, and such that a layer takes no more than 256 MiB (where an adapter decodes
/// imagery as it comes, what that takes is not counted). Height windows cover the ground
/// the colour windows cover.
///
/// `colour_texel_bytes`: bytes that a texel of imagery takes on the GPU.
pub fn clip_sizes(tree: &TileTree, texel_rad: f64, colour_texel_bytes: f64) -> ClipSizes {
    let wanted = (4.0 / texel_rad.max(1.0e-9)).clamp(1.0, MOST_TEXELS);
    let rounded = half_octave(wanted);
    let heights = tree.heights.layout;
    let Some(colours) = tree.colours.as_ref().map(|layer| layer.layout) else {
        return ClipSizes { heights: fitted(&heights, rounded, HEIGHT_TEXEL_BYTES), colours: 0 };
    };
    let height_texels_a_colour_texel =
        f64::from(heights.tile_size_texels) / f64::from(colours.tile_size_texels);
    ClipSizes {
        heights: fitted(&heights, rounded * height_texels_a_colour_texel, HEIGHT_TEXEL_BYTES),
        colours: fitted(&colours, rounded, colour_texel_bytes),
    }
}

/// Whether a level with texels of this size is worth having from `clearance_m` above the ground: where
/// the texels of the next coarser one would be larger than `texel_rad` even straight below.
///
/// With windows of [`clip_sizes`] that is while the eye is lower than half the window's side; Losasso
/// and Hoppe (2004, section 4.1) leave a level out from 0.4 of it on.
pub fn is_level_wanted(texel_m: f64, clearance_m: f64, texel_rad: f64) -> bool {
    2.0 * texel_m > texel_rad * clearance_m
}

/// The nearest of the sizes 2^k and 3 * 2^k.
fn half_octave(wanted: f64) -> f64 {
    let power = wanted.log2().floor().exp2();
    let sizes = [power, 1.5 * power, 2.0 * power];
    let nearer = |a: &f64, b: &f64| (a / wanted).log2().abs().total_cmp(&(b / wanted).log2().abs());
    sizes.into_iter().min_by(nearer).unwrap_or(power)
}

/// A multiple of 64 that holds at least level 0, at most the finest level and what memory bears.
fn fitted(layout: &LayerLayout, wanted: f64, texel_bytes: f64) -> u32 {
    let levels = clip_level_count(layout);
    let finest = level_size_texels(layout, levels - 1);
    let mut size = wanted;
    while size * size * texel_bytes * f64::from(levels) > MOST_BYTES {
        size = half_octave(size * 0.7);
    }
    let size = (size.ceil() as u32).max(layout.tile_size_texels).min(finest);
    size.next_multiple_of(64)
}
