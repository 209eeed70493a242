//! Drawing without a window.

use std::sync::Arc;
use std::time::Instant;

use glam::DVec3;
use terrain_core::dataset::TileSource;
use terrain_core::gpu::{AdapterChoice, GpuContext, OFFSCREEN_FORMAT, OffscreenTarget};
use terrain_core::measure::FrameRecord;
use terrain_core::{CameraView, NoProgress, Progress, RendererSettings, TerrainRenderer};

use crate::output;

/// A renderer and the picture it draws into.
pub struct Headless {
    gpu: Arc<GpuContext>,
    renderer: TerrainRenderer,
    target: OffscreenTarget,
}

impl Headless {
    /// Opens a GPU and a renderer of the source for pictures of this size.
    ///
    /// # Errors
    /// Where there is no such adapter, or nothing to draw.
    pub fn open(
        source: Arc<dyn TileSource>,
        adapter: &AdapterChoice,
        settings: RendererSettings,
        size_px: [u32; 2],
    ) -> anyhow::Result<Self> {
        Self::on(Arc::new(GpuContext::headless(adapter)?), source, settings, size_px)
    }

    /// The same on a GPU that is open already.
    ///
    /// # Errors
    /// Where there is nothing to draw.
    pub fn on(
        gpu: Arc<GpuContext>,
        source: Arc<dyn TileSource>,
        settings: RendererSettings,
        size_px: [u32; 2],
    ) -> anyhow::Result<Self> {
        let renderer = TerrainRenderer::new(Arc::clone(&gpu), source, settings)?;
        let target = OffscreenTarget::new(&gpu, size_px);
        Ok(Self { gpu, renderer, target })
    }

    /// Draws a frame and waits for it; with `settle` as many as it takes until nothing is missing.
    /// The record tells the whole time.
    ///
    /// # Errors
    /// Where the device fails.
    pub fn draw(&mut self, view: &CameraView, settle: bool) -> anyhow::Result<FrameRecord> {
        if settle {
            return self.draw_settled(view, &NoProgress);
        }
        let started = Instant::now();
        let record = self.renderer.render(view, self.target.view(), OFFSCREEN_FORMAT)?;
        self.finish(record, started)
    }

    /// Draws frames until nothing is missing, telling how many tiles have come, and waits for them.
    /// The record tells the whole time.
    ///
    /// # Errors
    /// Where the device fails.
    pub fn draw_settled(
        &mut self,
        view: &CameraView,
        progress: &dyn Progress,
    ) -> anyhow::Result<FrameRecord> {
        let started = Instant::now();
        let mut record = self.renderer.settle_with(view, progress)?;
        record.add_work_of(&self.renderer.render(view, self.target.view(), OFFSCREEN_FORMAT)?);
        self.finish(record, started)
    }

    /// Waits for what was drawn and completes its record.
    fn finish(&mut self, mut record: FrameRecord, started: Instant) -> anyhow::Result<FrameRecord> {
        self.gpu.wait()?;
        record.frame_ms = started.elapsed().as_secs_f64() * 1.0e3;
        // The renderer could tell only of an earlier picture.
        record.gpu_ms = self.renderer.latest_gpu_ms();
        self.tell_failures();
        Ok(record)
    }

    fn tell_failures(&mut self) {
        for failure in self.renderer.take_failures() {
            output::say(&format!("terrain: {failure}"));
        }
    }

    /// Does all that a settled frame does but its picture. The record tells the whole time.
    ///
    /// # Errors
    /// Where the device fails.
    pub fn settle(&mut self, view: &CameraView) -> anyhow::Result<FrameRecord> {
        let started = Instant::now();
        let mut record = self.renderer.settle(view)?;
        record.frame_ms = started.elapsed().as_secs_f64() * 1.0e3;
        record.gpu_ms = None;
        self.tell_failures();
        Ok(record)
    }

    /// The picture drawn last: RGBA, 8 bits a channel, first row on top.
    ///
    /// # Errors
    /// Where the device fails.
    pub fn picture(&self) -> anyhow::Result<Vec<u8>> {
        Ok(self.target.read_rgba8(&self.gpu)?)
    }

    /// The pixels of the picture drawn last; see [`Self::picture`].
    ///
    /// # Errors
    /// Where the device fails.
    pub fn pixels(&self) -> anyhow::Result<Vec<[u8; 4]>> {
        Ok(self.picture()?.as_chunks().0.to_vec())
    }

    /// The pixels of the view as it would be drawn with the tiles there are; no frame.
    ///
    /// # Errors
    /// Where the device fails.
    pub fn redraw(&mut self, view: &CameraView) -> anyhow::Result<Vec<[u8; 4]>> {
        self.renderer.redraw(view, self.target.view(), OFFSCREEN_FORMAT)?;
        self.pixels()
    }

    /// The point drawn at every pixel of the view with the tiles there are: x, y in the dataset's CRS,
    /// z exaggerated, row by row from the top left; NaN where there is sky.
    ///
    /// # Errors
    /// Where the device fails.
    pub fn drawn_ground(&mut self, view: &CameraView) -> anyhow::Result<Vec<DVec3>> {
        let points = self.renderer.drawn_coordinates(view)?;
        Ok(points.into_iter().map(DVec3::from_array).collect())
    }

    /// The settings in force.
    pub fn settings(&self) -> &RendererSettings {
        self.renderer.settings()
    }

    /// Changes the settings from the next frame on.
    ///
    /// # Errors
    /// Where caches of another size cannot be made.
    pub fn set_settings(&mut self, settings: RendererSettings) -> anyhow::Result<()> {
        Ok(self.renderer.set_settings(settings)?)
    }

    /// The point of the ground at every pixel, in the dataset's CRS and in true heights, row by row
    /// from the top left; NaN where there is sky.
    ///
    /// # Errors
    /// Where the device fails.
    pub fn ground_coordinates(&mut self, view: &CameraView) -> anyhow::Result<Vec<[f64; 3]>> {
        let exaggeration = self.renderer.settings().vertical_exaggeration;
        let drawn = self.renderer.ground_coordinates(view)?;
        Ok(drawn.into_iter().map(|[x, y, z]| [x, y, z / exaggeration]).collect())
    }
}
