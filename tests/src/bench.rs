use std::sync::Arc;

use terrain_core::dataset::TileSource;
use terrain_core::gpu::{GpuContext, OFFSCREEN_FORMAT, OffscreenTarget};
use terrain_core::measure::FrameRecord;
use terrain_core::{CameraView, RenderError, RendererSettings, TerrainRenderer};

use crate::{Picture, gpu};

/// A renderer and something to draw into.
pub struct Bench {
    /// The GPU both are on.
    pub gpu: Arc<GpuContext>,
    /// The renderer.
    pub renderer: TerrainRenderer,
    /// What it draws into: views must have its size.
    pub target: OffscreenTarget,
}

impl Bench {
    /// A renderer of the source; `None` (said on stderr) where there is no GPU.
    ///
    /// # Errors
    /// Where the renderer cannot be had.
    pub fn new(
        source: Arc<dyn TileSource>,
        settings: RendererSettings,
        size_px: [u32; 2],
    ) -> Result<Option<Self>, RenderError> {
        let Some(gpu) = gpu() else { return Ok(None) };
        let renderer = TerrainRenderer::new(Arc::clone(&gpu), source, settings)?;
        let target = OffscreenTarget::new(&gpu, size_px);
        Ok(Some(Self { gpu, renderer, target }))
    }

    /// Draws one frame.
    ///
    /// # Errors
    /// Where the view is none or the device has failed.
    pub fn draw(&mut self, view: &CameraView) -> Result<FrameRecord, RenderError> {
        self.renderer.render(view, self.target.view(), OFFSCREEN_FORMAT)
    }

    /// Draws until nothing is missing; the record sums up all frames it took.
    ///
    /// # Errors
    /// Where the view is none or the device has failed.
    pub fn settle(&mut self, view: &CameraView) -> Result<FrameRecord, RenderError> {
        self.renderer.render_settled(view, self.target.view(), OFFSCREEN_FORMAT)
    }

    /// The picture of a view in which nothing is missing.
    ///
    /// # Errors
    /// Where the view is none or the device has failed.
    pub fn settled_picture(&mut self, view: &CameraView) -> Result<Picture, RenderError> {
        self.settle(view)?;
        Ok(Picture::read(&self.gpu, &self.target)?)
    }
}
