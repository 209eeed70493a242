use super::frame_bindings::FrameBindings;
use super::ground_pipeline::flag;
use super::mesh_buffers::MeshBuffers;
use super::shader_library::DISPLACE;

/// Displaces the visible blocks of a mesh by the cached heights.
pub(crate) struct DisplacePass {
    pipeline: wgpu::ComputePipeline,
    mesh_layout: wgpu::BindGroupLayout,
}

impl DisplacePass {
    const WORKGROUP: u32 = 64;

    pub fn new(device: &wgpu::Device, bindings: &FrameBindings, linear_lookup: bool) -> Self {
        let mesh_layout = storage_layout(device, "mesh", &[true, true, true, false]);
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("displace"),
            bind_group_layouts: &[
                Some(&bindings.frame.layout),
                Some(&bindings.terrain_layout),
                Some(&mesh_layout),
            ],
            immediate_size: 0,
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("displace"),
            layout: Some(&layout),
            module: &DISPLACE.module(device),
            entry_point: Some("displace"),
            compilation_options: wgpu::PipelineCompilationOptions {
                constants: &[("LINEAR_LOOKUP", flag(linear_lookup))],
                ..Default::default()
            },
            cache: None,
        });
        Self { pipeline, mesh_layout }
    }

    /// The bindings of one mesh.
    pub fn bind_mesh(&self, device: &wgpu::Device, mesh: &MeshBuffers) -> wgpu::BindGroup {
        let buffers = [&mesh.vertices, &mesh.blocks, &mesh.visible_blocks, &mesh.displaced];
        bind_buffers(device, &self.mesh_layout, &buffers)
    }

    /// Records the displacement of the first `visible_count` blocks of the mesh's visible list.
    pub fn record(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        bindings: &FrameBindings,
        mesh: &MeshBuffers,
        mesh_bindings: &wgpu::BindGroup,
        visible_count: u32,
    ) {
        if visible_count == 0 {
            return;
        }
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &bindings.frame.group, &[]);
        pass.set_bind_group(1, &bindings.terrain, &[]);
        pass.set_bind_group(2, mesh_bindings, &[]);
        let groups = mesh.max_block_vertices.div_ceil(Self::WORKGROUP);
        pass.dispatch_workgroups(groups, visible_count, 1);
    }
}

/// A layout of storage buffers for compute, read-only or not.
pub(super) fn storage_layout(
    device: &wgpu::Device,
    label: &str,
    read_only: &[bool],
) -> wgpu::BindGroupLayout {
    let entries =
        read_only.iter().zip(0..).map(|(&read_only, binding)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Storage { read_only },
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        });
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some(label),
        entries: &entries.collect::<Vec<_>>(),
    })
}

/// Binds whole buffers, numbered in their order.
pub(super) fn bind_buffers(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    buffers: &[&wgpu::Buffer],
) -> wgpu::BindGroup {
    let entries = (0..)
        .zip(buffers)
        .map(|(binding, buffer)| wgpu::BindGroupEntry {
            binding,
            resource: buffer.as_entire_binding(),
        })
        .collect::<Vec<_>>();
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
}
