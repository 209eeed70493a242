use crate::gpu::DEPTH_FORMAT;
use crate::gpu::coordinate_pass::{depth_attachment, target_texture};

/// What each pixel of a frame asks for: the paper's texture U1, and the depth it is drawn with. Two words a
/// pixel, a [`PageRequest`](crate::residency::page_table::PageRequest).
pub(crate) struct RequestImage {
    pub texture: wgpu::Texture,
    pub view: wgpu::TextureView,
    depth: wgpu::TextureView,
}

impl RequestImage {
    pub const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rg32Uint;
    pub const TEXEL_BYTES: u32 = 8;

    pub fn new(device: &wgpu::Device, size_px: [u32; 2]) -> Self {
        let texture = |label, format, usage| target_texture(device, label, size_px, format, usage);
        use wgpu::TextureUsages as Usage;
        let read = Usage::TEXTURE_BINDING | Usage::COPY_SRC | Usage::COPY_DST;
        let requests = texture("page requests", Self::FORMAT, read);
        let depth = texture("page request depth", DEPTH_FORMAT, Usage::empty());
        Self {
            view: requests.create_view(&Default::default()),
            depth: depth.create_view(&Default::default()),
            texture: requests,
        }
    }

    pub fn size_px(&self) -> [u32; 2] {
        [self.texture.width(), self.texture.height()]
    }

    /// Records the first stage: `draw` draws everything that has the texture on it.
    pub fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        draw: impl FnOnce(&mut wgpu::RenderPass<'_>),
    ) {
        let none = f64::from(u32::MAX);
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("page requests"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color { r: none, g: none, b: none, a: none }),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(depth_attachment(&self.depth)),
            ..Default::default()
        });
        draw(&mut pass);
    }
}
