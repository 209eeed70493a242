use super::atlas::mip_view;
use super::colour_atlas::ColourAtlas;
use super::shader_library::DERIVE_COLOURS;

/// Derives the coarser mips of uploaded colour tiles.
pub(crate) struct DeriveColoursPass {
    pipeline: wgpu::RenderPipeline,
    /// A step a mip: what is read, and what is drawn into.
    steps: [(wgpu::BindGroup, wgpu::TextureView); 2],
}

impl DeriveColoursPass {
    pub fn new(device: &wgpu::Device, atlas: &ColourAtlas) -> Self {
        let pipeline = pipeline(device);
        let layout = pipeline.get_bind_group_layout(0);
        let step = |source: wgpu::TextureView, mip| {
            let bindings = device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("derive colours"),
                layout: &layout,
                entries: &[wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::TextureView(&source),
                }],
            });
            (bindings, atlas.derived_mip(mip))
        };
        let steps = [step(mip_view(&atlas.colours, 0), 0), step(atlas.derived_mip(0), 1)];
        Self { pipeline, steps }
    }

    /// Records the halving of the slots, whose tiles were written this frame.
    pub fn record(&self, encoder: &mut wgpu::CommandEncoder, atlas: &ColourAtlas, slots: &[u32]) {
        if slots.is_empty() {
            return;
        }
        for (halvings, (bindings, target)) in (1..).zip(&self.steps) {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("derive colours"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: target,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store },
                })],
                ..Default::default()
            });
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, bindings, &[]);
            for &slot in slots {
                let [x, y] = atlas.grid.slot_origin_texels(slot);
                let size = atlas.grid.slot_size_texels >> halvings;
                pass.set_scissor_rect(x >> halvings, y >> halvings, size, size);
                pass.draw(0..3, 0..1);
            }
        }
    }
}

fn pipeline(device: &wgpu::Device) -> wgpu::RenderPipeline {
    let module = DERIVE_COLOURS.module(device);
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("derive colours"),
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("cover"),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("halve_colours"),
            compilation_options: Default::default(),
            targets: &[Some(ColourAtlas::MIP_FORMAT.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}
