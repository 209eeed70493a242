use bytemuck::{Pod, Zeroable};
use glam::{DVec2, dvec2};

use crate::residency::clipmap::{TexelRect, level_size_texels};
use crate::tiling::{LayerLayout, TilingScheme};

/// One level as the shaders see it: the twin of `ClipLevel` in `common/clip_levels.wgsl`, where the
/// members are explained.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct ClipLevel {
    pub origin_from_eye_m: [f32; 2],
    pub texels_per_m: f32,
    pub texel_m: f32,
    pub shown: [f32; 4],
    pub whole: [i32; 4],
    pub texture_texel: [i32; 2],
    pub padding: [i32; 2],
}

impl ClipLevel {
    /// Stands for a border where the level ends and nothing coarser goes on.
    const FAR: f32 = 1.0e12;

    /// The level seen from `eye` (metres east and north), showing `shown`, in a texture of
    /// `texture_side` texels a side.
    pub fn new(
        scheme: &TilingScheme,
        layout: &LayerLayout,
        level: u8,
        shown: &TexelRect,
        eye: DVec2,
        texture_side: u32,
    ) -> Self {
        let texel_m = layout.texel_size_m(scheme, level);
        let size = level_size_texels(layout, level);
        let from_corner = eye - scheme.origin;
        let nearest = |metres: f64| (metres / texel_m).round().clamp(0.0, f64::from(size)) as u32;
        let texel = [nearest(from_corner.x), nearest(-from_corner.y)];
        let place = dvec2(f64::from(texel[0]), -f64::from(texel[1])) * texel_m;
        let from_texel = |at: u32, axis: usize| (i64::from(at) - i64::from(texel[axis])) as f32;
        let first = |at: u32, axis| if at == 0 { -Self::FAR } else { from_texel(at, axis) };
        let end = |at: u32, axis| if at == size { Self::FAR } else { from_texel(at, axis) };
        let shows = if shown.is_empty() {
            [Self::FAR, Self::FAR, -Self::FAR, -Self::FAR]
        } else {
            [first(shown.west, 0), first(shown.north, 1), end(shown.east, 0), end(shown.south, 1)]
        };
        let begin = texel.map(|at| -(i64::from(at)) as i32);
        let last = texel.map(|at| (i64::from(size) - i64::from(at)) as i32);
        Self {
            origin_from_eye_m: (place - from_corner).as_vec2().into(),
            texels_per_m: (1.0 / texel_m) as f32,
            texel_m: texel_m as f32,
            shown: shows,
            whole: [begin[0], begin[1], last[0], last[1]],
            texture_texel: texel.map(|at| (at % texture_side) as i32),
            padding: [0; 2],
        }
    }
}

/// What the shaders know of all levels and of the mesh: the twin of `ClipFrame` in
/// `common/clip_levels.wgsl`, where the members are explained.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct ClipFrame {
    pub reference_from_eye_m: [f32; 2],
    pub unit_m: f32,
    pub ring_cells: f32,
    pub patch_columns: u32,
    pub mesh_level: f32,
    pub height_levels: u32,
    pub colour_levels: u32,
    pub height_fade_texels: f32,
    pub colour_fade_texels: f32,
}
