use super::textures::ClipTextures;
use crate::gpu::cover_pipeline::cover_pipeline;
use crate::gpu::shader_library::DERIVE_COLOURS;

/// Decodes blocks of imagery once, when they come, for an adapter that would decode them anew for every
/// sample.
pub(crate) struct ClipDecodePass {
    pipeline: wgpu::RenderPipeline,
    /// Of each level where blocks are read from and texels go to.
    levels: Vec<(wgpu::BindGroup, wgpu::TextureView)>,
}

/// Texels that were written: the level, and first texel and size in the texture.
pub(crate) struct WrittenTexels {
    pub level: u32,
    pub first: [u32; 2],
    pub size: [u32; 2],
}

impl ClipDecodePass {
    /// `None` where the textures are sampled as they are stored.
    pub fn new(device: &wgpu::Device, textures: &ClipTextures) -> Option<Self> {
        let decoded = textures.decoded_colours.as_ref()?;
        let module = DERIVE_COLOURS.module(device);
        let stage = ("decode_colours", ClipTextures::DECODED_FORMAT);
        let pipeline = cover_pipeline(device, "decode clip colours", None, &module, stage);
        let level = |level| {
            let source = ClipTextures::level(&textures.stored_colours, level);
            let source = device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("decode clip colours"),
                layout: &pipeline.get_bind_group_layout(0),
                entries: &[wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::TextureView(&source),
                }],
            });
            (source, ClipTextures::level(decoded, level))
        };
        Some(Self { levels: (0..textures.sizes.colours[1]).map(level).collect(), pipeline })
    }

    /// Records the decoding of what was written, level by level.
    pub fn record(&self, encoder: &mut wgpu::CommandEncoder, written: &[WrittenTexels]) {
        for of_level in written.chunk_by(|a, b| a.level == b.level) {
            let level = of_level.first().and_then(|texels| self.levels.get(texels.level as usize));
            let Some((source, target)) = level else { continue };
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("decode clip colours"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: target,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store },
                })],
                ..Default::default()
            });
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, source, &[]);
            for texels in of_level {
                let ([x, y], [width, height]) = (texels.first, texels.size);
                pass.set_scissor_rect(x, y, width, height);
                pass.draw(0..3, 0..1);
            }
        }
    }
}
