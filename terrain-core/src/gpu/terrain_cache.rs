use glam::DVec2;

use super::atlas::AtlasGrid;
use super::colour_atlas::ColourAtlas;
use super::context::GpuContext;
use super::derive_colours_pass::DeriveColoursPass;
use super::derive_heights_pass::{DeriveHeightsPass, HeightUpload};
use super::height_atlas::HeightAtlas;
use super::offset_table_buffer::{OffsetTableBuffer, TableSource, TableUpdate, ToldFrom};
use crate::dataset::{ColourFormat, ColourTile, HeightTile};
use crate::residency::{OffsetTable, Placement};
use crate::selection::TileTree;

/// The cached tiles on the GPU: the atlases of both layers, what is derived from them, and the
/// tables that say which tile lies where.
pub(crate) struct TerrainCache {
    pub heights: HeightAtlas,
    pub colours: ColourAtlas,
    pub table: OffsetTableBuffer,
    derive_heights: DeriveHeightsPass,
    derive_colours: DeriveColoursPass,
}

impl TerrainCache {
    /// Atlases of `columns` x `rows` slots. Without a colour layer its atlas is a stub of one slot.
    pub fn new(
        gpu: &GpuContext,
        tree: &TileTree,
        colour_format: ColourFormat,
        slots: (u32, u32),
    ) -> Self {
        let colour_slots = if tree.colours.is_some() { slots } else { (1, 1) };
        Self::with_slots(gpu, tree, colour_format, [slots, colour_slots])
    }

    /// [`Self::new`] for a method that keeps heights elsewhere: theirs is a stub of one slot.
    pub fn of_colours(
        gpu: &GpuContext,
        tree: &TileTree,
        colour_format: ColourFormat,
        slots: (u32, u32),
    ) -> Self {
        Self::with_slots(gpu, tree, colour_format, [(1, 1), slots])
    }

    /// [`Self::new`] for a method that keeps colours elsewhere: theirs is a stub of one slot.
    pub fn of_heights(
        gpu: &GpuContext,
        tree: &TileTree,
        colour_format: ColourFormat,
        slots: (u32, u32),
    ) -> Self {
        Self::with_slots(gpu, tree, colour_format, [slots, (1, 1)])
    }

    fn with_slots(
        gpu: &GpuContext,
        tree: &TileTree,
        colour_format: ColourFormat,
        [height_slots, colour_slots]: [(u32, u32); 2],
    ) -> Self {
        let grid =
            |(columns, rows), slot_size_texels| AtlasGrid { columns, rows, slot_size_texels };
        let height_grid = grid(height_slots, tree.heights.layout.stored_size_texels());
        let colour_texels = tree.colours.as_ref().map_or(16, |l| l.layout.stored_size_texels());
        let colour_grid = grid(colour_slots, colour_texels);
        let heights = HeightAtlas::new(&gpu.device, height_grid);
        let colours = ColourAtlas::new(&gpu.device, colour_grid, colour_format);
        Self {
            derive_heights: DeriveHeightsPass::new(&gpu.device, &heights),
            derive_colours: DeriveColoursPass::new(&gpu.device, &colours),
            table: OffsetTableBuffer::new(&gpu.device),
            heights,
            colours,
        }
    }

    /// Writes height tiles into their slots; returns the bytes sent.
    pub fn upload_heights(
        &self,
        gpu: &GpuContext,
        encoder: &mut wgpu::CommandEncoder,
        tree: &TileTree,
        tiles: &[(Placement, HeightTile)],
    ) -> u64 {
        let uploads = tiles
            .iter()
            .map(|(placement, tile)| HeightUpload {
                tile,
                slot: placement.slot,
                texel_size_m: tree.heights.layout.texel_size_m(&tree.scheme, tile.id.level),
            })
            .collect::<Vec<_>>();
        self.derive_heights.record(&gpu.device, encoder, &self.heights, &uploads)
    }

    /// Writes colour tiles into the slots given with them; returns the bytes sent.
    pub fn upload_colours(
        &self,
        gpu: &GpuContext,
        encoder: &mut wgpu::CommandEncoder,
        tiles: &[(u32, &ColourTile)],
    ) -> u64 {
        let sent =
            tiles.iter().map(|(slot, tile)| self.colours.upload(&gpu.queue, *slot, tile)).sum();
        let slots = tiles.iter().map(|(slot, _)| *slot).collect::<Vec<_>>();
        self.derive_colours.record(encoder, &self.colours, &slots);
        sent
    }

    /// Brings the tables of both layers to the GPU, relative to the eye.
    pub fn update_tables(
        &mut self,
        gpu: &GpuContext,
        tree: &TileTree,
        eye: DVec2,
        heights: &OffsetTable,
        colours: Option<&OffsetTable>,
    ) -> TableUpdate {
        let heights = TableSource {
            table: heights,
            layout: tree.heights.layout,
            grid: self.heights.grid,
            told_from: ToldFrom::NearEye,
        };
        // Imagery gains nothing: filters of textures divide a texel into 256 parts at the most.
        let colours = colours.zip(tree.colours.as_ref()).map(|(table, layer)| TableSource {
            table,
            layout: layer.layout,
            grid: self.colours.grid,
            told_from: ToldFrom::Corner,
        });
        self.table.update(
            (&gpu.device, &gpu.queue),
            &tree.scheme,
            eye,
            [Some(&heights), colours.as_ref()],
        )
    }
}
