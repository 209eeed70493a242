use super::depth_pyramid::DepthPyramid;
use super::map_pass::{MapTriangles, TextureMapUniforms};
use crate::gpu::ground_pipeline::{SurfaceOptions, flag, surface_pipeline};
use crate::gpu::mesh_buffers::MeshBuffers;
use crate::gpu::page_table::{PageGroundBindings, PageGroundGroup};
use crate::gpu::picture::TargetKind;
use crate::gpu::shader_library::PAGE_REQUESTS;
use crate::gpu::terrain_pass::{draw_blocks, index_runs};
use crate::surface::CircularMesh;

/// The displaced mesh as triangles for the texture map: group 3 of the map's passes, as `common/map_ground.wgsl`
/// and `common/texture_map.wgsl` name its bindings.
pub(crate) struct GroundTriangles {
    pub layout: wgpu::BindGroupLayout,
    uniforms: wgpu::Buffer,
    written: Option<TextureMapUniforms>,
}

impl GroundTriangles {
    pub fn new(device: &wgpu::Device) -> Self {
        let uniforms = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("texture map"),
            size: size_of::<TextureMapUniforms>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Self { layout: group_layout(device), uniforms, written: None }
    }

    /// Writes the map's uniforms; returns the bytes sent, 0 where nothing changed.
    pub fn set(&mut self, queue: &wgpu::Queue, uniforms: &TextureMapUniforms) -> u64 {
        if self.written.as_ref() == Some(uniforms) {
            return 0;
        }
        queue.write_buffer(&self.uniforms, 0, bytemuck::bytes_of(uniforms));
        self.written = Some(*uniforms);
        size_of::<TextureMapUniforms>() as u64
    }

    /// The visible triangles of a mesh.
    pub fn of_mesh(
        (mesh, buffers): (&CircularMesh, &MeshBuffers),
        visible: &[u32],
    ) -> MapTriangles {
        let runs = index_runs(mesh, visible).map(|run| run.start / 3..run.end / 3).collect();
        let longest_range = buffers.max_block_triangles;
        MapTriangles { runs, ranges: visible.len() as u32, longest_range }
    }

    /// The group over a mesh and the depth of its scene.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        ground: &PageGroundGroup,
        mesh: &MeshBuffers,
        depth: &DepthPyramid,
    ) -> wgpu::BindGroup {
        let resources = [
            ground.buffer.as_entire_binding(),
            mesh.displaced.as_entire_binding(),
            mesh.indices.as_entire_binding(),
            mesh.blocks.as_entire_binding(),
            mesh.visible_blocks.as_entire_binding(),
            self.uniforms.as_entire_binding(),
            depth.farthest().as_entire_binding(),
        ];
        let bound = (0..).zip(resources);
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("ground triangles"),
            layout: &self.layout,
            entries: &bound
                .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
                .collect::<Vec<_>>(),
        })
    }
}

fn group_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::VERTEX_FRAGMENT | wgpu::ShaderStages::COMPUTE,
        ty,
        count: None,
    };
    let buffer =
        |ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
    let storage = || buffer(wgpu::BufferBindingType::Storage { read_only: true });
    let uniform = || buffer(wgpu::BufferBindingType::Uniform);
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("ground triangles"),
        entries: &[
            entry(0, uniform()),
            entry(1, storage()),
            entry(2, storage()),
            entry(3, storage()),
            entry(4, storage()),
            entry(5, uniform()),
            entry(6, storage()),
        ],
    })
}

/// Draws the depth of the displaced mesh.
pub(crate) struct GroundDepthPass {
    pipeline: wgpu::RenderPipeline,
}

impl GroundDepthPass {
    pub fn new(
        device: &wgpu::Device,
        bindings: PageGroundBindings<'_>,
        (linear_lookup, has_voids): (bool, bool),
    ) -> Self {
        let options = SurfaceOptions {
            groups: &bindings.layouts(),
            vertices: MeshBuffers::vertex_layout(),
            target: TargetKind { format: DepthPyramid::FORMAT, samples: 1 },
            constants: &[("LINEAR_LOOKUP", flag(linear_lookup)), ("HAS_VOIDS", flag(has_voids))],
            polygon_mode: wgpu::PolygonMode::Fill,
        };
        let entries = ("request_vertex", "depth_fragment");
        Self { pipeline: surface_pipeline(device, &PAGE_REQUESTS, entries, &options) }
    }

    /// Draws the visible blocks of the mesh.
    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        bindings: PageGroundBindings<'_>,
        mesh: (&CircularMesh, &MeshBuffers),
        visible: &[u32],
    ) {
        bindings.set(pass);
        pass.set_pipeline(&self.pipeline);
        draw_blocks(pass, bindings.frame, mesh, &mesh.1.indices, visible);
    }
}
