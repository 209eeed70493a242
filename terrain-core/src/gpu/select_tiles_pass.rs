use super::displace_pass::{bind_buffers, storage_layout};
use super::seen_ground_buffer::SeenGroundBuffer;
use super::shader_library::{LIST_TILES, MERGE_TILES, RANK_TILES, SUBDIVIDE_TILES, Shader};
use crate::selection::LISTED_AT_MOST;

/// Steps 2 to 4 of tile scheduling's selection, as [`select()`](crate::selection::select()) does them:
/// four dispatches of one workgroup each, that leave the selection in a buffer.
pub(super) struct SelectTilesPass {
    /// Subdivision; the order of merging; regularisation and merging; the list.
    pipelines: [wgpu::ComputePipeline; 4],
    groups: [wgpu::BindGroup; 2],
    /// `selected_tiles` of `common/tile_arena.wgsl`.
    pub selected: wgpu::Buffer,
}

impl SelectTilesPass {
    /// Nodes that subdivision can make: the last tile it splits adds up to four.
    const MOST_NODES: u64 = LISTED_AT_MOST as u64 + 4;
    /// Bytes of a node of the arena, of what stands before the nodes, and of the lists beside it.
    pub const NODE_BYTES: u64 = 64;
    pub const ARENA_HEAD_BYTES: u64 = 144;
    pub const LISTS_BYTES: u64 = 4 * (131_072 + 131_080);
    /// Words before the tiles of a selection, and words a tile.
    pub const SELECTED_HEAD_WORDS: usize = 8;
    pub const SELECTED_TILE_WORDS: usize = 4;

    /// `runs`: [`presence_buffer`](super::tile_presence::presence_buffer). `params` and `heights`: the `params` and `height_units` of `common/selection.wgsl`. Selections have
    /// at most `most_tiles`; farther ones are left out.
    pub fn new(
        device: &wgpu::Device,
        runs: &wgpu::Buffer,
        (params, heights): (&wgpu::Buffer, &wgpu::Buffer),
        seen: &SeenGroundBuffer,
        most_tiles: usize,
    ) -> Self {
        let words = Self::SELECTED_HEAD_WORDS + Self::SELECTED_TILE_WORDS * most_tiles;
        let buffer = |label, size| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            })
        };
        let arena_bytes = Self::ARENA_HEAD_BYTES + Self::NODE_BYTES * Self::MOST_NODES;
        let arena = buffer("tile arena", arena_bytes);
        let lists = buffer("tile lists", Self::LISTS_BYTES);
        let selected = buffer("selected tiles", 4 * words as u64);
        let layouts = [
            storage_layout(device, "select tiles", &[true, true, true, false, false, false]),
            storage_layout(device, "tile runs", &[true]),
        ];
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("select tiles"),
            bind_group_layouts: &[Some(&layouts[0]), Some(&layouts[1])],
            immediate_size: 0,
        });
        let buffers = [params, heights, &seen.buffer, &arena, &lists, &selected];
        let stages = [&SUBDIVIDE_TILES, &RANK_TILES, &MERGE_TILES, &LIST_TILES];
        Self {
            pipelines: stages.map(|shader| pipeline(device, &layout, shader)),
            groups: [
                bind_buffers(device, &layouts[0], &buffers),
                bind_buffers(device, &layouts[1], &[runs]),
            ],
            selected,
        }
    }

    /// Records the stages in order.
    pub fn record(&self, pass: &mut wgpu::ComputePass<'_>) {
        for (index, group) in (0..).zip(&self.groups) {
            pass.set_bind_group(index, group, &[]);
        }
        for pipeline in &self.pipelines {
            pass.set_pipeline(pipeline);
            pass.dispatch_workgroups(1, 1, 1);
        }
    }
}

fn pipeline(
    device: &wgpu::Device,
    layout: &wgpu::PipelineLayout,
    shader: &Shader,
) -> wgpu::ComputePipeline {
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(shader.name),
        layout: Some(layout),
        module: &shader.module(device),
        entry_point: Some(shader.name),
        compilation_options: Default::default(),
        cache: None,
    })
}
