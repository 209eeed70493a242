//! Pipelines that draw the ground into a picture or a texture of coordinates, whatever its mesh.

use super::DEPTH_FORMAT;
use super::picture::TargetKind;
use super::shader_library::Shader;

/// A flag as the value of an `override` constant.
pub(super) fn flag(value: bool) -> f64 {
    f64::from(u8::from(value))
}

/// Edges where they are wanted and the device has a line mode, else faces.
pub(super) fn polygon_mode(device: &wgpu::Device, wireframe: bool) -> wgpu::PolygonMode {
    let lines = wireframe && device.features().contains(wgpu::Features::POLYGON_MODE_LINE);
    if lines { wgpu::PolygonMode::Line } else { wgpu::PolygonMode::Fill }
}

/// What a pipeline that draws the ground reads and draws into, and how.
pub(super) struct SurfaceOptions<'a> {
    /// The groups from 0 on.
    pub groups: &'a [&'a wgpu::BindGroupLayout],
    pub vertices: wgpu::VertexBufferLayout<'a>,
    pub target: TargetKind,
    /// Values of the shader's `override` constants.
    pub constants: &'a [(&'a str, f64)],
    pub polygon_mode: wgpu::PolygonMode,
}

/// A pipeline that draws the ground, whatever its mesh: shared by pictures and coordinate passes.
pub(super) fn surface_pipeline(
    device: &wgpu::Device,
    shader: &Shader,
    (vertex_entry, fragment_entry): (&str, &str),
    options: &SurfaceOptions<'_>,
) -> wgpu::RenderPipeline {
    let groups = options.groups.iter().map(|&group| Some(group)).collect::<Vec<_>>();
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(shader.name),
        bind_group_layouts: &groups,
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
            buffers: &[Some(options.vertices.clone())],
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
