use serde::Serialize;
use terrain_core::measure::report::{Plot, PlotError, Series, SeriesStyle};
use terrain_core::measure::sweep::pareto_front;

use super::run_summary::{RunSummary, RunTime};

/// Width and height of a plot in pixels.
const SIZE_PX: [u32; 2] = [760, 360];

/// What runs cost against an error they have.
pub struct Trade {
    cost: Cost,
    error: ErrorColumn,
}

#[derive(Clone, Copy)]
enum Cost {
    RunTime,
    UploadBytes,
}

#[derive(Clone, Copy)]
enum ErrorColumn {
    Flip,
    ScreenError,
}

/// The runs that no other run beats in both, as `summary.json` holds them.
#[derive(Serialize)]
pub struct ParetoFront {
    cost: &'static str,
    error: &'static str,
    runs: Vec<String>,
}

impl Trade {
    /// Run time and bytes, each against both errors.
    pub const ALL: [Self; 4] = [
        Self { cost: Cost::RunTime, error: ErrorColumn::Flip },
        Self { cost: Cost::UploadBytes, error: ErrorColumn::Flip },
        Self { cost: Cost::RunTime, error: ErrorColumn::ScreenError },
        Self { cost: Cost::UploadBytes, error: ErrorColumn::ScreenError },
    ];

    /// What the plot shows.
    pub fn caption(&self) -> String {
        let cost = match self.cost {
            Cost::RunTime => "Median run time of a frame",
            Cost::UploadBytes => "Bytes to the GPU a frame",
        };
        let error = match self.error {
            ErrorColumn::Flip => "the mean FLIP error",
            ErrorColumn::ScreenError => "the screen-space error that 99 in a hundred pixels keep",
        };
        format!("{cost} against {error}. The line joins the runs that no other beats in both.")
    }

    /// The runs on the Pareto front.
    pub fn front(&self, runs: &[RunSummary], settle: bool) -> ParetoFront {
        let cost = match self.cost {
            Cost::RunTime => RunTime::of(runs, settle).column(),
            Cost::UploadBytes => "upload_bytes_a_frame",
        };
        let front = pareto_front(&self.points(runs, settle));
        let runs = front.into_iter().map(|index| runs[index].run.clone()).collect();
        ParetoFront { cost, error: self.error.column(), runs }
    }

    /// The plot: a dot a run, and the front.
    ///
    /// # Errors
    /// Where the drawing library fails.
    pub fn svg(&self, runs: &[RunSummary], settle: bool) -> Result<String, PlotError> {
        let points = self.points(runs, settle);
        let front = pareto_front(&points).into_iter().map(|index| points[index]).collect();
        let front =
            Series { name: "Pareto front".into(), points: front, style: SeriesStyle::Dashed };
        let dots = runs.iter().zip(&points).map(|(run, point)| Series {
            name: run.run.clone(),
            points: vec![*point],
            style: SeriesStyle::Points,
        });
        let plot = Plot {
            x_label: self.cost.label(RunTime::of(runs, settle)).into(),
            y_label: self.error.label().into(),
            series: std::iter::once(front).chain(dots).collect(),
            ..Default::default()
        };
        plot.to_svg(SIZE_PX)
    }

    fn points(&self, runs: &[RunSummary], settle: bool) -> Vec<[f64; 2]> {
        let time = RunTime::of(runs, settle);
        let cost = |run: &RunSummary| match self.cost {
            Cost::RunTime => time.median_ms(run),
            Cost::UploadBytes => run.bytes_a_frame.upload / 1024.0,
        };
        runs.iter().map(|run| [cost(run), run.error(self.error.column())]).collect()
    }
}

impl Cost {
    fn label(self, time: RunTime) -> &'static str {
        match self {
            Self::RunTime => time.label(),
            Self::UploadBytes => "to the GPU a frame (KiB)",
        }
    }
}

impl ErrorColumn {
    fn column(self) -> &'static str {
        match self {
            Self::Flip => "flip_mean",
            Self::ScreenError => "screen_error_px_p99",
        }
    }

    fn label(self) -> &'static str {
        match self {
            Self::Flip => "FLIP, mean",
            Self::ScreenError => "screen-space error, 99 % (px)",
        }
    }
}
