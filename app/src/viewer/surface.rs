//! The window's surface: its formats, its size, and how frames are had from it.

use std::sync::Arc;

use anyhow::Context;
use terrain_core::gpu::GpuContext;
use winit::window::Window;

/// A surface configured for the window.
pub struct WindowSurface {
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    scene_format: wgpu::TextureFormat,
}

/// A picture to draw into and show.
pub struct SurfaceFrame {
    texture: wgpu::SurfaceTexture,
    /// For the scene: what is written is encoded as sRGB.
    pub scene_view: wgpu::TextureView,
    /// For the user interface, which encodes by itself.
    pub ui_view: wgpu::TextureView,
}

/// What came of asking for a picture.
#[expect(clippy::large_enum_variant, reason = "one at a time, and only for a moment")]
pub enum Acquired {
    /// Draw into it.
    Frame(SurfaceFrame),
    /// Ask again soon: the surface has been set up anew, or its pictures are all in use.
    Later,
    /// The window cannot be seen; it says when it can.
    Hidden,
}

impl WindowSurface {
    /// Configures a surface that came from the context's instance.
    pub fn new(
        gpu: &GpuContext,
        surface: wgpu::Surface<'static>,
        size_px: [u32; 2],
    ) -> anyhow::Result<Self> {
        let [width, height] = size_px.map(|side| side.max(1));
        let capabilities = surface.get_capabilities(&gpu.adapter);
        let mut config = surface
            .get_default_config(&gpu.adapter, width, height)
            .context("the graphics adapter cannot draw into this window (try another --adapter)")?;
        let reinterprets = gpu
            .adapter
            .get_downlevel_capabilities()
            .flags
            .contains(wgpu::DownlevelFlags::SURFACE_VIEW_FORMATS);
        let formats = choose_formats(&capabilities.formats, reinterprets);
        let (format, scene_format) = formats.unwrap_or((config.format, config.format));
        config.format = format;
        if scene_format != format {
            config.view_formats = vec![scene_format];
        }
        config.present_mode = wgpu::PresentMode::AutoVsync;
        config.usage |= capabilities.usages & wgpu::TextureUsages::COPY_DST;
        surface.configure(&gpu.device, &config);
        Ok(Self { surface, config, scene_format })
    }

    /// The format the scene is drawn in.
    pub fn scene_format(&self) -> wgpu::TextureFormat {
        self.scene_format
    }

    /// The format the user interface is drawn in, and that of the pictures themselves.
    pub fn format(&self) -> wgpu::TextureFormat {
        self.config.format
    }

    /// Width and height in pixels.
    pub fn size_px(&self) -> [u32; 2] {
        [self.config.width, self.config.height]
    }

    /// Whether a finished scene can be copied into a picture.
    pub fn takes_copies(&self) -> bool {
        self.config.usage.contains(wgpu::TextureUsages::COPY_DST)
    }

    /// Follows the window's size; a side of 0 (minimised) leaves all as it is.
    pub fn resize(&mut self, gpu: &GpuContext, size_px: [u32; 2]) {
        if size_px != self.size_px() && !size_px.contains(&0) {
            [self.config.width, self.config.height] = size_px;
            self.surface.configure(&gpu.device, &self.config);
        }
    }

    /// Asks for the next picture.
    ///
    /// # Errors
    /// Where a lost surface cannot be made again.
    pub fn acquire(&mut self, gpu: &GpuContext, window: &Arc<Window>) -> anyhow::Result<Acquired> {
        use wgpu::CurrentSurfaceTexture as Current;
        Ok(match self.surface.get_current_texture() {
            // A suboptimal picture is shown as it is: the resize that made it so is on its way.
            Current::Success(texture) | Current::Suboptimal(texture) => {
                Acquired::Frame(self.frame(texture))
            }
            Current::Timeout => Acquired::Later,
            Current::Occluded => Acquired::Hidden,
            Current::Outdated => {
                self.surface.configure(&gpu.device, &self.config);
                Acquired::Later
            }
            Current::Lost => {
                self.surface = gpu.instance.create_surface(Arc::clone(window))?;
                self.surface.configure(&gpu.device, &self.config);
                Acquired::Later
            }
            Current::Validation => {
                gpu.check()?;
                Acquired::Later
            }
        })
    }

    fn frame(&self, texture: wgpu::SurfaceTexture) -> SurfaceFrame {
        let view = |format| {
            texture.texture.create_view(&wgpu::TextureViewDescriptor {
                format: Some(format),
                ..Default::default()
            })
        };
        let (scene_view, ui_view) = (view(self.scene_format), view(self.config.format));
        SurfaceFrame { texture, scene_view, ui_view }
    }
}

impl SurfaceFrame {
    /// The picture itself, to copy into.
    pub fn texture(&self) -> &wgpu::Texture {
        &self.texture.texture
    }

    /// Shows the picture.
    pub fn present(self, queue: &wgpu::Queue) {
        queue.present(self.texture);
    }
}

/// The format of the pictures and the one that the scene sees them in. The user interface wants to
/// write encoded colours, the scene linear light; where the surface cannot be seen both ways, the
/// scene decides.
fn choose_formats(
    offered: &[wgpu::TextureFormat],
    reinterprets: bool,
) -> Option<(wgpu::TextureFormat, wgpu::TextureFormat)> {
    use wgpu::TextureFormat::{Bgra8Unorm, Rgba8Unorm};
    let plain = offered.iter().copied().find(|format| matches!(format, Bgra8Unorm | Rgba8Unorm));
    let encoded = offered.iter().copied().find(wgpu::TextureFormat::is_srgb);
    match (plain, encoded) {
        (Some(plain), _) if reinterprets => Some((plain, plain.add_srgb_suffix())),
        (_, Some(encoded)) => Some((encoded, encoded)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use wgpu::TextureFormat::*;

    use super::*;

    #[test]
    fn the_scene_is_always_drawn_in_linear_light_where_it_can_be() {
        let both = [Bgra8UnormSrgb, Bgra8Unorm];
        assert_eq!(choose_formats(&both, true), Some((Bgra8Unorm, Bgra8UnormSrgb)));
        assert_eq!(choose_formats(&both, false), Some((Bgra8UnormSrgb, Bgra8UnormSrgb)));
        assert_eq!(choose_formats(&[Rgba8Unorm], true), Some((Rgba8Unorm, Rgba8UnormSrgb)));
        assert_eq!(choose_formats(&[Rgba8Unorm], false), None);
    }
}
