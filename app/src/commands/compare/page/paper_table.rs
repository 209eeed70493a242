use terrain_core::measure::equal_error::CostAt;
use terrain_core::measure::report::HtmlReport;

use super::super::comparison::{Comparison, Cost, ErrorColumn};
use super::super::run_summary::{RunSummary, RunTime};
use super::Scene;

/// Table 1 of Liu Hao et al., with the ratio of its bandwidths.
const PUBLISHED: [[&str; 4]; 3] = [
    ["CPU: view-dependent level of detail, after Hoppe", "712.45", "5.39", "32"],
    ["geometry clipmap", "348.36", "2.63", "62"],
    ["tile scheduling", "132.24", "1.00", "91"],
];

const PUBLISHED_NOTE: &str = "Liu Hao et al., “Dynamic Scheduling and Real-time Rendering Method for \
    Large-Scale Terrain”, table 1: 8000 × 8000 heights and a picture of 24000 × 24000, a cache of \
    6 × 6 tiles of 128 × 128 and 384 × 384 texels, Intel E8500, GeForce 9800 GTX. The paper fixes \
    no error and tells neither the flight nor the encoding of its tiles.";

/// Bytes and times of strategies beside one another and beside the paper's.
pub fn add(
    report: &mut HtmlReport,
    scene: &Scene,
    runs: &[RunSummary],
    comparisons: &[Comparison],
) {
    report.heading("Bandwidth and frame rate");
    report.paragraph(
        "The table of the tile-scheduling paper. To the GPU: all bytes sent, whatever for; both ways: \
         those and what is read back. A KB has 1024 bytes. Means over the frames of a flight, and over \
         the flights.",
    );
    let time = RunTime::of(runs, scene.settles());
    for comparison in comparisons {
        report.subheading(title(comparison));
        match comparison.equal {
            None => add_as_given(report, scene, runs, comparison, time),
            Some(_) => add_at_equal(report, comparison, time),
        }
        if comparison.flights.len() > 1 || comparison.equal.is_some() {
            add_flights(report, comparison);
        }
    }
    report.subheading("As published");
    let header = ["algorithm", "KB a frame", "times tile scheduling", "frames a second"];
    report.table(&header, &PUBLISHED).paragraph(PUBLISHED_NOTE);
}

/// Mean bytes at equal error for the terminal: a line a strategy.
pub fn lines(comparison: &Comparison) -> String {
    let line = |strategy| {
        let [name, upload, times, both, both_times] = &row(comparison, strategy)[..5] else {
            return String::new();
        };
        let title = title(comparison);
        format!(
            "{title}: {name} {upload} KiB to the GPU a frame (times {times}), {both} both ways \
             (times {both_times})\n"
        )
    };
    (0..comparison.strategies.len()).map(line).collect()
}

fn title(comparison: &Comparison) -> &'static str {
    match comparison.equal {
        None => "With the settings given: each with an error of its own",
        Some(ErrorColumn::FlipMean) => "At equal FLIP",
        Some(ErrorColumn::ScreenErrorPxP99) => "At equal screen-space error",
    }
}

fn add_as_given(
    report: &mut HtmlReport,
    scene: &Scene,
    runs: &[RunSummary],
    comparison: &Comparison,
    time: RunTime,
) {
    let mut header = header(time);
    header.extend(["frames a second", "FLIP", "screen-space error (px)"].map(str::to_owned));
    let rows = (0..comparison.strategies.len()).map(|strategy| {
        let name = &comparison.strategies[strategy];
        let typical = runs.iter().filter(|run| run.is_typical && run.strategy == *name);
        let typical = typical.collect::<Vec<_>>();
        let mean = |value: &dyn Fn(&RunSummary) -> f64| {
            typical.iter().map(|run| value(run)).sum::<f64>() / typical.len() as f64
        };
        let mut row = row(comparison, strategy);
        let flown = !scene.settles();
        row.push(number(flown.then(|| mean(&RunSummary::frames_a_second)), 1));
        row.push(number(Some(mean(&|run| run.error("flip_mean"))), 4));
        row.push(number(Some(mean(&|run| run.error("screen_error_px_p99"))), 2));
        row
    });
    report.table(&header, &rows.collect::<Vec<_>>());
    scene.add_rate_notes(report);
}

fn add_at_equal(report: &mut HtmlReport, comparison: &Comparison, time: RunTime) {
    let rows = (0..comparison.strategies.len()).map(|strategy| row(comparison, strategy));
    report.table(&header(time), &rows.collect::<Vec<_>>());
    report.paragraph(
        "Each strategy is swept through its settings, and its cost taken at the one error of the flight \
         (below; where none was given, 2 % above the tightest that all reach), between two settings by a monotone curve, logarithm over logarithm, through those that \
         no other beats. Nothing is extrapolated: “not reached” where no setting is as exact, “≤” where \
         the coarsest setting is more exact still. Means are over the flights on which every strategy \
         reaches the error. Bytes are those of the frames after the first, which fills empty caches and \
         is shown by itself below.",
    );
}

fn header(time: RunTime) -> Vec<String> {
    let columns =
        ["strategy", "to the GPU (KB a frame)", "times", "both ways (KB a frame)", "times"];
    columns.into_iter().chain([time.label()]).map(str::to_owned).collect()
}

/// The strategy's mean costs.
fn row(comparison: &Comparison, strategy: usize) -> Vec<String> {
    let upload: Cost = |costs| costs.upload_kib;
    let both_ways: Cost = |costs| costs.both_ways_kib;
    let mut row = vec![comparison.strategies[strategy].to_owned()];
    for cost in [upload, both_ways] {
        row.push(shown(comparison.mean(strategy, cost), 2));
        row.push(number(comparison.ratio(strategy, cost), 2));
    }
    row.push(shown(comparison.mean(strategy, |costs| costs.run_time_ms), 2));
    row
}

/// KB to the GPU a frame, a row a flight.
fn add_flights(report: &mut HtmlReport, comparison: &Comparison) {
    let error = comparison.equal.map(ErrorColumn::label);
    let header = ["flight, KB to the GPU a frame"].into_iter().chain(error);
    let header = header.chain(comparison.strategies.iter().map(String::as_str)).collect::<Vec<_>>();
    let rows = comparison.flights.iter().map(|flight| {
        let error = comparison
            .equal
            .map(|column| flight.error.map_or_else(|| "–".to_owned(), |error| column.shown(error)));
        let costs = flight.costs.iter().map(|costs| shown(costs.upload_kib, 2));
        [flight.flight.clone()].into_iter().chain(error).chain(costs).collect::<Vec<_>>()
    });
    report.table(&header, &rows.collect::<Vec<_>>());
}

fn shown(cost: CostAt, decimals: usize) -> String {
    match cost {
        CostAt::Reached(cost) => number(Some(cost), decimals),
        CostAt::AtMost(cost) => format!("≤ {}", number(Some(cost), decimals)),
        CostAt::NotReached => "not reached".to_owned(),
    }
}

fn number(value: Option<f64>, decimals: usize) -> String {
    match value.filter(|value| value.is_finite()) {
        Some(value) => format!("{value:.decimals$}"),
        None => "–".to_owned(),
    }
}
