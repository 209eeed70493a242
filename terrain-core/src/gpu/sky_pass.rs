use super::DEPTH_FORMAT;
use super::frame_group::FrameGroup;
use super::picture::TargetKind;
use super::shader_library::{SKY, Shader};

/// Fills the picture behind the terrain.
pub(crate) struct SkyPass {
    pipeline: wgpu::RenderPipeline,
}

impl SkyPass {
    /// A pass into targets of this kind. The group is that of any frame: all are laid out alike.
    pub fn new(device: &wgpu::Device, frame: &FrameGroup, target: TargetKind) -> Self {
        Self::with(device, &SKY, ("sky_vertex", "sky_fragment"), &[&frame.layout], target)
    }

    /// A pass with another sky, whose shader reads these groups from 0 on.
    pub fn with(
        device: &wgpu::Device,
        shader: &Shader,
        (vertex_entry, fragment_entry): (&str, &str),
        groups: &[&wgpu::BindGroupLayout],
        TargetKind { format, samples }: TargetKind,
    ) -> Self {
        let groups = groups.iter().map(|&group| Some(group)).collect::<Vec<_>>();
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(shader.name),
            bind_group_layouts: &groups,
            immediate_size: 0,
        });
        let module = shader.module(device);
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(shader.name),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some(vertex_entry),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: Some(wgpu::DepthStencilState {
                format: DEPTH_FORMAT,
                depth_write_enabled: Some(false),
                depth_compare: Some(wgpu::CompareFunction::Equal),
                stencil: Default::default(),
                bias: Default::default(),
            }),
            multisample: wgpu::MultisampleState { count: samples, ..Default::default() },
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some(fragment_entry),
                compilation_options: Default::default(),
                targets: &[Some(format.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        Self { pipeline }
    }

    /// Draws the sky where no terrain was drawn: to be called after the terrain, in its pass, with the groups
    /// beyond the frame's set.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, frame: &FrameGroup) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &frame.group, &[]);
        pass.draw(0..3, 0..1);
    }
}
