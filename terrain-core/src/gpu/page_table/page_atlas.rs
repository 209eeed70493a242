use crate::dataset::{ColourFormat, ColourTile};
use crate::gpu::GpuContext;
use crate::gpu::atlas::AtlasGrid;
use crate::gpu::colour_atlas::ColourAtlas;
use crate::gpu::derive_colours_pass::DeriveColoursPass;
use crate::terrain_renderer::RenderError;

/// The texture that holds a virtual texture's resident pages: the paper's J1 on the GPU.
pub(crate) struct PageAtlas {
    colours: ColourAtlas,
    derive: DeriveColoursPass,
}

impl PageAtlas {
    /// An atlas of `columns` x `rows` slots for pages of so many texels a side, gutter counted, that arrive in
    /// `format`.
    ///
    /// # Errors
    /// [`RenderError::CacheTooLarge`] where it is larger than textures can be.
    pub fn new(
        gpu: &GpuContext,
        (columns, rows): (u32, u32),
        tile_texels: u32,
        format: ColourFormat,
    ) -> Result<Self, RenderError> {
        let most_texels = gpu.device.limits().max_texture_dimension_2d;
        if u64::from(columns.max(rows)) * u64::from(tile_texels) > u64::from(most_texels) {
            return Err(RenderError::CacheTooLarge { columns, rows, tile_texels, most_texels });
        }
        let grid = AtlasGrid { columns, rows, slot_size_texels: tile_texels };
        let colours = ColourAtlas::new(&gpu.device, grid, format);
        Ok(Self { derive: DeriveColoursPass::new(&gpu.device, &colours), colours })
    }

    /// How the atlas is cut.
    pub fn grid(&self) -> &AtlasGrid {
        &self.colours.grid
    }

    /// The pages and their mips as shaders sample them.
    pub fn view(&self) -> wgpu::TextureView {
        self.colours.colours.create_view(&Default::default())
    }

    /// One mip of them, to be looked at.
    pub fn mip(&self, mip: u32) -> wgpu::TextureView {
        self.colours.mip(mip)
    }

    /// Writes pages into the slots given with them and derives their mips; returns the bytes sent.
    pub fn upload(
        &self,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        pages: &[(u32, &ColourTile)],
    ) -> u64 {
        let sent = pages.iter().map(|(slot, page)| self.colours.upload(queue, *slot, page)).sum();
        let slots = pages.iter().map(|(slot, _)| *slot).collect::<Vec<_>>();
        self.derive.record(encoder, &self.colours, &slots);
        sent
    }
}
