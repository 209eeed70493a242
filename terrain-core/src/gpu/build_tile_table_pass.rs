use bytemuck::{Pod, Zeroable};
use wgpu::util::DeviceExt;

use super::compute_pipeline::{bind_group, compute_pipeline};
use super::manage_tiles_pass::ManageTilesPass;
use super::shader_library::BUILD_TILE_TABLE;
use crate::tiling::MAX_LEVEL;

/// The twin of `TableSpace` in `build_tile_table.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct TableSpace {
    pub entries: u32,
    pub nodes: u32,
}

impl TableSpace {
    /// Room for the table of a layer of so many slots, whatever tiles they hold: a node for each level
    /// above a tile, but the root's only once.
    pub fn of_slots(slot_count: u32) -> Self {
        let nodes = slot_count * u32::from(MAX_LEVEL - 1) + 1;
        Self { entries: slot_count, nodes: 4 * nodes }
    }
}

/// Builds the offset tables of both layers, and the quadtrees over them, on the GPU.
pub(crate) struct BuildTileTablePass {
    pipeline: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
    /// The tables' ranges, then their tiles.
    pub(super) table: wgpu::Buffer,
}

impl BuildTileTablePass {
    /// Bytes of the two ranges at the beginning of the table.
    pub const RANGES_BYTES: u64 = 32;

    /// A builder that reads what [`ManageTilesPass`] shows and writes the quadtrees into `nodes`, which
    /// has room for both layers.
    pub fn new(
        device: &wgpu::Device,
        space: TableSpace,
        manage: &ManageTilesPass,
        nodes: &wgpu::Buffer,
    ) -> Self {
        let pipeline = compute_pipeline(device, &BUILD_TILE_TABLE);
        let space = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("table space"),
            contents: bytemuck::bytes_of(&space),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let storage = |label, size| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            })
        };
        let most = u64::from(ManageTilesPass::MOST_SLOTS);
        let table = storage("tile table", Self::RANGES_BYTES + 2 * 16 * most);
        let walk = storage("tile walk", 2 * 12 * most);
        let buffers = [&space, &manage.shown, &table, &walk, nodes];
        let group = bind_group(device, &pipeline, 0, &buffers);
        Self { pipeline, group, table }
    }

    /// Records the pass for so many layers.
    pub fn record(&self, pass: &mut wgpu::ComputePass<'_>, layers: u32) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        pass.dispatch_workgroups(layers, 1, 1);
    }
}
