use std::fmt::Write;

use serde::Serialize;
use terrain_core::measure::FrameRecord;
use terrain_core::measure::report::{
    HtmlReport, Plot, PlotError, ReportPicture, Series, SeriesStyle,
};
use terrain_core::measure::sweep::Knob;

use super::course::RunResult;
use super::run_summary::{RunSummary, RunTime};
use super::sweep_plots::{ParetoFront, Trade};

/// Width and height of a plot in pixels.
const SIZE_PX: [u32; 2] = [760, 280];

/// More runs than this show their worst frame alone.
const MANY_RUNS: usize = 3;

/// What was flown.
#[derive(Serialize)]
pub struct Scene {
    /// The dataset.
    pub dataset: String,
    /// The flight's file; `None` of a tour of the dataset.
    pub flight: Option<String>,
    /// The graphics adapter.
    pub adapter: String,
    /// Width and height of the pictures in pixels.
    pub size_px: [u32; 2],
    /// Whether every frame waited until nothing was missing.
    pub settle: bool,
    /// Every so manieth frame was measured.
    pub error_every: u64,
    /// What a sweep turned.
    pub knob: Option<Knob>,
}

/// A comparison, to be written down.
pub struct Page {
    scene: Scene,
    /// What the runs did.
    pub runs: Vec<RunResult>,
    summaries: Vec<RunSummary>,
}

/// The whole of `summary.json`.
#[derive(Serialize)]
struct Summary<'a> {
    #[serde(flatten)]
    scene: &'a Scene,
    runs: &'a [RunSummary],
    pareto_fronts: Vec<ParetoFront>,
}

/// A column of the page's tables.
struct Column {
    title: &'static str,
    value: fn(&RunSummary) -> f64,
    decimals: usize,
}

const COSTS: [Column; 9] = [
    Column { title: "ms a frame", value: |run| run.frame_ms.mean, decimals: 1 },
    Column { title: "99 % (ms)", value: |run| run.frame_ms.p99, decimals: 1 },
    Column { title: "CPU (ms)", value: |run| run.cpu_ms.mean, decimals: 2 },
    Column { title: "GPU (ms)", value: |run| run.gpu_ms.map_or(f64::NAN, |s| s.mean), decimals: 1 },
    Column { title: "jank-sum (s)", value: |run| run.jank_sum_ms / 1000.0, decimals: 2 },
    Column { title: "upload (KiB)", value: |run| run.bytes_a_frame.upload / 1024.0, decimals: 1 },
    Column {
        title: "readback (KiB)",
        value: |run| run.bytes_a_frame.readback / 1024.0,
        decimals: 1,
    },
    Column { title: "disk (KiB)", value: |run| run.bytes_a_frame.disk / 1024.0, decimals: 1 },
    Column { title: "tiles", value: |run| run.tiles_new as f64, decimals: 0 },
];

const PICTURE_ERRORS: [Column; 5] = [
    Column { title: "FLIP mean", value: |run| run.error("flip_mean"), decimals: 4 },
    Column { title: "FLIP 99 %", value: |run| run.error("flip_p99"), decimals: 3 },
    Column { title: "PSNR (dB)", value: |run| run.error("psnr_db"), decimals: 1 },
    Column { title: "SSIM", value: |run| run.error("ssim"), decimals: 3 },
    Column { title: "popping (FLIP)", value: |run| run.error("popping_flip_mean"), decimals: 4 },
];

const GROUND_ERRORS: [Column; 6] = [
    Column { title: "height RMSE (m)", value: |run| run.error("height_rmse_m"), decimals: 2 },
    Column {
        title: "screen 50 % (px)",
        value: |run| run.error("screen_error_px_p50"),
        decimals: 3,
    },
    Column { title: "99 % (px)", value: |run| run.error("screen_error_px_p99"), decimals: 2 },
    Column { title: "silhouette (px)", value: |run| run.error("silhouette_error_px"), decimals: 2 },
    Column { title: "swim 50 % (px)", value: |run| run.error("swim_px_p50"), decimals: 4 },
    Column { title: "99 % (px)", value: |run| run.error("swim_px_p99"), decimals: 3 },
];

