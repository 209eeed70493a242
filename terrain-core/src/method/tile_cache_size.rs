use crate::gpu::GpuContext;
use crate::selection::TileTree;
use crate::terrain_renderer::RenderError;

/// Whether the textures of the caches are no larger than the device can make them.
pub(in crate::method) fn check_cache_fits(
    gpu: &GpuContext,
    tree: &TileTree,
    (columns, rows): (u32, u32),
) -> Result<(), RenderError> {
    let most_texels = gpu.device.limits().max_texture_dimension_2d;
    let layers = std::iter::once(&tree.heights).chain(&tree.colours);
    let tile_texels = layers.map(|layer| layer.layout.stored_size_texels()).max().unwrap_or(0);
    if u64::from(columns.max(rows)) * u64::from(tile_texels) > u64::from(most_texels) {
        return Err(RenderError::CacheTooLarge { columns, rows, tile_texels, most_texels });
    }
    Ok(())
}
