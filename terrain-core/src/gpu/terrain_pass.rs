use super::DEPTH_FORMAT;
use super::frame_bindings::FrameBindings;
use super::mesh_buffers::MeshBuffers;
use super::picture::TargetKind;
use super::shader_library::{Shader, TERRAIN};
use crate::renderer_settings::DebugView;
use crate::surface::{CircularMesh, MeshBlock};

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

/// A flag as the value of an `override` constant.
pub(super) fn flag(value: bool) -> f64 {
    f64::from(u8::from(value))
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
        let lines =
            settings.wireframe && device.features().contains(wgpu::Features::POLYGON_MODE_LINE);
        let mode = if lines { wgpu::PolygonMode::Line } else { wgpu::PolygonMode::Fill };
        let constants = settings.constants();
        let pipeline = |entries| {
            let options = SurfaceOptions {
                target: settings.target,
                constants: &constants,
                polygon_mode: mode,
            };
            surface_pipeline(device, bindings, &TERRAIN, entries, &options)
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

/// What a pipeline that draws displaced vertices draws into, and how.
pub(super) struct SurfaceOptions<'a> {
    pub target: TargetKind,
    /// Values of the shader's `override` constants.
    pub constants: &'a [(&'a str, f64)],
    pub polygon_mode: wgpu::PolygonMode,
}

/// A pipeline that draws displaced vertices: shared by the picture and the coordinate pass.
pub(super) fn surface_pipeline(
    device: &wgpu::Device,
    bindings: &FrameBindings,
    shader: &Shader,
    (vertex_entry, fragment_entry): (&str, &str),
    options: &SurfaceOptions<'_>,
) -> wgpu::RenderPipeline {
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(shader.name),
        bind_group_layouts: &[Some(&bindings.frame.layout), Some(&bindings.terrain_layout)],
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
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: MeshBuffers::VERTEX_BYTES,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &MeshBuffers::ATTRIBUTES,
            })],
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
    let ranges = visible.iter().filter_map(|&block| mesh.blocks.get(block as usize));
    for run in joined(ranges) {
        pass.draw_indexed(run, 0, 0..1);
    }
}

/// The blocks' index ranges, those that touch joined.
fn joined<'a>(
    blocks: impl Iterator<Item = &'a MeshBlock>,
) -> impl Iterator<Item = std::ops::Range<u32>> {
    let mut runs: Vec<std::ops::Range<u32>> = Vec::new();
    for block in blocks {
        let end = block.index_start + block.index_count;
        match runs.last_mut() {
            Some(run) if run.end == block.index_start => run.end = end,
            _ => runs.push(block.index_start..end),
        }
    }
    runs.into_iter()
}
