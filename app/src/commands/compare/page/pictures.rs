use terrain_core::measure::report::{HtmlReport, ReportPicture};

use super::super::comparison::distinct;
use super::super::course::RunResult;
use super::super::worst_frames::WorstFrame;

/// More runs than this show their worst frame alone.
const MANY_RUNS: usize = 3;

/// A film strip of each run that stands for its strategy.
pub fn add_strips(report: &mut HtmlReport, runs: &[RunResult]) {
    report.heading("Film strips");
    report.paragraph(
        "Frames spread over the flight, once nothing is missing, with the borders of the tiles that each \
         pixel is drawn from.",
    );
    let has_flights = distinct(runs.iter().map(|run| &run.flight)).len() > 1;
    for run in runs.iter().filter(|run| !run.strip.is_empty()) {
        let flight = if has_flights { format!("{}, ", run.flight) } else { String::new() };
        let pictures = run.strip.iter().enumerate().map(|(place, picture)| {
            let time = format!("{:.1} s", run.records[picture.index].time_s);
            let named = format!("{flight}{}, {time}", run.name);
            ReportPicture {
                png: picture.png.clone(),
                caption: if place == 0 { named } else { time },
            }
        });
        report.pictures(&pictures.collect::<Vec<_>>());
    }
}

/// The worst frames: of few runs several each, of one flight one a run, of many flights one a strategy.
///
/// # Errors
/// Where a picture cannot be made.
pub fn add_worst_frames(report: &mut HtmlReport, runs: &[RunResult]) -> anyhow::Result<()> {
    report.heading("The worst frames");
    report.paragraph(
        "Those with the greatest mean FLIP error: the picture as drawn, the exact one, and the FLIP \
         error of each pixel from black (0) through purple and orange to pale yellow (1).",
    );
    for (run, frame) in shown(runs) {
        let what = format!("{}, {}, {:.2} s", run.name, run.flight, frame.time_s);
        let captions = [what, "exact".into(), format!("FLIP error, mean {:.4}", frame.flip_mean)];
        let panels = frame.page_panels()?.into_iter().zip(captions);
        let row = panels.map(|(png, caption)| ReportPicture { png, caption });
        report.pictures(&row.collect::<Vec<_>>());
    }
    Ok(())
}

fn shown(runs: &[RunResult]) -> Vec<(&RunResult, &WorstFrame)> {
    let frames = |run| RunResult::worst_with_run(run);
    if runs.len() <= MANY_RUNS {
        return runs.iter().flat_map(frames).collect();
    }
    if distinct(runs.iter().map(|run| &run.flight)).len() == 1 {
        return runs.iter().flat_map(|run| frames(run).take(1)).collect();
    }
    // Many runs with all their pictures would make a page too large to send.
    let worst_of = |strategy| {
        let all = runs.iter().filter(move |run| run.strategy == strategy).flat_map(frames);
        all.max_by(|a, b| a.1.flip_mean.total_cmp(&b.1.flip_mean))
    };
    distinct(runs.iter().map(|run| run.strategy.as_str()))
        .into_iter()
        .filter_map(worst_of)
        .collect()
}

impl RunResult {
    fn worst_with_run(&self) -> impl Iterator<Item = (&Self, &WorstFrame)> {
        self.worst.iter().map(move |frame| (self, frame))
    }
}
