use terrain_core::measure::FrameRecord;
use terrain_core::measure::report::{HtmlReport, Plot, PlotError, Series, SeriesStyle};

use super::super::comparison::distinct;
use super::super::course::RunResult;
use super::Scene;

/// Width and height of a plot in pixels.
const SIZE_PX: [u32; 2] = [760, 260];

/// What is plotted over a flight.
struct Curve {
    caption: &'static str,
    label: &'static str,
    value: fn(&FrameRecord) -> f64,
}

const FRAME_RATE: Curve = Curve {
    caption: "Frame rate over the flight, measuring left out.",
    label: "frames a second",
    value: |record| 1000.0 / record.frame_ms,
};

const CPU_LOAD: Curve = Curve {
    caption: "Load of the CPU over the flight: the part of each frame's time that its one thread works.",
    label: "CPU load (%)",
    value: |record| 100.0 * record.cpu_ms / record.frame_ms,
};

const CPU_TIME: Curve = Curve {
    caption: "CPU time of each frame: that of all the frames it took to settle.",
    label: "CPU time a frame (ms)",
    value: |record| record.cpu_ms,
};

const UPLOAD: Curve = Curve {
    caption: "Bytes to the GPU in each frame, by any cause.",
    label: "to the GPU (KB)",
    value: |record| record.upload_bytes as f64 / 1024.0,
};

const FLIP: Curve = Curve {
    caption: "Mean FLIP error of the measured frames.",
    label: "FLIP, mean",
    value: |record| record.errors.flip_mean.unwrap_or(f64::NAN),
};

const SCREEN_ERROR: Curve = Curve {
    caption: "Screen-space error that 99 in a hundred pixels of a measured frame keep.",
    label: "screen-space error, 99 % (px)",
    value: |record| record.errors.screen_error_px_p99.unwrap_or(f64::NAN),
};

/// What frames cost and how exact they are over each flight. Where strategies were swept, a curve
/// each; otherwise one a run.
///
/// # Errors
/// Where the drawing library fails.
pub fn add(report: &mut HtmlReport, scene: &Scene, runs: &[RunResult]) -> Result<(), PlotError> {
    report.heading("Over the flights");
    scene.add_rate_notes(report);
    let costs: &[Curve] =
        if scene.settles() { &[CPU_TIME, UPLOAD] } else { &[FRAME_RATE, CPU_LOAD, UPLOAD] };
    let many_strategies = distinct(runs.iter().map(|run| run.strategy.as_str())).len() > 1;
    for flight in distinct(runs.iter().map(|run| run.flight.as_str())) {
        report.subheading(flight);
        let shown = |run: &&RunResult| run.flight == flight && (run.is_typical || !many_strategies);
        let shown = runs.iter().filter(shown).collect::<Vec<_>>();
        for curve in costs.iter().chain(&[FLIP, SCREEN_ERROR]) {
            report.figure(&svg(curve, &shown)?, curve.caption);
        }
    }
    Ok(())
}

fn svg(curve: &Curve, runs: &[&RunResult]) -> Result<String, PlotError> {
    let series = runs.iter().map(|run| {
        let points = run.records.iter().map(|record| [record.time_s, (curve.value)(record)]);
        // Between measured frames nothing is known; the line leads from one to the next.
        let points = points.filter(|point| point[1].is_finite()).collect();
        Series { name: run.name.clone(), points, style: SeriesStyle::Line }
    });
    let plot = Plot {
        x_label: "time in the flight (s)".into(),
        y_label: curve.label.into(),
        series: series.collect(),
        ..Default::default()
    };
    plot.to_svg(SIZE_PX)
}