/// What is plotted over the flight: caption, label and value.
type Curve = (&'static str, &'static str, fn(&FrameRecord) -> f64);

const MEASURED_CURVES: [Curve; 2] = [
    ("Mean FLIP error of the measured frames.", "FLIP, mean", |record| {
        record.errors.flip_mean.unwrap_or(f64::NAN)
    }),
    (
        "Screen-space error that 99 in a hundred pixels of a measured frame keep.",
        "screen-space error, 99 % (px)",
        |record| record.errors.screen_error_px_p99.unwrap_or(f64::NAN),
    ),
];

const COST_CURVES: [Curve; 2] = [
    ("Time of each frame, measuring left out.", "time a frame (ms)", |record| record.frame_ms),
    ("Bytes to the GPU in each frame, by any cause.", "to the GPU (KiB)", |record| {
        record.upload_bytes as f64 / 1024.0
    }),
];

const MEANINGS: [&str; 5] = [
    "FLIP (0 to 1) is how different two pictures look when one flips between them; PSNR and SSIM are \
     the older measures of the same. Each is taken against the exact picture of the same camera.",
    "Height RMSE is over the pixels that show ground, each against the exact height at the place it \
     shows.",
    "Screen-space error is how many pixels lie between where a point of the ground is drawn and where \
     it truly projects to; silhouette error how many lie between drawn and true silhouettes.",
    "Swim is how many pixels a point of the ground moves by itself until the next frame while the \
     data stay; popping the FLIP error between a frame without and with the tiles that arrived in it.",
    "Jank-sum is the time by which frames exceed 16.7 ms, all together.",
];

impl Page {
    /// The page of these runs.
    pub fn new(scene: Scene, runs: Vec<RunResult>) -> Self {
        let summaries = runs.iter().map(RunSummary::of).collect();
        Self { scene, runs, summaries }
    }

    /// `summary.json`.
    ///
    /// # Errors
    /// Where a number cannot be written.
    pub fn json(&self) -> anyhow::Result<String> {
        let front = |trade: &Trade| trade.front(&self.summaries, self.scene.settle);
        let summary = Summary {
            scene: &self.scene,
            runs: &self.summaries,
            pareto_fronts: Trade::ALL.iter().map(front).collect(),
        };
        Ok(serde_json::to_string_pretty(&summary)? + "\n")
    }

