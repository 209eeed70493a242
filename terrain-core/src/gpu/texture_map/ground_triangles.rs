use super::depth_pyramid::DepthPyramid;
use super::map_pass::MapTriangles;
use super::scene_map::SceneTriangles;
use crate::gpu::displaced_mesh::DisplacedMesh;
use crate::gpu::ground_pipeline::{SurfaceOptions, flag, surface_pipeline};
use crate::gpu::mesh_buffers::MeshBuffers;
use crate::gpu::page_table::{PageGroundBindings, PageGroundGroup};
use crate::gpu::picture::TargetKind;
use crate::gpu::shader_library::PAGE_REQUESTS;
use crate::gpu::terrain_pass::{draw_blocks, index_runs};

/// The visible triangles of the displaced mesh, as `map_ground.wgsl` reads them.
pub(crate) fn ground_triangles<'a>(
    ground: &'a PageGroundGroup,
    drawn: &'a DisplacedMesh,
) -> SceneTriangles<'a> {
    let (mesh, buffers) = drawn.parts();
    let MeshBuffers { displaced, indices, blocks, visible_blocks, .. } = buffers;
    let runs = index_runs(mesh, drawn.visible()).map(|run| run.start / 3..run.end / 3);
    SceneTriangles {
        buffers: [&ground.buffer, displaced, indices, blocks, visible_blocks],
        triangles: MapTriangles {
            runs: runs.collect(),
            ranges: drawn.visible().len() as u32,
            longest_range: buffers.max_block_triangles,
        },
        most: mesh.indices.len() as u32 / 3,
    }
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
        drawn: &DisplacedMesh,
    ) {
        bindings.set(pass);
        pass.set_pipeline(&self.pipeline);
        let mesh = drawn.parts();
        draw_blocks(pass, bindings.frame, mesh, &mesh.1.indices, drawn.visible());
    }
}
