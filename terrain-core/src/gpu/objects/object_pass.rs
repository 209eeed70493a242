use super::object_buffers::{ModelRun, ObjectBuffers};
use crate::gpu::DEPTH_FORMAT;
use crate::gpu::frame_group::FrameGroup;
use crate::gpu::ground_pipeline::{flag, polygon_mode};
use crate::gpu::page_table::{PageBindings, RequestImage};
use crate::gpu::picture::TargetKind;
use crate::gpu::shader_library::{OBJECT_REQUESTS, OBJECTS, Shader};
use crate::gpu::texture_map::DepthPyramid;
use crate::renderer_settings::DebugView;

/// What models are drawn with: groups 0, 2 and 3.
#[derive(Clone, Copy)]
pub(crate) struct ObjectBindings<'a> {
    pub frame: &'a FrameGroup,
    pub pages: &'a PageBindings,
    pub objects: &'a ObjectBuffers,
}

impl ObjectBindings<'_> {
    fn set(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_bind_group(0, &self.frame.group, &[]);
        pass.set_bind_group(PageBindings::GROUP, &self.pages.group, &[]);
        pass.set_bind_group(ObjectBuffers::GROUP, &self.objects.group, &[]);
    }
}

/// What decides how the picture's pipelines are built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ObjectPassSettings {
    pub target: TargetKind,
    pub wireframe: bool,
    pub anisotropy: u32,
    /// Whether pages may show in part.
    pub fades: bool,
    /// Whether any material leaves parts out.
    pub has_cutouts: bool,
    pub debug_view: DebugView,
}

/// Draws models into the picture.
pub(crate) struct ObjectPass(Sides);

impl ObjectPass {
    pub fn new(
        device: &wgpu::Device,
        bindings: ObjectBindings<'_>,
        settings: &ObjectPassSettings,
    ) -> Self {
        let constants = [
            ("ANISOTROPY", f64::from(settings.anisotropy)),
            ("FADES", flag(settings.fades)),
            ("HAS_CUTOUTS", flag(settings.has_cutouts)),
            ("DEBUG_VIEW", f64::from(settings.debug_view.code())),
        ];
        Self(Sides::new(
            device,
            bindings,
            &Drawing {
                shader: &OBJECTS,
                entries: ("object_vertex", "object_fragment"),
                target: settings.target,
                constants: &constants,
                polygon_mode: polygon_mode(device, settings.wireframe),
            },
        ))
    }

    /// Draws the instances.
    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        bindings: ObjectBindings<'_>,
        runs: &[ModelRun],
    ) {
        self.0.draw(pass, bindings, runs);
    }
}

/// Draws what pages each pixel of models asks for.
pub(crate) struct ObjectRequestPass(Sides);

impl ObjectRequestPass {
    pub fn new(device: &wgpu::Device, bindings: ObjectBindings<'_>, anisotropy: u32) -> Self {
        Self(Sides::new(
            device,
            bindings,
            &Drawing {
                shader: &OBJECT_REQUESTS,
                entries: ("request_vertex", "request_fragment"),
                target: TargetKind { format: RequestImage::FORMAT, samples: 1 },
                constants: &[("ANISOTROPY", f64::from(anisotropy))],
                polygon_mode: wgpu::PolygonMode::Fill,
            },
        ))
    }

    /// Draws the instances.
    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        bindings: ObjectBindings<'_>,
        runs: &[ModelRun],
    ) {
        self.0.draw(pass, bindings, runs);
    }
}

/// Draws the depth of models that hide what lies behind them.
pub(crate) struct ObjectDepthPass(Sides);

impl ObjectDepthPass {
    pub fn new(device: &wgpu::Device, bindings: ObjectBindings<'_>) -> Self {
        Self(Sides::new(
            device,
            bindings,
            &Drawing {
                shader: &OBJECT_REQUESTS,
                entries: ("request_vertex", "depth_fragment"),
                target: TargetKind { format: DepthPyramid::FORMAT, samples: 1 },
                constants: &[],
                polygon_mode: wgpu::PolygonMode::Fill,
            },
        ))
    }

    /// Draws the instances.
    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        bindings: ObjectBindings<'_>,
        runs: &[ModelRun],
    ) {
        self.0.draw(pass, bindings, runs);
    }
}

/// Pipelines for triangles whose back is not drawn, and for those seen from both sides.
struct Sides([wgpu::RenderPipeline; 2]);

/// How triangles are drawn.
struct Drawing<'a> {
    shader: &'a Shader,
    entries: (&'a str, &'a str),
    target: TargetKind,
    constants: &'a [(&'a str, f64)],
    polygon_mode: wgpu::PolygonMode,
}

impl Sides {
    fn new(device: &wgpu::Device, bindings: ObjectBindings<'_>, drawing: &Drawing<'_>) -> Self {
        let module = drawing.shader.module(device);
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(drawing.shader.name),
            bind_group_layouts: &[
                Some(&bindings.frame.layout),
                None,
                Some(&bindings.pages.layout),
                Some(&bindings.objects.layout),
            ],
            immediate_size: 0,
        });
        let of = |cull_mode| pipeline(device, (&layout, &module), drawing, cull_mode);
        Self([of(Some(wgpu::Face::Back)), of(None)])
    }

    fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        bindings: ObjectBindings<'_>,
        runs: &[ModelRun],
    ) {
        bindings.set(pass);
        for (sides, pipeline) in self.0.iter().enumerate() {
            pass.set_pipeline(pipeline);
            bindings.objects.draw(pass, runs, sides);
        }
    }
}

fn pipeline(
    device: &wgpu::Device,
    (layout, module): (&wgpu::PipelineLayout, &wgpu::ShaderModule),
    drawing: &Drawing<'_>,
    cull_mode: Option<wgpu::Face>,
) -> wgpu::RenderPipeline {
    let compilation_options =
        || wgpu::PipelineCompilationOptions { constants: drawing.constants, ..Default::default() };
    let Drawing { shader, entries, target, polygon_mode, .. } = *drawing;
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(shader.name),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some(entries.0),
            compilation_options: Default::default(),
            buffers: &ObjectBuffers::vertex_layouts(),
        },
        primitive: wgpu::PrimitiveState { polygon_mode, cull_mode, ..Default::default() },
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH_FORMAT,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Greater),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: wgpu::MultisampleState { count: target.samples, ..Default::default() },
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some(entries.1),
            compilation_options: compilation_options(),
            targets: &[Some(target.format.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}