    /// A few lines for the terminal.
    pub fn text(&self) -> String {
        let mut text = String::new();
        let time = RunTime::of(&self.summaries, self.scene.settle);
        for run in &self.summaries {
            let time_ms = time.median_ms(run);
            let kib = run.bytes_a_frame.upload / 1024.0;
            let (flip, screen) = (run.error("flip_mean"), run.error("screen_error_px_p99"));
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "{:<24} {time_ms:>8.1} ms {kib:>9.1} KiB a frame   FLIP {flip:.4}   \
                 screen-space error {screen:.2} px (99 %)",
                run.run,
            );
        }
        text
    }

    /// `report.html`.
    ///
    /// # Errors
    /// Where a plot or picture cannot be made.
    pub fn html(&self) -> anyhow::Result<String> {
        let mut report = HtmlReport::new(&format!("Comparison over {}", self.scene.dataset));
        report.paragraph(&self.scene.sentence(self.runs.first()));
        report.heading("Cost").table(&header(&COSTS), &self.rows(&COSTS));
        report.paragraph(self.scene.cost_note());
        report.heading("Error of the pictures");
        report.table(&header(&PICTURE_ERRORS), &self.rows(&PICTURE_ERRORS));
        report.paragraph("Means over the measured frames. Less is better, but for PSNR and SSIM.");
        report.heading("Error of the ground drawn");
        report.table(&header(&GROUND_ERRORS), &self.rows(&GROUND_ERRORS));
        self.add_trades(&mut report)?;
        report.heading("Over the flight");
        for curve in MEASURED_CURVES.iter().chain(&COST_CURVES) {
            report.figure(&self.curve_svg(curve)?, curve.0);
        }
        self.add_worst_frames(&mut report)?;
        report.heading("What the numbers mean");
        for meaning in MEANINGS {
            report.paragraph(meaning);
        }
        Ok(report.to_html())
    }

    fn rows(&self, columns: &[Column]) -> Vec<Vec<String>> {
        let row = |run: &RunSummary| {
            let cell = |column: &Column| {
                let value = (column.value)(run);
                let known = || format!("{value:.*}", column.decimals);
                if value.is_nan() { "–".to_owned() } else { known() }
            };
            std::iter::once(run.run.clone()).chain(columns.iter().map(cell)).collect()
        };
        self.summaries.iter().map(row).collect()
    }

    /// Nothing to trade where there is one run.
    fn add_trades(&self, report: &mut HtmlReport) -> Result<(), PlotError> {
        if self.summaries.len() < 2 {
            return Ok(());
        }
        report.heading("Run time and bytes against error");
        for trade in &Trade::ALL {
            let svg = trade.svg(&self.summaries, self.scene.settle)?;
            report.figure(&svg, &trade.caption());
        }
        Ok(())
    }

    fn curve_svg(&self, (_, label, value): &Curve) -> Result<String, PlotError> {
        let series = self.runs.iter().map(|run| {
            let points = run.records.iter().map(|record| [record.time_s, value(record)]);
            // Between measured frames nothing is known; the line leads from one to the next.
            let points = points.filter(|point| !point[1].is_nan()).collect();
            Series { name: run.name.clone(), points, style: SeriesStyle::Line }
        });
        let plot = Plot {
            x_label: "time in the flight (s)".into(),
            y_label: (*label).into(),
            series: series.collect(),
            ..Default::default()
        };
        plot.to_svg(SIZE_PX)
    }

    fn add_worst_frames(&self, report: &mut HtmlReport) -> anyhow::Result<()> {
        report.heading("The worst frames");
        report.paragraph(
            "Those with the greatest mean FLIP error: the picture as drawn, the exact one, and the FLIP \
             error of each pixel from black (0) through purple and orange to pale yellow (1).",
        );
        // Many runs with all their pictures would make a page too large to send.
        let shown = if self.runs.len() > MANY_RUNS { 1 } else { usize::MAX };
        for run in &self.runs {
            for frame in run.worst.iter().take(shown) {
                let what = format!("{}, {:.2} s", run.name, frame.time_s);
                let captions =
                    [what, "exact".into(), format!("FLIP error, mean {:.4}", frame.flip_mean)];
                let panels = frame.page_panels()?.into_iter().zip(captions);
                let row = panels.map(|(png, caption)| ReportPicture { png, caption });
                report.pictures(&row.collect::<Vec<_>>());
            }
        }
        Ok(())
    }
}

fn header(columns: &[Column]) -> Vec<&'static str> {
    std::iter::once("run").chain(columns.iter().map(|column| column.title)).collect()
}

impl Scene {
    fn sentence(&self, run: Option<&RunResult>) -> String {
        let flight = match &self.flight {
            Some(file) => format!("the flight {file}"),
            None => "a tour of the dataset".to_owned(),
        };
        let frames = run.map_or(0, |run| run.records.len());
        let [width, height] = self.size_px;
        let waits = if self.settle { "Every frame waits until nothing is missing. " } else { "" };
        format!(
            "Each run draws {frames} frames of {flight} at {width} × {height} pixels on {}. {waits}The \
             error of one frame in {} is measured, from the first on.",
            self.adapter, self.error_every,
        )
    }

    fn cost_note(&self) -> &'static str {
        if self.settle {
            "Bytes are means a frame. Every frame waits for its tiles: its time is mostly that of disk \
             and decoding, and its CPU time sums up all the frames it took to settle."
        } else {
            "Bytes are means a frame."
        }
    }
}
