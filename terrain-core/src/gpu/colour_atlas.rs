use super::atlas::{AtlasGrid, mip_view};
use crate::dataset::{ColourFormat, ColourTile};

/// The cache texture of the imagery.
///
/// Tiles cross the bus as they are stored, block compressed or not, and land in `stored`. From there
/// the GPU decodes them into `colours` and derives two mips: blocks cannot be written by shaders, and
/// mips that came with the tiles would cost a third more bytes on the bus.
pub(crate) struct ColourAtlas {
    pub grid: AtlasGrid,
    pub format: ColourFormat,
    pub stored: wgpu::Texture,
    pub colours: wgpu::Texture,
}

impl ColourAtlas {
    pub const MIP_COUNT: u32 = 3;
    pub const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;

    /// `format` must be one the device reads.
    pub fn new(device: &wgpu::Device, grid: AtlasGrid, format: ColourFormat) -> Self {
        let texture = |label, mip_level_count, format, usage| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: grid.extent(),
                mip_level_count,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: usage | wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            })
        };
        use wgpu::TextureUsages as Usage;
        Self {
            grid,
            format,
            stored: texture("stored colours", 1, texture_format(format), Usage::COPY_DST),
            colours: texture(
                "colour atlas",
                Self::MIP_COUNT,
                Self::FORMAT,
                Usage::RENDER_ATTACHMENT,
            ),
        }
    }

    pub fn mip(&self, mip: u32) -> wgpu::TextureView {
        mip_view(&self.colours, mip)
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
                texture: &self.stored,
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
pub(super) fn texture_format(format: ColourFormat) -> wgpu::TextureFormat {
    match format {
        ColourFormat::Bc1 => wgpu::TextureFormat::Bc1RgbaUnormSrgb,
        ColourFormat::Bc7 => wgpu::TextureFormat::Bc7RgbaUnormSrgb,
        ColourFormat::Rgba8 => wgpu::TextureFormat::Rgba8UnormSrgb,
    }
}
