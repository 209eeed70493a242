use super::displace_pass::{bind_buffers, storage_layout};
use super::mesh_buffers::MeshBuffers;
use super::shader_library::SORT_TRIANGLES;

/// Sorts the displaced triangles into those within one tile of each layer, whose fragments need no
/// lookup, and those across a border.
pub(crate) struct SortTrianglesPass {
    pipeline: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
}

impl SortTrianglesPass {
    const WORKGROUP: u32 = 64;
    /// The group the shader's buffers are in, behind the frame's and the terrain's.
    const GROUP: u32 = 2;

    pub fn new(device: &wgpu::Device) -> Self {
        let read_only = [true, true, true, true, false, false];
        let layout = storage_layout(device, "sort triangles", &read_only);
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("sort triangles"),
            bind_group_layouts: &[None, None, Some(&layout)],
            immediate_size: 0,
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("sort triangles"),
            layout: Some(&pipeline_layout),
            module: &SORT_TRIANGLES.module(device),
            entry_point: Some("sort_triangles"),
            compilation_options: Default::default(),
            cache: None,
        });
        Self { pipeline, layout }
    }

    /// The bindings of one mesh.
    pub fn bind_mesh(&self, device: &wgpu::Device, mesh: &MeshBuffers) -> wgpu::BindGroup {
        let buffers = [
            &mesh.blocks,
            &mesh.visible_blocks,
            &mesh.displaced,
            &mesh.indices,
            &mesh.indices_within,
            &mesh.indices_across,
        ];
        bind_buffers(device, &self.layout, &buffers)
    }

    /// Records the sorting of the first `visible_count` blocks of the mesh's visible list, which
    /// must be displaced before.
    pub fn record(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        mesh: &MeshBuffers,
        mesh_bindings: &wgpu::BindGroup,
        visible_count: u32,
    ) {
        if visible_count == 0 {
            return;
        }
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(Self::GROUP, mesh_bindings, &[]);
        let groups = mesh.max_block_triangles.div_ceil(Self::WORKGROUP);
        pass.dispatch_workgroups(groups, visible_count, 1);
    }
}
