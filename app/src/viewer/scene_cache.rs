//! The finished scene kept, so that the user interface can change over it without drawing it again.

use std::ops::Range;

use terrain_core::gpu::GpuContext;

use super::surface::{SurfaceFrame, WindowSurface};

/// A picture of the scene in the surface's size and format.
pub struct SceneCache {
    texture: wgpu::Texture,
    scene_view: wgpu::TextureView,
}

impl SceneCache {
    /// A cache for the surface as it is now; nothing is drawn in it yet.
    pub fn new(gpu: &GpuContext, surface: &WindowSurface) -> Self {
        let [width, height] = surface.size_px();
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("scene cache"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: surface.format(),
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[surface.scene_format()],
        });
        let scene_view = texture.create_view(&wgpu::TextureViewDescriptor {
            format: Some(surface.scene_format()),
            ..Default::default()
        });
        Self { texture, scene_view }
    }

    /// Whether it still has the surface's size.
    pub fn fits(&self, surface: &WindowSurface) -> bool {
        [self.texture.width(), self.texture.height()] == surface.size_px()
    }

    /// Where the scene is drawn.
    pub fn view(&self) -> &wgpu::TextureView {
        &self.scene_view
    }

    /// Copies these columns of the scene to the same columns of a picture of the window.
    pub fn copy_columns_to(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &SurfaceFrame,
        columns: Range<u32>,
    ) {
        let origin = wgpu::Origin3d { x: columns.start, ..Default::default() };
        let whole = self.texture.size();
        let part = wgpu::Extent3d { width: columns.end - columns.start, ..whole };
        encoder.copy_texture_to_texture(
            wgpu::TexelCopyTextureInfo { origin, ..self.texture.as_image_copy() },
            wgpu::TexelCopyTextureInfo { origin, ..frame.texture().as_image_copy() },
            part,
        );
    }
}
