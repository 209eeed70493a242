use std::sync::Arc;

use glam::DVec3;
use terrain_core::dataset::TileSource;
use terrain_core::gpu::{GpuContext, GpuError, OFFSCREEN_FORMAT, OffscreenTarget};
use terrain_core::measure::FrameRecord;
use terrain_core::{CameraView, RenderError, RendererSettings, TerrainRenderer};

use crate::{Picture, gpu};

/// A renderer and something to draw into.
pub struct Bench {
    /// The GPU both are on.
    pub gpu: Arc<GpuContext>,
    /// The renderer.
    pub renderer: TerrainRenderer,
    /// What was drawn into last.
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
    ) -> Result<Option<Self>, RenderError> {
        gpu().map(|gpu| Self::on(&gpu, source, settings)).transpose()
    }

    /// A renderer of the source on this GPU.
    ///
    /// # Errors
    /// Where the renderer cannot be had.
    pub fn on(
        gpu: &Arc<GpuContext>,
        source: Arc<dyn TileSource>,
        settings: RendererSettings,
    ) -> Result<Self, RenderError> {
        let renderer = TerrainRenderer::new(Arc::clone(gpu), source, settings)?;
        Ok(Self { gpu: Arc::clone(gpu), renderer, target: OffscreenTarget::new(gpu, [1, 1]) })
    }

    /// Changes the settings in force.
    ///
    /// # Errors
    /// Where the renderer refuses them.
    pub fn change(
        &mut self,
        change: impl FnOnce(&mut RendererSettings),
    ) -> Result<(), RenderError> {
        let mut settings = *self.renderer.settings();
        change(&mut settings);
        self.renderer.set_settings(settings)
    }

    /// Draws one frame.
    ///
    /// # Errors
    /// Where the view is none or the device has failed.
    pub fn draw(&mut self, view: &CameraView) -> Result<FrameRecord, RenderError> {
        self.fit_target(view);
        self.renderer.render(view, self.target.view(), OFFSCREEN_FORMAT)
    }

    /// Draws until nothing is missing; the record sums up all frames it took.
    ///
    /// # Errors
    /// Where the view is none or the device has failed.
    pub fn settle(&mut self, view: &CameraView) -> Result<FrameRecord, RenderError> {
        self.fit_target(view);
        self.renderer.render_settled(view, self.target.view(), OFFSCREEN_FORMAT)
    }

    /// Draws the view beside the frames; see [`TerrainRenderer::redraw`].
    ///
    /// # Errors
    /// Where the device has failed.
    pub fn redraw(&mut self, view: &CameraView) -> Result<(), RenderError> {
        self.fit_target(view);
        self.renderer.redraw(view, self.target.view(), OFFSCREEN_FORMAT)
    }

    /// What was drawn last.
    ///
    /// # Errors
    /// Where the device has failed.
    pub fn picture(&self) -> Result<Picture, GpuError> {
        Picture::read(&self.gpu, &self.target)
    }

    /// The picture of a view in which nothing is missing.
    ///
    /// # Errors
    /// Where the view is none or the device has failed.
    pub fn settled_picture(&mut self, view: &CameraView) -> Result<Picture, RenderError> {
        self.settle(view)?;
        Ok(self.picture()?)
    }

    /// The points of the ground that the pixels of a view show in which nothing is missing, row by row;
    /// NaN where there is sky.
    ///
    /// # Errors
    /// Where the view is none or the device has failed.
    pub fn ground_points(&mut self, view: &CameraView) -> Result<Vec<DVec3>, RenderError> {
        let points = self.renderer.ground_coordinates(view)?;
        Ok(points.into_iter().map(DVec3::from_array).collect())
    }

    /// Makes the target the size of the view's picture; of none, it stays as it is.
    fn fit_target(&mut self, view: &CameraView) {
        let size_px = view.viewport_px;
        if size_px != self.target.size_px() && !size_px.contains(&0) {
            self.target = OffscreenTarget::new(&self.gpu, size_px);
        }
    }
}
