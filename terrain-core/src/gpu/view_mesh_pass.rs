use super::DEPTH_FORMAT;
use super::coordinate_pass::{CoordinatePass, depth_attachment};
use super::frame_bindings::FrameBindings;
use super::picture::TargetKind;
use super::shader_library::{Shader, VIEW_MESH, VIEW_MESH_COORDINATES};
use super::terrain_pass::flag;
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
        let lines =
            settings.wireframe && device.features().contains(wgpu::Features::POLYGON_MODE_LINE);
        let options = PipelineOptions {
            shader: &VIEW_MESH,
            entries: ("ground_vertex", "ground_fragment"),
            target: settings.target,
            constants: &constants,
            mode: if lines { wgpu::PolygonMode::Line } else { wgpu::PolygonMode::Fill },
        };
        Self { pipeline: pipeline(device, bindings, &options) }
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
    [width, height]: [u32; 2],
) -> wgpu::Texture {
    let options = PipelineOptions {
        shader: &VIEW_MESH_COORDINATES,
        entries: ("place_vertex", "place_fragment"),
        // A mean of places on either side of an edge would be a place on neither.
        target: TargetKind { format: CoordinatePass::FULL_FORMAT, samples: 1 },
        constants: &[],
        mode: wgpu::PolygonMode::Fill,
    };
    let pipeline = pipeline(device, bindings, &options);
    let texture = |label, format, usage| {
        device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: usage | wgpu::TextureUsages::RENDER_ATTACHMENT,
            view_formats: &[],
        })
    };
    let target = texture("coordinates", CoordinatePass::FULL_FORMAT, wgpu::TextureUsages::COPY_SRC);
    let depth = texture("coordinate depth", DEPTH_FORMAT, wgpu::TextureUsages::empty());
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("coordinates"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: &target.create_view(&Default::default()),
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                store: wgpu::StoreOp::Store,
            },
        })],
        depth_stencil_attachment: Some(depth_attachment(&depth.create_view(&Default::default()))),
        ..Default::default()
    });
    pass.set_pipeline(&pipeline);
    draw_triangles(&mut pass, bindings, buffers, triangles);
    drop(pass);
    target
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

struct PipelineOptions<'a> {
    shader: &'a Shader,
    /// Entry points of the vertex and the fragment stage.
    entries: (&'a str, &'a str),
    target: TargetKind,
    /// Values of the shader's `override` constants.
    constants: &'a [(&'a str, f64)],
    mode: wgpu::PolygonMode,
}

fn pipeline(
    device: &wgpu::Device,
    bindings: &FrameBindings,
    options: &PipelineOptions<'_>,
) -> wgpu::RenderPipeline {
    let label = Some(options.shader.name);
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label,
        bind_group_layouts: &[Some(&bindings.frame.layout), Some(&bindings.terrain_layout)],
        immediate_size: 0,
    });
    let module = options.shader.module(device);
    let compilation =
        || wgpu::PipelineCompilationOptions { constants: options.constants, ..Default::default() };
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label,
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some(options.entries.0),
            compilation_options: compilation(),
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: ViewMeshBuffers::VERTEX_BYTES,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &ViewMeshBuffers::ATTRIBUTES,
            })],
        },
        primitive: wgpu::PrimitiveState {
            polygon_mode: options.mode,
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
            entry_point: Some(options.entries.1),
            compilation_options: compilation(),
            targets: &[Some(options.target.format.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}
