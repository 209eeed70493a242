//! A look at the renderer's own textures, as a picture in the panel.

use terrain_core::TerrainRenderer;
use terrain_core::gpu::{DEBUG_IMAGE_FORMAT, DebugImage, GpuContext};

use super::ui_layer::UiLayer;

/// Side of the picture in pixels.
const SIDE_PX: u32 = 576;

/// The picture of a texture.
pub struct TextureView {
    view: wgpu::TextureView,
    id: egui::TextureId,
}

impl TextureView {
    /// A picture that the user interface can show.
    pub fn new(gpu: &GpuContext, ui: &mut UiLayer) -> Self {
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("debug image"),
            size: wgpu::Extent3d { width: SIDE_PX, height: SIDE_PX, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: DEBUG_IMAGE_FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        let view = texture.create_view(&Default::default());
        let id = ui.register(gpu, &view);
        Self { view, id }
    }

    /// Draws the texture as it is now; returns the picture's name in the user interface.
    pub fn draw(&self, renderer: &mut TerrainRenderer, image: DebugImage) -> egui::TextureId {
        renderer.draw_debug_image(image, &self.view, [SIDE_PX; 2]);
        self.id
    }
}
