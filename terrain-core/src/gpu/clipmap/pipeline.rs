use super::bindings::ClipBindings;
use super::mesh::ClipMeshBuffers;
use crate::gpu::frame_group::FrameGroup;
use crate::gpu::ground_pipeline::{SurfaceOptions, flag, polygon_mode, surface_pipeline};
use crate::gpu::picture::TargetKind;
use crate::gpu::shader_library::CLIPMAP;
use crate::renderer_settings::DebugView;

/// What decides how the clipmap's pipeline is built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ClipPassSettings {
    pub target: TargetKind,
    pub wireframe: bool,
    pub has_colours: bool,
    /// Whether there is ground without data, which is then left out of the picture.
    pub has_voids: bool,
    pub anisotropy: u32,
    pub debug_view: DebugView,
}

/// Draws the rings into the picture.
pub(crate) struct ClipPass {
    pipeline: wgpu::RenderPipeline,
}

impl ClipPass {
    /// `wireframe` needs the device's line mode and is ignored where there is none.
    pub fn new(
        device: &wgpu::Device,
        frame: &FrameGroup,
        clip: &ClipBindings,
        settings: &ClipPassSettings,
    ) -> Self {
        let constants = [
            ("HAS_COLOURS", flag(settings.has_colours)),
            ("HAS_VOIDS", flag(settings.has_voids)),
            ("MULTISAMPLED", flag(settings.target.samples > 1)),
            ("ANISOTROPY", f64::from(settings.anisotropy)),
            ("DEBUG_VIEW", f64::from(settings.debug_view.code())),
        ];
        let options = SurfaceOptions {
            groups: &[&frame.layout, &clip.layout],
            vertices: ClipMeshBuffers::instance_layout(),
            target: settings.target,
            constants: &constants,
            polygon_mode: polygon_mode(device, settings.wireframe),
        };
        let entries = ("clip_vertex", "clip_fragment");
        Self { pipeline: surface_pipeline(device, &CLIPMAP, entries, &options) }
    }

    /// Draws the blocks in view.
    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        frame: &FrameGroup,
        clip: &ClipBindings,
        mesh: &ClipMeshBuffers,
    ) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &frame.group, &[]);
        pass.set_bind_group(1, &clip.group, &[]);
        mesh.draw(pass);
    }
}
