use serde::Serialize;
use terrain_core::measure::report::{HtmlReport, Plot, PlotError, Series, SeriesStyle};
use terrain_core::measure::sweep::pareto_front;

use super::super::comparison::{ErrorColumn, distinct};
use super::super::run_summary::{RunSummary, RunTime};

/// Width and height of a plot in pixels.
const SIZE_PX: [u32; 2] = [760, 360];

/// What runs cost against an error they have.
struct Trade {
    cost: Cost,
    error: ErrorColumn,
}

#[derive(Clone, Copy)]
enum Cost {
    RunTime,
    UploadBytes,
}

/// The runs of a flight that no other run beats in both, as `summary.json` holds them.
#[derive(Serialize)]
pub struct ParetoFront {
    flight: String,
    cost: &'static str,
    error: &'static str,
    runs: Vec<String>,
}

/// Run time and bytes, each against both errors.
const ALL: [Trade; 4] = [
    Trade { cost: Cost::RunTime, error: ErrorColumn::FlipMean },
    Trade { cost: Cost::UploadBytes, error: ErrorColumn::FlipMean },
    Trade { cost: Cost::RunTime, error: ErrorColumn::ScreenErrorPxP99 },
    Trade { cost: Cost::UploadBytes, error: ErrorColumn::ScreenErrorPxP99 },
];

/// The Pareto fronts of every flight.
pub fn fronts(runs: &[RunSummary], settle: bool) -> Vec<ParetoFront> {
    let time = RunTime::of(runs, settle);
    let fronts = by_flight(runs).into_iter().flat_map(|(flight, runs)| {
        ALL.iter().map(move |trade| trade.front(flight, &runs, time)).collect::<Vec<_>>()
    });
    fronts.collect()
}

/// The plots of every flight with more than one run: with one there is nothing to trade.
///
/// # Errors
/// Where the drawing library fails.
pub fn add(report: &mut HtmlReport, runs: &[RunSummary], settle: bool) -> Result<(), PlotError> {
    let flights = by_flight(runs);
    if flights.iter().all(|(_, runs)| runs.len() < 2) {
        return Ok(());
    }
    report.heading("Run time and bytes against error");
    let time = RunTime::of(runs, settle);
    for (flight, runs) in flights {
        report.subheading(flight);
        for trade in &ALL {
            report.figure(&trade.svg(&runs, time)?, &trade.caption());
        }
    }
    Ok(())
}

fn by_flight(runs: &[RunSummary]) -> Vec<(&str, Vec<&RunSummary>)> {
    let flights = distinct(runs.iter().map(|run| run.flight.as_str())).into_iter();
    flights
        .map(|flight| (flight, runs.iter().filter(|run| run.flight == flight).collect()))
        .collect()
}

impl Trade {
    /// What the plot shows.
    fn caption(&self) -> String {
        let cost = match self.cost {
            Cost::RunTime => "Median run time of a frame",
            Cost::UploadBytes => "Bytes to the GPU a frame",
        };
        let error = match self.error {
            ErrorColumn::FlipMean => "the mean FLIP error",
            ErrorColumn::ScreenErrorPxP99 => {
                "the screen-space error that 99 in a hundred pixels keep"
            }
        };
        format!("{cost} against {error}. The line joins the runs that no other beats in both.")
    }

    fn front(&self, flight: &str, runs: &[&RunSummary], time: RunTime) -> ParetoFront {
        let cost = match self.cost {
            Cost::RunTime => time.column(),
            Cost::UploadBytes => "upload_bytes_a_frame",
        };
        let front = pareto_front(&self.points(runs, time));
        let runs = front.into_iter().map(|index| runs[index].run.clone()).collect();
        ParetoFront { flight: flight.to_owned(), cost, error: self.error.column(), runs }
    }

    /// The plot: a dot a run, in the colour of its strategy where there are several, and the front.
    fn svg(&self, runs: &[&RunSummary], time: RunTime) -> Result<String, PlotError> {
        let points = self.points(runs, time);
        let front = pareto_front(&points).into_iter().map(|index| points[index]).collect();
        let front =
            Series { name: "Pareto front".into(), points: front, style: SeriesStyle::Dashed };
        let strategies = distinct(runs.iter().map(|run| run.strategy.as_str()));
        let group = |run: &RunSummary| match strategies.len() {
            1 => run.run.clone(),
            _ => run.strategy.to_owned(),
        };
        let dots = distinct(runs.iter().map(|run| group(run))).into_iter().map(|name| {
            let of_group = runs.iter().zip(&points).filter(|(run, _)| group(run) == name);
            let points = of_group.map(|(_, point)| *point).collect();
            Series { name, points, style: SeriesStyle::Points }
        });
        let plot = Plot {
            x_label: self.cost.label(time).into(),
            y_label: self.error.label().into(),
            series: std::iter::once(front).chain(dots).collect(),
            ..Default::default()
        };
        plot.to_svg(SIZE_PX)
    }

    fn points(&self, runs: &[&RunSummary], time: RunTime) -> Vec<[f64; 2]> {
        let cost = |run: &RunSummary| match self.cost {
            Cost::RunTime => time.median_ms(run),
            Cost::UploadBytes => run.later_upload_kib(),
        };
        runs.iter().map(|run| [cost(run), run.error(self.error.column())]).collect()
    }
}

impl Cost {
    fn label(self, time: RunTime) -> &'static str {
        match self {
            Self::RunTime => time.label(),
            Self::UploadBytes => "to the GPU a frame (KB)",
        }
    }
}
