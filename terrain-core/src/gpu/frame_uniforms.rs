use encase::{ShaderSize, ShaderType, UniformBuffer};
use glam::{IVec2, Mat4, Vec2, Vec3};

/// Where one layer's entries and nodes lie in the shared table buffers.
#[derive(Clone, Copy, Debug, Default, PartialEq, ShaderType)]
pub struct TableRange {
    /// Index of the layer's first entry.
    pub first_entry: u32,
    /// Number of entries, finest level first.
    pub entry_count: u32,
    /// Index of the first word of the layer's quadtree.
    pub first_node: u32,
    /// The root's own word.
    pub root_word: u32,
}

/// Declares the struct and the list of its members' names, which a test holds against the shader.
macro_rules! uniforms {
    ($(#[$meta:meta])* pub struct $name:ident { $($(#[$attribute:meta])* pub $member:ident: $type:ty,)+ }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, ShaderType)]
        #[expect(missing_docs, reason = "explained in common/frame.wgsl")]
        pub struct $name { $($(#[$attribute])* pub $member: $type,)+ }

        #[cfg(test)]
        impl $name {
            pub(super) const MEMBER_NAMES: &[&str] = &[$(stringify!($member)),+];
        }
    };
}

uniforms! {
/// The uniforms every pass of a frame reads: the twin of `FrameUniforms` in `common/frame.wgsl`,
/// where the members are explained. A test compares the two member by member.
pub struct FrameUniforms {
    pub clip_from_relative: Mat4,
    pub view_forward: Vec3,
    pub units_per_m: f32,
    pub view_right: Vec3,
    pub mesh_scale_m: f32,
    pub view_up: Vec3,
    pub vertical_exaggeration: f32,
    pub anchor_fixed: IVec2,
    pub anchor_from_eye_m: Vec2,
    pub data_min_from_eye_m: Vec2,
    pub data_max_from_eye_m: Vec2,
    pub eye_height_coarse_m: f32,
    pub eye_height_rest_m: f32,
    pub haze_distance_m: f32,
    pub haze_scale_height_m: f32,
    pub sun_direction: Vec3,
    pub shading_strength: f32,
    pub haze_colour: Vec3,
    pub eye_height_above_base_m: f32,
    pub zenith_colour: Vec3,
    pub height_min_m: f32,
    pub tint_at_eye: f32,
    pub tint_per_m: f32,
    pub height_tile_texels: f32,
    pub colour_tile_texels: f32,
    pub height_uv_per_texel: Vec2,
    pub colour_uv_per_texel: Vec2,
    pub height_gutter_texels: f32,
    pub colour_gutter_texels: f32,
    pub has_colours: u32,
    #[shader(align(16))]
    pub height_table: TableRange,
    pub colour_table: TableRange,
}
}

impl FrameUniforms {
    /// Size in bytes on the GPU.
    pub const BYTES: u64 = Self::SHADER_SIZE.get();

    /// Where the ranges of both tables lie among the bytes, one after the other at the end.
    pub(super) const TABLE_RANGES_OFFSET: u64 = Self::BYTES - 2 * TableRange::SHADER_SIZE.get();

    /// The bytes as the GPU reads them.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut buffer = UniformBuffer::new(Vec::with_capacity(Self::BYTES as usize));
        #[expect(clippy::expect_used, reason = "a Vec grows as needed: writing cannot fail")]
        buffer.write(self).expect("writing into a Vec");
        buffer.into_inner()
    }
}
