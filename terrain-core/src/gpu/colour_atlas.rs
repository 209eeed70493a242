use super::atlas::{AtlasGrid, mip_view};
use crate::dataset::{ColourFormat, ColourTile};

/// The cache texture of the imagery as it is stored, and its derived coarser mips.
pub(crate) struct ColourAtlas {
    pub grid: AtlasGrid,
    pub format: ColourFormat,
    pub colours: wgpu::Texture,
    /// Mips 1 and 2 of `colours`, uncompressed; its own mips 0 and 1.
    pub mips: wgpu::Texture,
}

impl ColourAtlas {
    pub const MIP_COUNT: u32 = 2;
    pub const MIP_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;

    /// `format` must be one the device reads.
    pub fn new(device: &wgpu::Device, grid: AtlasGrid, format: ColourFormat) -> Self {
        let [width, height] = grid.size_texels();
        let colours = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("colour atlas"),
            size: grid.extent(),
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: texture_format(format),
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let mips = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("colour atlas mips"),
            size: wgpu::Extent3d { width: width / 2, height: height / 2, depth_or_array_layers: 1 },
            mip_level_count: Self::MIP_COUNT,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: Self::MIP_FORMAT,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::RENDER_ATTACHMENT,
            view_formats: &[],
        });
        Self { grid, format, colours, mips }
    }

    pub fn derived_mip(&self, mip: u32) -> wgpu::TextureView {
        mip_view(&self.mips, mip)
    }

    /// Writes one tile into its slot; returns the bytes sent.
    pub fn upload(&self, queue: &wgpu::Queue, slot: u32, tile: &ColourTile) -> u64 {
        let [x, y] = self.grid.slot_origin_texels(slot);
        let size = self.grid.slot_size_texels;
        let (bytes_per_row, rows) = match self.format {
            ColourFormat::Bc1 => (size / 4 * 8, size / 4),
            ColourFormat::Bc7 => (size / 4 * 16, size / 4),
            ColourFormat::Rgba8 => (size * 4, size),
        };
        queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                texture: &self.colours,
                mip_level: 0,
                origin: wgpu::Origin3d { x, y, z: 0 },
                aspect: wgpu::TextureAspect::All,
            },
            &tile.data,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(bytes_per_row),
                rows_per_image: Some(rows),
            },
            wgpu::Extent3d { width: size, height: size, depth_or_array_layers: 1 },
        );
        tile.data.len() as u64
    }
}

/// The GPU's name of a colour format.
fn texture_format(format: ColourFormat) -> wgpu::TextureFormat {
    match format {
        ColourFormat::Bc1 => wgpu::TextureFormat::Bc1RgbaUnormSrgb,
        ColourFormat::Bc7 => wgpu::TextureFormat::Bc7RgbaUnormSrgb,
        ColourFormat::Rgba8 => wgpu::TextureFormat::Rgba8UnormSrgb,
    }
}
