//! The terrain as one renderer draws it: its picture, kept, and what its frames cost.

use glam::DVec2;
use terrain_core::gpu::GpuContext;
use terrain_core::{CameraView, RenderError, RendererSettings, TerrainRenderer};

use super::plots::FrameHistory;
use super::scene_cache::SceneCache;
use super::surface::{SurfaceFrame, WindowSurface};

/// A renderer, the picture it drew last where that is kept, and the records of its frames.
pub struct Scene {
    pub(super) renderer: TerrainRenderer,
    history: FrameHistory,
    cache: Option<SceneCache>,
}

impl Scene {
    /// A scene of which nothing has been drawn yet.
    pub fn new(renderer: TerrainRenderer) -> Self {
        Self { renderer, history: FrameHistory::default(), cache: None }
    }

    /// The settings in force.
    pub fn settings(&self) -> &RendererSettings {
        self.renderer.settings()
    }

    /// Changes the settings; the picture kept is then out of date.
    ///
    /// # Errors
    /// Where the renderer refuses them; the old ones then stay.
    pub fn set_settings(&mut self, settings: RendererSettings) -> Result<(), RenderError> {
        self.renderer.set_settings(settings)?;
        self.cache = None;
        Ok(())
    }

    /// The records of the frames just past.
    pub fn history(&self) -> &FrameHistory {
        &self.history
    }

    /// Height of the ground as drawn (exaggerated) in metres, for the controls.
    pub fn ground(&self) -> impl Fn(DVec2) -> Option<f64> + '_ {
        let exaggeration = self.settings().vertical_exaggeration;
        move |xy| self.renderer.ground_height_m(xy).map(|height_m| height_m * exaggeration)
    }

    /// Draws a frame into `target` and takes down what it cost; `frame_s` seconds have gone by since
    /// the frame before.
    ///
    /// # Errors
    /// Where the device has failed.
    pub fn draw(
        &mut self,
        view: &CameraView,
        target: &wgpu::TextureView,
        format: wgpu::TextureFormat,
        frame_s: f64,
    ) -> Result<(), RenderError> {
        let mut record = self.renderer.render(view, target, format)?;
        record.frame_ms = frame_s * 1.0e3;
        self.history.push(record);
        Ok(())
    }

    /// Whether the picture kept is what a frame of this view would show.
    pub fn is_kept(&self, surface: &WindowSurface, view: &CameraView) -> bool {
        let fits = self.cache.as_ref().is_some_and(|cache| cache.fits(surface));
        fits && !self.renderer.needs_frame(view)
    }

    /// Draws a frame and keeps its picture; see [`Self::draw`].
    ///
    /// # Errors
    /// Where the device has failed.
    pub fn draw_and_keep(
        &mut self,
        gpu: &GpuContext,
        surface: &WindowSurface,
        view: &CameraView,
        frame_s: f64,
    ) -> Result<(), RenderError> {
        let kept = self.cache.take().filter(|cache| cache.fits(surface));
        let cache = kept.unwrap_or_else(|| SceneCache::new(gpu, surface));
        self.draw(view, cache.view(), surface.scene_format(), frame_s)?;
        self.cache = Some(cache);
        Ok(())
    }

    /// Copies columns of the picture kept into a picture of the window; nothing where none is kept.
    pub fn copy_columns_to(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &SurfaceFrame,
        columns: std::ops::Range<u32>,
    ) {
        if let Some(cache) = self.cache.as_ref().filter(|_| !columns.is_empty()) {
            cache.copy_columns_to(encoder, frame, columns);
        }
    }

    /// Lets go of the picture kept.
    pub fn forget_picture(&mut self) {
        self.cache = None;
    }
}
