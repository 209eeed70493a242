//! What a comparison leaves to read: `report.html`, `summary.json` and lines for the terminal.

mod columns;
mod curves;
mod notes;
mod paper_table;
mod pictures;
mod trades;

use std::fmt::Write;

use serde::Serialize;
use terrain_core::measure::report::HtmlReport;
use terrain_core::measure::sweep::Knob;

use self::trades::ParetoFront;
use super::comparison::{Comparison, ErrorColumn, distinct};
use super::course::RunResult;
use super::run_summary::{RunSummary, RunTime};
use crate::headless::Pace;

/// What was flown.
#[derive(Serialize)]
pub struct Scene {
    /// The dataset.
    pub dataset: String,
    /// How its tiles are stored.
    pub encoding: String,
    /// The flights.
    pub flights: Vec<String>,
    /// The graphics adapter.
    pub adapter: String,
    /// Whether it is a program on the CPU.
    pub is_software: bool,
    /// Width and height of the pictures in pixels.
    pub size_px: [u32; 2],
    /// What frames waited for.
    pub pace: Pace,
    /// Frames that tiles take at least.
    pub load_delay_frames: u32,
    /// Every so manieth frame was measured.
    pub error_every: u64,
    /// Whether frames that were not measured went without a picture.
    pub only_measured: bool,
    /// What a sweep turned.
    pub knob: Option<Knob>,
    /// Errors to compare costs at, where they are compared at equal errors.
    #[serde(skip)]
    pub equal_errors: Vec<(ErrorColumn, Option<f64>)>,
}

/// A comparison, to be written down.
pub struct Page {
    scene: Scene,
    /// What the runs did.
    pub runs: Vec<RunResult>,
    summaries: Vec<RunSummary>,
    comparisons: Vec<Comparison>,
}

/// The whole of `summary.json`.
#[derive(Serialize)]
struct Summary<'a> {
    #[serde(flatten)]
    scene: &'a Scene,
    comparisons: &'a [Comparison],
    runs: &'a [RunSummary],
    pareto_fronts: Vec<ParetoFront>,
}

impl Page {
    /// The page of these runs.
    pub fn new(scene: Scene, runs: Vec<RunResult>) -> Self {
        let summaries = runs.iter().map(RunSummary::of).collect::<Vec<_>>();
        let equal = scene
            .equal_errors
            .iter()
            .map(|&(error, given)| Comparison::at_equal(&summaries, scene.settles(), error, given));
        let as_given = std::iter::once(Comparison::as_given(&summaries, scene.settles()));
        Self { comparisons: as_given.chain(equal).collect(), scene, runs, summaries }
    }

    /// `summary.json`.
    ///
    /// # Errors
    /// Where a number cannot be written.
    pub fn json(&self) -> anyhow::Result<String> {
        let summary = Summary {
            scene: &self.scene,
            comparisons: &self.comparisons,
            runs: &self.summaries,
            pareto_fronts: trades::fronts(&self.summaries, self.scene.settles()),
        };
        Ok(serde_json::to_string_pretty(&summary)? + "\n")
    }

    /// A line a run for the terminal, and one a strategy for each error costs are compared at.
    pub fn text(&self) -> String {
        let name = |run: &RunSummary| match self.scene.flights.len() {
            1 => run.run.clone(),
            _ => format!("{} {}", run.flight, run.run),
        };
        let width = self.summaries.iter().map(|run| name(run).chars().count()).max().unwrap_or(0);
        let mut text = String::new();
        let time = RunTime::of(&self.summaries, self.scene.settles());
        for run in &self.summaries {
            let (time_ms, kib) = (time.median_ms(run), run.upload_kib());
            let (flip, screen) = (run.error("flip_mean"), run.error("screen_error_px_p99"));
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "{:<width$} {time_ms:>8.1} ms {kib:>9.1} KiB a frame   FLIP {flip:.4}   \
                 screen-space error {screen:.2} px (99 %)",
                name(run),
            );
        }
        let equal = self.comparisons.iter().filter(|comparison| comparison.equal.is_some());
        text.extend(equal.map(paper_table::lines));
        text
    }

    /// `report.html`.
    ///
    /// # Errors
    /// Where a plot or picture cannot be made.
    pub fn html(&self) -> anyhow::Result<String> {
        let mut report = HtmlReport::new(&format!("Comparison over {}", self.scene.dataset));
        for sentence in self.scene.sentences(&self.runs) {
            report.paragraph(&sentence);
        }
        if distinct(self.runs.iter().map(|run| run.strategy.as_str())).len() > 1 {
            paper_table::add(&mut report, &self.scene, &self.summaries, &self.comparisons);
        }
        notes::add_counted(&mut report);
        columns::add_breakdown(&mut report, &self.summaries);
        trades::add(&mut report, &self.summaries, self.scene.settles())?;
        curves::add(&mut report, &self.scene, &self.runs)?;
        pictures::add_strips(&mut report, &self.runs);
        pictures::add_worst_frames(&mut report, &self.runs)?;
        columns::add_raw_figures(&mut report, &self.summaries, self.scene.cost_note());
        notes::add_meanings(&mut report);
        Ok(report.to_html())
    }
}

impl Scene {
    /// Whether every frame waits until nothing is missing.
    pub fn settles(&self) -> bool {
        self.pace == Pace::Settled
    }

    /// What was flown and how, in words.
    fn sentences(&self, runs: &[RunResult]) -> Vec<String> {
        let flights = self.flights.iter().map(|flight| {
            let frames = runs.iter().find(|run| run.flight == *flight);
            format!("{flight} ({} frames)", frames.map_or(0, |run| run.records.len()))
        });
        let flights = flights.collect::<Vec<_>>().join(", ");
        let [width, height] = self.size_px;
        let waits = match self.pace {
            Pace::Settled => "Every frame waits until nothing is missing. ",
            Pace::InStep => {
                "Every frame waits for what earlier frames asked for, and the first until nothing is \
                 missing. "
            }
            Pace::Free => "",
        };
        let late = match self.load_delay_frames {
            0 => String::new(),
            frames => format!("Tiles come {frames} frames after they were asked for. "),
        };
        let drawn = match self.only_measured {
            true => ", which alone are drawn: of all others tiles are chosen, loaded and sent",
            false => "",
        };
        let flown = format!(
            "Each run flies {flights} at {width} × {height} pixels on {}. {waits}{late}The error of one frame \
             in {} is measured, from the first on{drawn}.",
            self.adapter, self.error_every,
        );
        vec![flown, format!("Tiles of the dataset are stored as {}.", self.encoding)]
    }

    fn cost_note(&self) -> &'static str {
        if self.settles() {
            "Bytes are means a frame. Every frame waits for its tiles: its time is mostly that of disk \
             and decoding, and its CPU time sums up all the frames it took to settle."
        } else {
            "Bytes are means a frame."
        }
    }

    /// What has to be known of times and frame rates.
    fn add_rate_notes(&self, report: &mut HtmlReport) {
        if self.settles() {
            report.paragraph(
                "Every frame waits until nothing is missing, so that bytes and tiles are the same on \
                 every run: a frame rate would tell of the disk.",
            );
        }
        if self.is_software {
            report.paragraph(
                "The adapter is a program on the CPU: its times, frame rates and CPU loads say nothing \
                 about a GPU, and both share the processor.",
            );
        }
    }
}
