use glam::DVec2;

use super::build_tile_table_pass::{BuildTileTablePass, TableSpace};
use super::frame_group::FrameGroup;
use super::manage_tiles_pass::{LayerDeliveries, ManageTilesPass};
use super::offset_table_buffer::{TileEntry, ToldFrom};
use super::place_tiles_pass::{Ground, PlaceTilesPass, PlacedLayer};
use super::terrain_cache::TerrainCache;
use super::tile_report::TileReport;
use crate::selection::TileTree;
use crate::tiling::TilingScheme;

/// What the CPU does for the other strategies with `TileCache` and `OffsetTable`, done on the GPU: slots
/// are assigned, missing tiles listed and the tables of both layers built in compute passes.
pub(crate) struct TileManagement {
    manage: ManageTilesPass,
    build: BuildTileTablePass,
    place: PlaceTilesPass,
    scheme: TilingScheme,
    slot_count: u32,
}

impl TileManagement {
    /// Management of the cache's slots by the selection in `selected`, of the tiles that `runs` tells of; see [`ManageTilesPass::new`].
    /// Gives the cache's table room for all its slots: it is to be bound after this.
    pub fn new(
        device: &wgpu::Device,
        tree: &TileTree,
        cache: &mut TerrainCache,
        (selected, runs): (&wgpu::Buffer, &wgpu::Buffer),
    ) -> Self {
        let grid = cache.heights.grid;
        let slot_count = grid.columns * grid.rows;
        let space = TableSpace::of_slots(slot_count);
        let entries = 2 * u64::from(slot_count) * size_of::<TileEntry>() as u64;
        cache.table.make_room(device, entries, 2 * 4 * u64::from(space.nodes));
        let heights =
            PlacedLayer::new(&tree.scheme, &tree.heights.layout, &grid, ToldFrom::NearEye);
        // Imagery gains nothing from places near the eye: see `TerrainCache::update_tables`.
        let colours = tree.colours.as_ref().map_or_else(PlacedLayer::default, |layer| {
            let grid = &cache.colours.grid;
            PlacedLayer::new(&tree.scheme, &layer.layout, grid, ToldFrom::Corner)
        });
        let ground = Ground::new(&tree.scheme, [heights, colours]);
        let manage = ManageTilesPass::new(device, tree, slot_count, (selected, runs));
        let build = BuildTileTablePass::new(device, space, &manage, &cache.table.nodes);
        let place = PlaceTilesPass::new(device, &ground, &build, &cache.table.entries);
        Self { manage, build, place, scheme: tree.scheme, slot_count }
    }

    /// Records the management of a frame: takes what the CPU has brought, gives the selection's tiles
    /// slots and builds the tables of what is shown. Returns the bytes sent.
    pub fn manage(
        &self,
        queue: &wgpu::Queue,
        pass: &mut wgpu::ComputePass<'_>,
        frame: u32,
        deliveries: &[LayerDeliveries; 2],
    ) -> u64 {
        let sent = self.manage.set_deliveries(queue, frame, deliveries);
        self.manage.record(pass);
        self.build.record(pass, self.manage.layers);
        sent
    }

    /// Records the placing of the tables' tiles as seen from the eye. Returns the bytes sent.
    pub fn place(
        &mut self,
        queue: &wgpu::Queue,
        pass: &mut wgpu::ComputePass<'_>,
        eye: DVec2,
    ) -> u64 {
        let sent = self.place.set_eye(queue, &self.scheme, eye);
        self.place.record(pass, self.manage.layers, self.slot_count);
        sent
    }

    /// The slots of both layers.
    #[cfg(test)]
    pub(super) fn slots(&self) -> &wgpu::Buffer {
        &self.manage.slots
    }

    /// Records the copy of the tables' ranges into the frame's uniforms, behind everything that writes
    /// these.
    pub fn copy_ranges(&self, encoder: &mut wgpu::CommandEncoder, frame: &FrameGroup) {
        frame.copy_table_ranges(encoder, &self.build.table);
    }

    /// Records the copy of the report into `buffer`, of each layer's list so many tiles. Returns the
    /// bytes.
    pub fn copy_report(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        buffer: &wgpu::Buffer,
        listed: [u32; 2],
    ) -> u64 {
        let report = &self.manage.report;
        let mut end = TileReport::HEAD_BYTES;
        encoder.copy_buffer_to_buffer(report, 0, buffer, 0, end);
        for (layer, count) in (0..).zip(listed) {
            let bytes = 8 * u64::from(count);
            let begin = TileReport::HEAD_BYTES + layer * 8 * u64::from(ManageTilesPass::MOST_ASKED);
            if bytes > 0 {
                encoder.copy_buffer_to_buffer(report, begin, buffer, end, bytes);
            }
            end += bytes;
        }
        end
    }
}
