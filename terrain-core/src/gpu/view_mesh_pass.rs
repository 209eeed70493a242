use super::coordinate_pass::{CoordinatePass, draw_full_coordinates};
use super::frame_bindings::FrameBindings;
use super::ground_pipeline::{SurfaceOptions, flag, polygon_mode, surface_pipeline};
use super::picture::TargetKind;
use super::shader_library::{VIEW_MESH, VIEW_MESH_COORDINATES};
use super::view_mesh_buffers::ViewMeshBuffers;
use crate::renderer_settings::DebugView;

/// What decides how the pipeline of a mesh made on the CPU is built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ViewMeshPassSettings {
    pub target: TargetKind,
    pub linear_lookup: bool,
    pub wireframe: bool,
    pub has_colours: bool,
    /// Whether there is ground without data, which is then left out of the picture.
    pub has_voids: bool,
    pub anisotropy: u32,
    pub debug_view: DebugView,
}

/// Draws a mesh made on the CPU.
pub(crate) struct ViewMeshPass {
    pipeline: wgpu::RenderPipeline,
}

impl ViewMeshPass {
    /// `wireframe` needs the device's line mode and is ignored where there is none.
    pub fn new(
        device: &wgpu::Device,
        bindings: &FrameBindings,
        settings: ViewMeshPassSettings,
    ) -> Self {
        let constants = [
            ("LINEAR_LOOKUP", flag(settings.linear_lookup)),
            ("HAS_COLOURS", flag(settings.has_colours)),
            ("HAS_VOIDS", flag(settings.has_voids)),
            ("MULTISAMPLED", flag(settings.target.samples > 1)),
            ("ANISOTROPY", f64::from(settings.anisotropy)),
            ("DEBUG_VIEW", f64::from(settings.debug_view.code())),
        ];
        let options = SurfaceOptions {
            groups: &bindings.layouts(),
            vertices: ViewMeshBuffers::vertex_layout(),
            target: settings.target,
            constants: &constants,
            polygon_mode: polygon_mode(device, settings.wireframe),
        };
        let entries = ("ground_vertex", "ground_fragment");
        Self { pipeline: surface_pipeline(device, &VIEW_MESH, entries, &options) }
    }

    /// Draws so many triangles.
    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        bindings: &FrameBindings,
        buffers: &ViewMeshBuffers,
        triangles: usize,
    ) {
        pass.set_pipeline(&self.pipeline);
        draw_triangles(pass, bindings, buffers, triangles);
    }
}

/// Draws where on the ground each pixel looks, in the format that measurement reads back.
pub(crate) fn draw_view_mesh_coordinates(
    device: &wgpu::Device,
    encoder: &mut wgpu::CommandEncoder,
    bindings: &FrameBindings,
    (buffers, triangles): (&ViewMeshBuffers, usize),
    size_px: [u32; 2],
) -> wgpu::Texture {
    let options = SurfaceOptions {
        groups: &bindings.layouts(),
        vertices: ViewMeshBuffers::vertex_layout(),
        // A mean of places on either side of an edge would be a place on neither.
        target: TargetKind { format: CoordinatePass::FULL_FORMAT, samples: 1 },
        constants: &[],
        polygon_mode: wgpu::PolygonMode::Fill,
    };
    let entries = ("place_vertex", "place_fragment");
    let pipeline = surface_pipeline(device, &VIEW_MESH_COORDINATES, entries, &options);
    draw_full_coordinates(device, encoder, size_px, |pass| {
        pass.set_pipeline(&pipeline);
        draw_triangles(pass, bindings, buffers, triangles);
    })
}

fn draw_triangles(
    pass: &mut wgpu::RenderPass<'_>,
    bindings: &FrameBindings,
    buffers: &ViewMeshBuffers,
    triangles: usize,
) {
    pass.set_bind_group(0, &bindings.frame.group, &[]);
    pass.set_bind_group(1, &bindings.terrain, &[]);
    pass.set_vertex_buffer(0, buffers.vertices.slice(..));
    pass.set_index_buffer(buffers.indices.slice(..), wgpu::IndexFormat::Uint32);
    pass.draw_indexed(0..3 * triangles as u32, 0, 0..1);
}
