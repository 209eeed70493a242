use crate::dataset::{ColourFormat, ColourTile};
use crate::gpu::colour_atlas::texture_format;
use crate::residency::clipmap::Piece;

/// What the clipmap's textures are made for: side in texels and number of levels of either layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ClipTextureSizes {
    pub heights: [u32; 2],
    /// Without imagery a stub.
    pub colours: [u32; 2],
    pub colour_format: ColourFormat,
    /// Whether blocks are decoded once, when they come, instead of whenever they are sampled.
    pub decodes_blocks: bool,
}

/// The windows of all levels, a layer of an array each: heights in metres, the slopes derived from them,
/// and the imagery as it is stored, beside it decoded where that is asked for.
pub(crate) struct ClipTextures {
    pub heights: wgpu::Texture,
    pub slopes: wgpu::Texture,
    pub stored_colours: wgpu::Texture,
    pub decoded_colours: Option<wgpu::Texture>,
    pub sizes: ClipTextureSizes,
}

impl ClipTextures {
    const HEIGHT_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;
    const SLOPE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
    pub const DECODED_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;

    pub fn new(device: &wgpu::Device, sizes: ClipTextureSizes) -> Self {
        let texture = |label, [side, levels]: [u32; 2], format, usage| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width: side, height: side, depth_or_array_layers: levels },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: usage | wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            })
        };
        use wgpu::TextureUsages as Usage;
        let (storage, copied) = (Usage::STORAGE_BINDING | Usage::COPY_SRC, Usage::COPY_DST);
        let format = texture_format(sizes.colour_format);
        let decodes = sizes.decodes_blocks && sizes.colour_format != ColourFormat::Rgba8;
        let decoded = || {
            let usage = Usage::RENDER_ATTACHMENT;
            texture("decoded clip colours", sizes.colours, Self::DECODED_FORMAT, usage)
        };
        Self {
            heights: texture("clip heights", sizes.heights, Self::HEIGHT_FORMAT, storage),
            slopes: texture("clip slopes", sizes.heights, Self::SLOPE_FORMAT, storage),
            stored_colours: texture("clip colours", sizes.colours, format, copied),
            decoded_colours: decodes.then(decoded),
            sizes,
        }
    }

    /// The imagery to sample.
    pub fn colours(&self) -> &wgpu::Texture {
        self.decoded_colours.as_ref().unwrap_or(&self.stored_colours)
    }

    /// A view of all levels of one of the textures.
    pub fn all_levels(texture: &wgpu::Texture) -> wgpu::TextureView {
        texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        })
    }

    /// A view of one level of one of the textures.
    pub fn level(texture: &wgpu::Texture, level: u32) -> wgpu::TextureView {
        texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2),
            base_array_layer: level,
            array_layer_count: Some(1),
            ..Default::default()
        })
    }

    /// Writes a piece of imagery, whole blocks of 4 x 4 texels, from its tile; without a tile there is
    /// no imagery. Returns the bytes sent.
    pub fn write_colours(
        &self,
        queue: &wgpu::Queue,
        level: u32,
        piece: &Piece,
        tile: Option<&ColourTile>,
    ) -> u64 {
        let format = self.sizes.colour_format;
        let [width, height] = piece.size;
        let (block, block_bytes) = block_of(format);
        let row_bytes = |texels: u32| texels / block * block_bytes;
        let none;
        let (data, offset, bytes_per_row) = match tile {
            Some(tile) => {
                let stride = row_bytes(tile.stored_size_texels);
                let [x, y] = piece.source;
                (&tile.data, y / block * stride + row_bytes(x), stride)
            }
            None => {
                none = without_imagery(format, row_bytes(width) * height / block);
                (&none, 0, row_bytes(width))
            }
        };
        queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                texture: &self.stored_colours,
                mip_level: 0,
                origin: wgpu::Origin3d { x: piece.target[0], y: piece.target[1], z: level },
                aspect: wgpu::TextureAspect::All,
            },
            data,
            wgpu::TexelCopyBufferLayout {
                offset: u64::from(offset),
                bytes_per_row: Some(bytes_per_row),
                rows_per_image: Some(height / block),
            },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
        u64::from(row_bytes(width)) * u64::from(height / block)
    }
}

/// Texels along a block's side, and its bytes.
fn block_of(format: ColourFormat) -> (u32, u32) {
    match format {
        ColourFormat::Bc1 => (4, 8),
        ColourFormat::Bc7 => (4, 16),
        ColourFormat::Rgba8 => (1, 4),
    }
}

/// So many bytes of texels without coverage.
fn without_imagery(format: ColourFormat, bytes: u32) -> Vec<u8> {
    let block: &[u8] = match format {
        // Equal end points make the fourth entry of the palette the transparent one.
        ColourFormat::Bc1 => &[0, 0, 0, 0, 255, 255, 255, 255],
        // The reserved mode decodes to zeros.
        ColourFormat::Bc7 => &[0; 16],
        ColourFormat::Rgba8 => &[0; 4],
    };
    block.iter().copied().cycle().take(bytes as usize).collect()
}
