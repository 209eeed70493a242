use glam::{DVec2, DVec3, IVec2, Vec2, dvec2};

use crate::gpu::uniform_group::UniformGroup;
use crate::residency::page_table::PageLayout;
use crate::tiling::TilingScheme;

/// Where plane ground lies in its virtual texture as seen from an eye: the `PageGround` of
/// `common/page_ground.wgsl`, where the members are explained.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct PageGround {
    pub anchor_texel: [i32; 2],
    pub anchor_from_eye_m: Vec2,
    pub texels_per_m: f32,
    pub padding: f32,
}

impl PageGround {
    /// Of the ground of a tiling whose tiles are the layout's pages. The anchor is the texel nearest to the eye,
    /// so that places close by are exact however large the texture is.
    pub fn new(layout: &PageLayout, scheme: &TilingScheme, eye: DVec3) -> Self {
        let tile_m = scheme.tile_size_m(layout.coarsest_level);
        let texel_m = tile_m / f64::from(layout.tile_size_texels);
        let from_origin_m = dvec2(eye.x - scheme.origin.x, scheme.origin.y - eye.y);
        let (first, end) = (layout.data_first.as_dvec2(), layout.data_end.as_dvec2());
        let anchor = (from_origin_m / texel_m).floor().clamp(first, end);
        let corner_m = scheme.origin + dvec2(anchor.x, -anchor.y) * texel_m;
        let from_eye_m: DVec2 = corner_m - eye.truncate();
        let anchor: IVec2 = anchor.as_ivec2();
        Self {
            anchor_texel: anchor.to_array(),
            anchor_from_eye_m: from_eye_m.as_vec2(),
            texels_per_m: texel_m.recip() as f32,
            padding: 0.0,
        }
    }
}

/// Group 3 of the passes that draw plane ground with a page table.
pub(crate) struct PageGroundGroup {
    pub layout: wgpu::BindGroupLayout,
    pub group: wgpu::BindGroup,
    pub buffer: wgpu::Buffer,
    written: Option<PageGround>,
}

impl PageGroundGroup {
    /// The group the bindings are in.
    pub const GROUP: u32 = 3;

    pub fn new(device: &wgpu::Device) -> Self {
        let (bytes, usage) = (size_of::<PageGround>() as u64, wgpu::BufferUsages::empty());
        let stages = wgpu::ShaderStages::FRAGMENT;
        let UniformGroup { layout, group, buffer } =
            UniformGroup::new(device, "page ground", bytes, stages, usage);
        Self { layout, group, buffer, written: None }
    }

    /// Writes the place; returns the bytes sent, 0 where nothing changed.
    pub fn set(&mut self, queue: &wgpu::Queue, ground: &PageGround) -> u64 {
        if self.written.as_ref() == Some(ground) {
            return 0;
        }
        queue.write_buffer(&self.buffer, 0, bytemuck::bytes_of(ground));
        self.written = Some(*ground);
        size_of::<PageGround>() as u64
    }
}
