use super::DEPTH_FORMAT;
use super::frame_bindings::FrameBindings;
use super::mesh_buffers::MeshBuffers;
use super::shader_library::{Shader, TERRAIN};
use crate::renderer_settings::DebugView;
use crate::surface::{CircularMesh, MeshBlock};

/// What decides how the terrain's pipeline is built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TerrainPassSettings {
    pub target: wgpu::TextureFormat,
    pub linear_lookup: bool,
    pub wireframe: bool,
    pub has_colours: bool,
    /// Whether there is ground without data, which is then left out of the picture. Without, hidden
    /// ground is not even shaded.
    pub has_voids: bool,
    pub anisotropy: u32,
    pub debug_view: DebugView,
}

impl TerrainPassSettings {
    /// The values of the shader's `override` constants.
    fn constants(&self) -> [(&'static str, f64); 5] {
        [
            ("LINEAR_LOOKUP", flag(self.linear_lookup)),
            ("HAS_COLOURS", flag(self.has_colours)),
            ("HAS_VOIDS", flag(self.has_voids)),
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
    pipeline: wgpu::RenderPipeline,
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
        let entries = ("terrain_vertex", "terrain_fragment");
        let mode = if lines { wgpu::PolygonMode::Line } else { wgpu::PolygonMode::Fill };
        let pipeline = surface_pipeline(
            device,
            bindings,
            &TERRAIN,
            entries,
            (settings.target, &settings.constants(), mode),
        );
        Self { pipeline }
    }

    /// Draws the visible blocks of the mesh.
    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        bindings: &FrameBindings,
        (mesh, buffers): (&CircularMesh, &MeshBuffers),
        visible: &[u32],
    ) {
        pass.set_pipeline(&self.pipeline);
        draw_blocks(pass, bindings, (mesh, buffers), visible);
    }
}

/// A pipeline that draws displaced vertices: shared by the picture and the coordinate pass.
pub(super) fn surface_pipeline(
    device: &wgpu::Device,
    bindings: &FrameBindings,
    shader: &Shader,
    (vertex_entry, fragment_entry): (&str, &str),
    (target, constants, polygon_mode): (wgpu::TextureFormat, &[(&str, f64)], wgpu::PolygonMode),
) -> wgpu::RenderPipeline {
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(shader.name),
        bind_group_layouts: &[Some(&bindings.frame_layout), Some(&bindings.terrain_layout)],
        immediate_size: 0,
    });
    let module = shader.module(device);
    let options = || wgpu::PipelineCompilationOptions { constants, ..Default::default() };
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(shader.name),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some(vertex_entry),
            compilation_options: options(),
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: MeshBuffers::VERTEX_BYTES,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Uint32],
            })],
        },
        primitive: wgpu::PrimitiveState { polygon_mode, ..Default::default() },
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH_FORMAT,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Greater),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some(fragment_entry),
            compilation_options: options(),
            targets: &[Some(target.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// Draws the visible blocks with the pipeline that is set. Blocks that follow one another in the
/// index buffer are drawn together.
pub(super) fn draw_blocks(
    pass: &mut wgpu::RenderPass<'_>,
    bindings: &FrameBindings,
    (mesh, buffers): (&CircularMesh, &MeshBuffers),
    visible: &[u32],
) {
    pass.set_bind_group(0, &bindings.frame, &[]);
    pass.set_bind_group(1, &bindings.terrain, &[]);
    pass.set_vertex_buffer(0, buffers.displaced.slice(..));
    pass.set_index_buffer(buffers.indices.slice(..), wgpu::IndexFormat::Uint32);
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
