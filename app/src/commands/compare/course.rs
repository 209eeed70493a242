use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::bail;
use glam::DVec3;
use terrain_core::CameraView;
use terrain_core::measure::error::{DrawnPicture, MeasuredErrors, PictureDeviation, Spread};
use terrain_core::measure::motion::{popping, swim_px};
use terrain_core::measure::rest::{churn_at_rest, frames_until_sharp};
use terrain_core::measure::{Flight, FrameRecord};

use super::exact_pictures::ExactPictures;
use super::film_strip::{StripPicture, film_strip};
use super::plans::RunPlan;
use super::worst_frames::{WorstFrame, WorstFrames};
use crate::headless::{Headless, Pace};

/// A flight that every run flies, and how it is measured.
pub struct Course {
    /// What the flight is called.
    pub name: String,
    /// The flight.
    pub flight: Flight,
    /// Frames of the flight that are drawn.
    pub frames: Vec<u64>,
    /// How frames are drawn and measured.
    pub rules: Rules,
}

/// How frames are drawn and measured.
#[derive(Clone)]
pub struct Rules {
    /// Width and height of the pictures in pixels.
    pub size_px: [u32; 2],
    /// Every so manieth frame drawn is measured, beginning with the first.
    pub error_every: u64,
    /// What frames wait for.
    pub pace: Pace,
    /// Whether frames that are not measured go without a picture.
    pub only_measured: bool,
    /// Whether the flight is flown a second time with what the first has left in memory.
    pub warm: bool,
    /// How many of the worst frames a run keeps; one that stands for its strategy keeps one at least.
    pub worst_kept: usize,
    /// Set when the user calls it off.
    pub cancelled: Arc<AtomicBool>,
}

/// What a run did on a flight.
pub struct RunResult {
    /// What the flight is called.
    pub flight: String,
    /// What the run is called.
    pub name: String,
    /// How tiles were selected.
    pub strategy: String,
    /// Whether it stands for its strategy.
    pub is_typical: bool,
    /// A record a frame, beginning with nothing in memory.
    pub records: Vec<FrameRecord>,
    /// A record a frame of the second time, if there was one.
    pub warm_records: Vec<FrameRecord>,
    /// Frames from each jump of the flight until the picture was sharp, `None` where it moved on before;
    /// empty where frames were left out.
    pub frames_until_sharp: Vec<Option<u64>>,
    /// Tiles brought while the camera was at rest.
    pub churn_at_rest: u64,
    /// The measured frames that differ most.
    pub worst: Vec<WorstFrame>,
    /// What was drawn of which tiles.
    pub strip: Vec<StripPicture>,
}

impl Course {
    /// Frames to draw, both times.
    pub fn frame_count(&self) -> u64 {
        self.frames.len() as u64 * if self.rules.warm { 2 } else { 1 }
    }

    /// Flies the course; `frame_done` is told of each frame.
    ///
    /// # Errors
    /// Where the device fails, a tile cannot be read, or it is called off.
    pub fn fly(
        &self,
        plan: &RunPlan,
        headless: &mut Headless,
        exact: &mut ExactPictures,
        frame_done: &mut dyn FnMut(),
    ) -> anyhow::Result<RunResult> {
        let least_kept = usize::from(plan.is_typical);
        let mut worst = WorstFrames::new(self.rules.worst_kept.max(least_kept));
        let mut records = Vec::with_capacity(self.frames.len());
        for index in 0..self.frames.len() {
            records.push(self.frame(index, headless, exact, &mut worst)?);
            frame_done();
        }
        let mut warm_records = Vec::new();
        if self.rules.warm {
            for index in 0..self.frames.len() {
                self.check_cancelled()?;
                warm_records.push(self.draw(index, headless, false)?);
                frame_done();
            }
        }
        let views = self.frames.iter().map(|&frame| self.view(frame)).collect::<Vec<_>>();
        let strip = if plan.is_typical { film_strip(headless, &views)? } else { Vec::new() };
        Ok(RunResult {
            flight: self.name.clone(),
            name: plan.name.clone(),
            strategy: plan.strategy.clone(),
            is_typical: plan.is_typical,
            frames_until_sharp: self.frames_until_sharp(&views, &records),
            churn_at_rest: churn_at_rest(&views, &records),
            records,
            warm_records,
            worst: worst.into_frames(),
            strip,
        })
    }

