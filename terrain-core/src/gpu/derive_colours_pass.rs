use super::atlas::mip_view;
use super::colour_atlas::ColourAtlas;
use super::cover_pipeline::cover_pipeline;
use super::shader_library::DERIVE_COLOURS;

/// Decodes uploaded colour tiles into the atlas and derives their coarser mips.
pub(crate) struct DeriveColoursPass {
    /// A step a mip.
    steps: [Step; 3],
}

struct Step {
    pipeline: wgpu::RenderPipeline,
    source: wgpu::BindGroup,
    target: wgpu::TextureView,
}

impl DeriveColoursPass {
    pub fn new(device: &wgpu::Device, atlas: &ColourAtlas) -> Self {
        let module = DERIVE_COLOURS.module(device);
        let step = |entry, source: wgpu::TextureView, mip| {
            let stage = (entry, ColourAtlas::FORMAT);
            let pipeline = cover_pipeline(device, "derive colours", None, &module, stage);
            let source = device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("derive colours"),
                layout: &pipeline.get_bind_group_layout(0),
                entries: &[wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::TextureView(&source),
                }],
            });
            Step { pipeline, source, target: atlas.mip(mip) }
        };
        let steps = [
            step("decode_colours", mip_view(&atlas.stored, 0), 0),
            step("halve_colours", atlas.mip(0), 1),
            step("halve_colours", atlas.mip(1), 2),
        ];
        Self { steps }
    }

    /// Records the work on the slots whose tiles were written this frame.
    pub fn record(&self, encoder: &mut wgpu::CommandEncoder, atlas: &ColourAtlas, slots: &[u32]) {
        if slots.is_empty() {
            return;
        }
        for (halvings, step) in (0..).zip(&self.steps) {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("derive colours"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &step.target,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store },
                })],
                ..Default::default()
            });
            pass.set_pipeline(&step.pipeline);
            pass.set_bind_group(0, &step.source, &[]);
            for &slot in slots {
                let [x, y] = atlas.grid.slot_origin_texels(slot);
                let size = atlas.grid.slot_size_texels >> halvings;
                pass.set_scissor_rect(x >> halvings, y >> halvings, size, size);
                pass.draw(0..3, 0..1);
            }
        }
    }
}
