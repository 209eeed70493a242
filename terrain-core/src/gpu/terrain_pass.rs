use std::ops::Range;

use super::frame_bindings::FrameBindings;
use super::ground_pipeline::{SurfaceOptions, flag, polygon_mode, surface_pipeline};
use super::mesh_buffers::MeshBuffers;
use super::picture::TargetKind;
use super::shader_library::TERRAIN;
use crate::renderer_settings::DebugView;
use crate::surface::CircularMesh;

/// What decides how the terrain's pipeline is built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TerrainPassSettings {
    pub target: TargetKind,
    pub linear_lookup: bool,
    pub wireframe: bool,
    pub has_colours: bool,
    /// Whether there is ground without data, which is then left out of the picture. Without, hidden
    /// ground is not even shaded.
    pub has_voids: bool,
    pub anisotropy: u32,
    /// Whether triangles within a tile are drawn apart from those across a border, which is quicker; not
    /// for a picture that shows what only a lookup tells.
    pub sorts_triangles: bool,
    pub debug_view: DebugView,
}

impl TerrainPassSettings {
    /// The values of the shader's `override` constants.
    fn constants(&self) -> [(&'static str, f64); 6] {
        [
            ("LINEAR_LOOKUP", flag(self.linear_lookup)),
            ("HAS_COLOURS", flag(self.has_colours)),
            ("HAS_VOIDS", flag(self.has_voids)),
            ("MULTISAMPLED", flag(self.target.samples > 1)),
            ("ANISOTROPY", f64::from(self.anisotropy)),
            ("DEBUG_VIEW", f64::from(self.debug_view.code())),
        ]
    }
}

/// Draws the displaced mesh.
pub(crate) struct TerrainPass {
    /// For triangles within one tile of each layer: most of them, and the fragments look nothing up.
    /// `None` where triangles are not sorted; then all are drawn as if across.
    within: Option<wgpu::RenderPipeline>,
    /// For triangles across the border of tiles.
    across: wgpu::RenderPipeline,
}

impl TerrainPass {
    /// `wireframe` needs the device's line mode and is ignored where there is none.
    pub fn new(
        device: &wgpu::Device,
        bindings: &FrameBindings,
        settings: TerrainPassSettings,
    ) -> Self {
        let mode = polygon_mode(device, settings.wireframe);
        let constants = settings.constants();
        let pipeline = |entries| {
            let options = SurfaceOptions {
                groups: &bindings.layouts(),
                vertices: MeshBuffers::vertex_layout(),
                target: settings.target,
                constants: &constants,
                polygon_mode: mode,
            };
            surface_pipeline(device, &TERRAIN, entries, &options)
        };
        Self {
            within: settings
                .sorts_triangles
                .then(|| pipeline(("vertex_within", "fragment_within"))),
            across: pipeline(("vertex_across", "fragment_across")),
        }
    }

    /// Draws the visible blocks of the mesh.
    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        bindings: &FrameBindings,
        (mesh, buffers): (&CircularMesh, &MeshBuffers),
        visible: &[u32],
    ) {
        let mut draw = |pipeline, indices| {
            pass.set_pipeline(pipeline);
            draw_blocks(pass, bindings, (mesh, buffers), indices, visible);
        };
        match &self.within {
            Some(within) => {
                draw(within, &buffers.indices_within);
                draw(&self.across, &buffers.indices_across);
            }
            None => draw(&self.across, &buffers.indices),
        }
    }
}

/// Draws the visible blocks, whose triangles `indices` lists, with the pipeline that is set. Blocks that follow one another in the
/// index buffer are drawn together.
pub(super) fn draw_blocks(
    pass: &mut wgpu::RenderPass<'_>,
    bindings: &FrameBindings,
    (mesh, buffers): (&CircularMesh, &MeshBuffers),
    indices: &wgpu::Buffer,
    visible: &[u32],
) {
    pass.set_bind_group(0, &bindings.frame.group, &[]);
    pass.set_bind_group(1, &bindings.terrain, &[]);
    pass.set_vertex_buffer(0, buffers.displaced.slice(..));
    pass.set_index_buffer(indices.slice(..), wgpu::IndexFormat::Uint32);
    for run in index_runs(mesh, visible) {
        pass.draw_indexed(run, 0, 0..1);
    }
}

/// The visible blocks' ranges of indices, those that touch joined.
pub(super) fn index_runs(
    mesh: &CircularMesh,
    visible: &[u32],
) -> impl Iterator<Item = Range<u32>> + use<> {
    let blocks = visible.iter().filter_map(|&block| mesh.blocks.get(block as usize));
    let mut runs: Vec<Range<u32>> = Vec::new();
    for block in blocks {
        let end = block.index_start + block.index_count;
        match runs.last_mut() {
            Some(run) if run.end == block.index_start => run.end = end,
            _ => runs.push(block.index_start..end),
        }
    }
    runs.into_iter()
}