    /// Draws a frame, and measures it where it is its turn.
    fn frame(
        &self,
        index: usize,
        headless: &mut Headless,
        exact: &mut ExactPictures,
        worst: &mut WorstFrames,
    ) -> anyhow::Result<FrameRecord> {
        self.check_cancelled()?;
        let view = self.view(self.frames[index]);
        let is_measured = (index as u64).is_multiple_of(self.rules.error_every);
        // Before the first frame there is no picture that could change.
        let before = if is_measured && index > 0 { Some(headless.redraw(&view)?) } else { None };
        let mut record = self.draw(index, headless, is_measured)?;
        if is_measured {
            let frame = self.measure(&mut record, &view, before.as_deref(), headless, exact)?;
            worst.consider(frame);
        }
        Ok(record)
    }

    fn draw(
        &self,
        index: usize,
        headless: &mut Headless,
        is_measured: bool,
    ) -> anyhow::Result<FrameRecord> {
        let frame = self.frames[index];
        let view = self.view(frame);
        let mut record = if self.rules.only_measured && !is_measured {
            headless.advance(&view, self.rules.pace)?
        } else {
            headless.draw(&view, self.rules.pace)?
        };
        (record.frame, record.time_s) = (frame, self.flight.frame_time_s(frame));
        Ok(record)
    }

    fn view(&self, frame: u64) -> CameraView {
        self.flight.view_at(self.flight.frame_time_s(frame), self.rules.size_px)
    }

    fn check_cancelled(&self) -> anyhow::Result<()> {
        if self.rules.cancelled.load(Ordering::Relaxed) {
            bail!("called off; nothing has been written");
        }
        Ok(())
    }

    /// For each jump of the flight; of none where frames were left out, as they would not be counted.
    fn frames_until_sharp(
        &self,
        views: &[CameraView],
        records: &[FrameRecord],
    ) -> Vec<Option<u64>> {
        if records.len() as u64 != self.flight.frame_count() {
            return Vec::new();
        }
        let is_jump = |index: &usize| {
            self.flight.is_cut_between(records[*index - 1].time_s, records[*index].time_s)
        };
        let jumps = (1..records.len()).filter(is_jump);
        jumps.map(|index| frames_until_sharp(&views[index..], &records[index..])).collect()
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
        let reference = exact.of_frame(record.frame, view, &self.rules.cancelled)?;
        let true_z_m = exact.heights_m(&ground)?;
        let drawn = DrawnPicture { rgba: &rgba, ground: &ground };
        let exaggeration = headless.settings().vertical_exaggeration;
        let deviation =
            PictureDeviation::measure(view, exaggeration, drawn, &reference, true_z_m.as_deref())?;
        let swim = match true_z_m {
            Some(_) => self.swim(record.time_s, &ground, headless)?,
            None => None,
        };
        let arrived = before.filter(|_| record.tiles_new > 0);
        let popping = match arrived {
            Some(before) => popping(before, &rgba, self.rules.size_px)?,
            None => None,
        };
        record.errors = MeasuredErrors::new(&deviation, swim, popping);
        Ok(WorstFrame::new(record, self.rules.size_px, rgba, &reference))
    }

    /// How the ground drawn moves until the flight's next frame while the data stay as they are; not
    /// known where the flight jumps.
    fn swim(
        &self,
        time_s: f64,
        ground: &[DVec3],
        headless: &mut Headless,
    ) -> anyhow::Result<Option<Spread>> {
        let next_s = time_s + self.flight.fps().recip();
        if self.flight.is_cut_between(time_s, next_s) {
            return Ok(None);
        }
        let next = self.flight.view_at(next_s, self.rules.size_px);
        let after = headless.drawn_ground(&next)?;
        Ok(Spread::of(swim_px(&next, ground, &after)?))
    }
}

#[cfg(test)]
impl RunResult {
    /// A typical run of these records, for tests.
    pub fn of_records(name: &str, records: Vec<FrameRecord>) -> Self {
        Self {
            flight: "flight".into(),
            name: name.into(),
            strategy: "rtt-quadtree".into(),
            is_typical: true,
            records,
            warm_records: Vec::new(),
            frames_until_sharp: Vec::new(),
            churn_at_rest: 0,
            worst: Vec::new(),
            strip: Vec::new(),
        }
    }
}
