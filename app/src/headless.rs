//! Drawing without a window.

use std::sync::Arc;
use std::time::Instant;

use glam::DVec3;
use serde::Serialize;
use terrain_core::dataset::{Shape, TileSource};
use terrain_core::geodesy::Geodetic;
use terrain_core::gpu::{AdapterChoice, GpuContext, OFFSCREEN_FORMAT, OffscreenTarget};
use terrain_core::measure::FrameRecord;
use terrain_core::selection::Strategy;
use terrain_core::{CameraView, NoProgress, Progress, RendererSettings, TerrainRenderer};

use crate::output;
use crate::scene_args::SceneObjects;

/// Whether frames wait, and for what.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Pace {
    /// For nothing: what comes in time depends on disk, GPU and processor.
    #[default]
    Free,
    /// Each frame for what earlier frames asked for, and the first until nothing is missing: the same
    /// on every run.
    InStep,
    /// Each until nothing is missing.
    Settled,
}

/// A renderer and the picture it draws into.
pub struct Headless {
    gpu: Arc<GpuContext>,
    renderer: TerrainRenderer,
    target: OffscreenTarget,
    /// What the dataset's ground lies on.
    shape: Shape,
    has_begun: bool,
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
        let shape = source.manifest().shape;
        let renderer = TerrainRenderer::new(Arc::clone(&gpu), source, settings)?;
        let target = OffscreenTarget::new(&gpu, size_px);
        Ok(Self { gpu, renderer, target, shape, has_begun: false })
    }

    /// Draws these beside the dataset from the next frame on.
    ///
    /// # Errors
    /// Where they cannot be drawn.
    pub fn add(&mut self, objects: &SceneObjects) -> anyhow::Result<()> {
        Ok(objects.put_into(&mut self.renderer)?)
    }

    /// Draws a frame and waits for it; at [`Pace::Settled`] as many as it takes until nothing is missing.
    /// The record tells the whole time, but not what a frame in step waits for.
    ///
    /// # Errors
    /// Where the device fails.
    pub fn draw(&mut self, view: &CameraView, pace: Pace) -> anyhow::Result<FrameRecord> {
        if self.begin(pace)? {
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

    /// Waits as a frame at this pace does before it begins; returns whether it has to settle.
    fn begin(&mut self, pace: Pace) -> anyhow::Result<bool> {
        let is_first = !std::mem::replace(&mut self.has_begun, true);
        if pace == Pace::InStep {
            self.renderer.wait()?;
        }
        Ok(pace == Pace::Settled || pace == Pace::InStep && is_first)
    }

    /// Does all that a frame does but its picture. The record tells the whole time.
    ///
    /// # Errors
    /// Where the device fails.
    pub fn advance(&mut self, view: &CameraView, pace: Pace) -> anyhow::Result<FrameRecord> {
        let settles = self.begin(pace)?;
        let started = Instant::now();
        let advanced =
            if settles { self.renderer.settle(view) } else { self.renderer.advance(view) };
        let mut record = advanced?;
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
        let RendererSettings { vertical_exaggeration, strategy, .. } = *self.renderer.settings();
        let drawn = self.renderer.ground_coordinates(view)?;
        // The others draw a globe as a map.
        let shape = match strategy {
            Strategy::PageTable => self.shape,
            _ => Shape::Plane,
        };
        let place = |point| true_place(shape, view, vertical_exaggeration, point);
        Ok(drawn.into_iter().map(place).collect())
    }
}

/// Where the point at a pixel of a view is, in the dataset's CRS and in true heights.
pub fn true_place(
    shape: Shape,
    view: &CameraView,
    vertical_exaggeration: f64,
    point: [f64; 3],
) -> [f64; 3] {
    let place = match shape {
        Shape::Plane => DVec3::from_array(point),
        Shape::Globe => {
            let seen = Geodetic::of_seen(view.eye, DVec3::from_array(point));
            seen.plate_carree().extend(seen.height_m)
        }
    };
    [place.x, place.y, place.z / vertical_exaggeration]
}
