use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::bail;
use glam::DVec3;
use terrain_core::dataset::TileSource;
use terrain_core::gpu::AdapterChoice;
use terrain_core::measure::error::{DrawnPicture, MeasuredErrors, PictureDeviation, Spread};
use terrain_core::measure::motion::{popping, swim_px};
use terrain_core::measure::{Flight, FrameRecord};
use terrain_core::selection::Strategy;
use terrain_core::{CameraView, RendererSettings};

use super::exact_pictures::ExactPictures;
use super::worst_frames::{WorstFrame, WorstFrames};
use crate::headless::Headless;

/// What every run flies, and how it is measured.
pub struct Course {
    /// The flight.
    pub flight: Flight,
    /// Frames of the flight that are drawn.
    pub frames: Vec<u64>,
    /// Width and height of the pictures in pixels.
    pub size_px: [u32; 2],
    /// Every so manieth frame drawn is measured, beginning with the first.
    pub error_every: u64,
    /// Whether every frame waits until nothing is missing.
    pub settle: bool,
    /// Set when the user calls it off.
    pub cancelled: Arc<AtomicBool>,
}

/// One way of drawing the course.
pub struct RunPlan {
    /// What the run is called; unique.
    pub name: String,
    /// How it is drawn.
    pub settings: RendererSettings,
    /// What is drawn.
    pub source: Arc<dyn TileSource>,
}

/// What a run did.
pub struct RunResult {
    /// What the run is called.
    pub name: String,
    /// How tiles were selected.
    pub strategy: Strategy,
    /// A record a frame.
    pub records: Vec<FrameRecord>,
    /// The measured frames that differ most.
    pub worst: Vec<WorstFrame>,
}

impl Course {
    /// Opens the renderer of a run.
    ///
    /// # Errors
    /// Where there is no such adapter, or nothing to draw.
    pub fn open(&self, plan: &RunPlan, adapter: &AdapterChoice) -> anyhow::Result<Headless> {
        Headless::open(Arc::clone(&plan.source), adapter, plan.settings, self.size_px)
    }

    /// Flies the course; `frame_done` is told of each frame.
    ///
    /// # Errors
    /// Where the device fails, a tile cannot be read, or it is called off.
    pub fn fly(
        &self,
        plan: RunPlan,
        headless: &mut Headless,
        exact: &mut ExactPictures,
        frame_done: &mut dyn FnMut(),
    ) -> anyhow::Result<RunResult> {
        let mut records = Vec::with_capacity(self.frames.len());
        let mut worst = WorstFrames::default();
        for (index, &frame) in self.frames.iter().enumerate() {
            if self.cancelled.load(Ordering::Relaxed) {
                bail!("called off; nothing has been written");
            }
            let view = self.flight.view_at(self.flight.frame_time_s(frame), self.size_px);
            let is_measured = (index as u64).is_multiple_of(self.error_every);
            // Before the first frame there is no picture that could change.
            let before =
                if is_measured && index > 0 { Some(headless.redraw(&view)?) } else { None };
            let mut record = headless.draw(&view, self.settle)?;
            (record.frame, record.time_s) = (frame, self.flight.frame_time_s(frame));
            if is_measured {
                let measured =
                    self.measure(&mut record, &view, before.as_deref(), headless, exact)?;
                worst.consider(measured);
            }
            records.push(record);
            frame_done();
        }
        let strategy = plan.settings.strategy;
        Ok(RunResult { name: plan.name, strategy, records, worst: worst.into_frames() })
    }

    /// Fills in the errors of the frame just drawn.
    fn measure(
        &self,
        record: &mut FrameRecord,
        view: &CameraView,
        before: Option<&[[u8; 4]]>,
        headless: &mut Headless,
        exact: &mut ExactPictures,
    ) -> anyhow::Result<WorstFrame> {
        let rgba = headless.pixels()?;
        let ground = headless.drawn_ground(view)?;
        let reference = exact.of_frame(record.frame, view, &self.cancelled)?;
        let true_z_m = exact.heights_m(&ground)?;
        let drawn = DrawnPicture { rgba: &rgba, ground: &ground };
        let exaggeration = headless.settings().vertical_exaggeration;
        let deviation =
            PictureDeviation::measure(view, exaggeration, drawn, &reference, &true_z_m)?;
        let swim = self.swim(record.time_s, &ground, headless)?;
        let arrived = before.filter(|_| record.tiles_new > 0);
        let popping = match arrived {
            Some(before) => popping(before, &rgba, self.size_px)?,
            None => None,
        };
        record.errors = MeasuredErrors::new(&deviation, swim, popping);
        Ok(WorstFrame::new(record, self.size_px, rgba, reference))
    }

    /// How the ground drawn moves until the flight's next frame while the data stay as they are.
    fn swim(
        &self,
        time_s: f64,
        ground: &[DVec3],
        headless: &mut Headless,
    ) -> anyhow::Result<Option<Spread>> {
        let next = self.flight.view_at(time_s + self.flight.fps().recip(), self.size_px);
        let after = headless.drawn_ground(&next)?;
        Ok(Spread::of(swim_px(&next, ground, &after)?))
    }
}
