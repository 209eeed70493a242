//! Tiles in atlases on the GPU, the tables that find them, and the uniforms they are drawn with: what
//! methods have in common that keep tiles, whatever mesh they draw.

use super::{FrameContext, SceneState};
use crate::dataset::{ColourFormat, ColourTile, HeightTile};
use crate::frame_setup::frame_uniforms;
use crate::gpu::{FrameBindings, FrameUniforms, GpuContext, TerrainCache};
use crate::measure::ByteCause;
use crate::residency::{OffsetTable, Placement};
use crate::selection::TileTree;
use crate::terrain_renderer::RenderError;

/// The caches of a tree's layers, and how shaders see them.
pub(super) struct CachedTiles {
    pub cache: TerrainCache,
    pub bindings: FrameBindings,
}

/// Makes caches of the tree's layers, of so many columns and rows of slots.
pub(super) type MakeCache = fn(&GpuContext, &TileTree, ColourFormat, (u32, u32)) -> TerrainCache;

impl CachedTiles {
    /// Makes caches of the settings' size, colours arriving in `format`.
    ///
    /// # Errors
    /// [`RenderError::CacheTooLarge`] where the caches are larger than textures can be.
    pub fn new(
        cx: &FrameContext<'_>,
        tree: &TileTree,
        format: ColourFormat,
        make: MakeCache,
    ) -> Result<Self, RenderError> {
        let slots = (cx.settings.cache_columns, cx.settings.cache_rows);
        check_cache_fits(cx.gpu, tree, slots)?;
        let cache = make(cx.gpu, tree, format, slots);
        let device = &cx.gpu.device;
        let bindings = FrameBindings::new(device, &cache.table, &cache.heights, &cache.colours);
        Ok(Self { cache, bindings })
    }

    /// Brings height tiles into their slots.
    pub fn send_heights(
        &self,
        cx: &mut FrameContext<'_>,
        encoder: &mut wgpu::CommandEncoder,
        tree: &TileTree,
        tiles: &[(Placement, HeightTile)],
    ) {
        let sent = self.cache.upload_heights(cx.gpu, encoder, tree, tiles);
        cx.ledger.add(ByteCause::Dem, sent);
        cx.ledger.add_texels(ByteCause::Dem, tree.heights.layout.stored_texels(tiles.len()));
    }

    /// Brings colour tiles into the slots given with them.
    pub fn send_colours(
        &self,
        cx: &mut FrameContext<'_>,
        encoder: &mut wgpu::CommandEncoder,
        tree: &TileTree,
        tiles: &[(u32, &ColourTile)],
    ) {
        let sent = self.cache.upload_colours(cx.gpu, encoder, tiles);
        cx.ledger.add(ByteCause::Dom, sent);
        if let Some(colours) = &tree.colours {
            cx.ledger.add_texels(ByteCause::Dom, colours.layout.stored_texels(tiles.len()));
        }
    }

    /// The scene's uniforms but for the ranges of the tables.
    pub fn uniforms(&self, tree: &TileTree, scene: &SceneState, scale_m: f64) -> FrameUniforms {
        FrameUniforms {
            height_uv_per_texel: self.cache.heights.grid.uv_per_texel(),
            colour_uv_per_texel: self.cache.colours.grid.uv_per_texel(),
            ..frame_uniforms(&scene.view, tree, &scene.settings, scale_m)
        }
    }

    /// Brings the uniforms to the GPU.
    pub fn set_uniforms(&mut self, cx: &mut FrameContext<'_>, uniforms: &FrameUniforms) {
        let sent = self.bindings.frame.set_uniforms(&cx.gpu.queue, uniforms);
        cx.ledger.add(ByteCause::Uniform, sent);
    }

    /// Brings the tables of heights and colours, as seen from the scene's eye, and the uniforms to the GPU. Without
    /// a table of colours none are looked up.
    pub fn show(
        &mut self,
        cx: &mut FrameContext<'_>,
        tree: &TileTree,
        (scene, scale_m): (&SceneState, f64),
        (heights, colours): (&OffsetTable, Option<&OffsetTable>),
    ) {
        let eye = scene.view.eye.truncate();
        let tables = self.cache.update_tables(cx.gpu, tree, eye, heights, colours);
        cx.ledger.add(ByteCause::Table, tables.sent_bytes);
        if tables.grew {
            self.bindings.rebind(&cx.gpu.device, &self.cache.table);
        }
        let mut uniforms = self.uniforms(tree, scene, scale_m);
        [uniforms.height_table, uniforms.colour_table] = tables.ranges;
        if colours.is_none() {
            uniforms.has_colours = 0;
        }
        self.set_uniforms(cx, &uniforms);
    }
}

/// The tiles and the slots they are placed in.
pub(super) fn in_slots(placed: &[(Placement, ColourTile)]) -> Vec<(u32, &ColourTile)> {
    placed.iter().map(|(placement, tile)| (placement.slot, tile)).collect()
}

/// Whether the textures of the caches are no larger than the device can make them.
fn check_cache_fits(
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
