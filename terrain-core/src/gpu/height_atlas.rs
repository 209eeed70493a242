use super::atlas::{AtlasGrid, mip_view};

/// The cache texture of the heights, in metres, and the slopes derived from them. Both have the
/// same slots and three mips.
pub(crate) struct HeightAtlas {
    pub grid: AtlasGrid,
    pub heights: wgpu::Texture,
    pub slopes: wgpu::Texture,
}

impl HeightAtlas {
    pub const MIP_COUNT: u32 = 3;
    pub const HEIGHT_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;
    pub const SLOPE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

    pub fn new(device: &wgpu::Device, grid: AtlasGrid) -> Self {
        let texture = |label, format| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: grid.extent(),
                mip_level_count: Self::MIP_COUNT,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::TEXTURE_BINDING
                    | wgpu::TextureUsages::STORAGE_BINDING
                    | wgpu::TextureUsages::COPY_SRC,
                view_formats: &[],
            })
        };
        Self {
            grid,
            heights: texture("height atlas", Self::HEIGHT_FORMAT),
            slopes: texture("slope atlas", Self::SLOPE_FORMAT),
        }
    }

    pub fn height_mip(&self, mip: u32) -> wgpu::TextureView {
        mip_view(&self.heights, mip)
    }

    pub fn slope_mip(&self, mip: u32) -> wgpu::TextureView {
        mip_view(&self.slopes, mip)
    }
}
