use glam::Vec2;

use crate::residency::slot_origin_texels;

/// How a cache texture is cut into slots: `columns` by `rows` of square slots.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct AtlasGrid {
    pub columns: u32,
    pub rows: u32,
    /// Texels along one side of a slot, gutter counted.
    pub slot_size_texels: u32,
}

impl AtlasGrid {
    /// North-west texel of the slot. Formula (2) of the tile-scheduling paper, in texels.
    pub fn slot_origin_texels(&self, slot: u32) -> [u32; 2] {
        slot_origin_texels(slot, self.columns, self.slot_size_texels)
    }

    /// Width and height of the whole texture.
    pub fn size_texels(&self) -> [u32; 2] {
        [self.columns * self.slot_size_texels, self.rows * self.slot_size_texels]
    }

    /// Parts of the texture's sides that a texel is wide and high.
    pub fn uv_per_texel(&self) -> Vec2 {
        1.0 / Vec2::from(self.size_texels().map(|size| size as f32))
    }

    pub fn extent(&self) -> wgpu::Extent3d {
        let [width, height] = self.size_texels();
        wgpu::Extent3d { width, height, depth_or_array_layers: 1 }
    }
}

/// A view of one mip of a texture.
pub(crate) fn mip_view(texture: &wgpu::Texture, mip: u32) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor {
        base_mip_level: mip,
        mip_level_count: Some(1),
        ..Default::default()
    })
}
