use super::TexelRect;
use crate::tiling::LayerLayout;

/// Windows move in steps of so many texels: blocks of compressed texels stay whole.
pub const WINDOW_STEP_TEXELS: u32 = 4;

/// Side of a whole level in texels, for a level of [`clip_level_count`].
pub fn level_size_texels(layout: &LayerLayout, level: u8) -> u32 {
    layout.tile_size_texels << level
}

/// Levels of the layer whose texels can be numbered with 31 bits: all of any but a planet's at a
/// resolution of centimetres, whose finest levels are then left out.
pub fn clip_level_count(layout: &LayerLayout) -> u8 {
    let numbered = 31 - layout.tile_size_texels.max(1).ilog2();
    layout.level_count.clamp(1, numbered as u8)
}

/// The window of a level: a square of `clip_size` texels with the eye as near to its middle as whole
/// steps allow, moved inwards where it would reach beyond the level, whose side has `level_size` texels;
/// the whole level where it is no larger than the window. Both sizes are multiples of the step.
///
/// `eye` is in texels east and south of the root's corner, anywhere.
pub fn window_around(eye: [f64; 2], level_size: u32, clip_size: u32) -> TexelRect {
    let size = clip_size.min(level_size);
    let step = f64::from(WINDOW_STEP_TEXELS);
    let last = f64::from(level_size - size);
    let start = eye.map(|at| {
        let start = ((at - 0.5 * f64::from(size)) / step).round() * step;
        start.clamp(0.0, last) as u32
    });
    TexelRect::new(start, [size; 2])
}
