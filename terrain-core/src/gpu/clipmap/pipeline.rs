use super::bindings::ClipBindings;
use super::mesh::ClipMeshBuffers;
use crate::gpu::DEPTH_FORMAT;
use crate::gpu::frame_group::FrameGroup;
use crate::gpu::picture::TargetKind;
use crate::gpu::shader_library::{CLIPMAP, Shader};
use crate::gpu::terrain_pass::flag;
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
        let lines =
            settings.wireframe && device.features().contains(wgpu::Features::POLYGON_MODE_LINE);
        let constants = [
            ("HAS_COLOURS", flag(settings.has_colours)),
            ("HAS_VOIDS", flag(settings.has_voids)),
            ("MULTISAMPLED", flag(settings.target.samples > 1)),
            ("ANISOTROPY", f64::from(settings.anisotropy)),
            ("DEBUG_VIEW", f64::from(settings.debug_view.code())),
        ];
        let options = ClipPipelineOptions {
            target: settings.target,
            constants: &constants,
            polygon_mode: if lines { wgpu::PolygonMode::Line } else { wgpu::PolygonMode::Fill },
        };
        let entries = ("clip_vertex", "clip_fragment");
        Self { pipeline: clip_pipeline(device, (frame, clip), &CLIPMAP, entries, &options) }
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

/// What a pipeline over the rings draws into, and how.
pub(super) struct ClipPipelineOptions<'a> {
    pub target: TargetKind,
    /// Values of the shader's `override` constants.
    pub constants: &'a [(&'a str, f64)],
    pub polygon_mode: wgpu::PolygonMode,
}

/// A pipeline over the rings: shared by the picture and the coordinates.
pub(super) fn clip_pipeline(
    device: &wgpu::Device,
    (frame, clip): (&FrameGroup, &ClipBindings),
    shader: &Shader,
    (vertex_entry, fragment_entry): (&str, &str),
    options: &ClipPipelineOptions<'_>,
) -> wgpu::RenderPipeline {
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(shader.name),
        bind_group_layouts: &[Some(&frame.layout), Some(&clip.layout)],
        immediate_size: 0,
    });
    let module = shader.module(device);
    let compilation =
        || wgpu::PipelineCompilationOptions { constants: options.constants, ..Default::default() };
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(shader.name),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some(vertex_entry),
            compilation_options: compilation(),
            buffers: &[Some(ClipMeshBuffers::instance_layout())],
        },
        primitive: wgpu::PrimitiveState {
            polygon_mode: options.polygon_mode,
            // What is seen from below lies behind what is seen from above, all but its edges.
            cull_mode: Some(wgpu::Face::Back),
            ..Default::default()
        },
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH_FORMAT,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Greater),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: wgpu::MultisampleState { count: options.target.samples, ..Default::default() },
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some(fragment_entry),
            compilation_options: compilation(),
            targets: &[Some(options.target.format.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}
