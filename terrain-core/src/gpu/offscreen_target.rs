use super::context::{GpuContext, GpuError};
use super::readback_ring::ReadbackRing;

/// The format pictures are drawn in when there is no window.
pub const OFFSCREEN_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;

/// A picture in memory instead of a window.
pub struct OffscreenTarget {
    texture: wgpu::Texture,
    view: wgpu::TextureView,
    size_px: [u32; 2],
}

impl OffscreenTarget {
    /// A target of this width and height in pixels, both at least 1.
    pub fn new(gpu: &GpuContext, size_px: [u32; 2]) -> Self {
        let [width, height] = size_px;
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("offscreen"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: OFFSCREEN_FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let view = texture.create_view(&Default::default());
        Self { texture, view, size_px }
    }

    /// Width and height in pixels.
    pub fn size_px(&self) -> [u32; 2] {
        self.size_px
    }

    /// What to draw into.
    pub fn view(&self) -> &wgpu::TextureView {
        &self.view
    }

    /// Waits for the picture and returns it, RGBA, 8 bits a channel, sRGB-encoded, first row on top.
    ///
    /// # Errors
    /// [`GpuError::Lost`] where the device fails meanwhile.
    pub fn read_rgba8(&self, gpu: &GpuContext) -> Result<Vec<u8>, GpuError> {
        read_texture(gpu, &self.texture, self.size_px, 4)
    }
}

/// Waits for a texture's content: rows of texels without padding.
pub(crate) fn read_texture(
    gpu: &GpuContext,
    texture: &wgpu::Texture,
    size_px: [u32; 2],
    texel_bytes: u32,
) -> Result<Vec<u8>, GpuError> {
    let mut ring = ReadbackRing::new(&gpu.device, 1, size_px, texel_bytes);
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let buffer = ring.record(&mut encoder, texture);
    gpu.queue.submit([encoder.finish()]);
    if let Some(buffer) = buffer {
        ring.begin(buffer, ());
    }
    let waited = gpu.device.poll(wgpu::PollType::wait_indefinitely());
    gpu.check()?;
    waited.map_err(|error| GpuError::Lost(error.to_string()))?;
    ring.take_if(|_| true)
        .map(|readback| readback.bytes)
        .ok_or_else(|| GpuError::Lost("a picture could not be read back".to_owned()))
}
