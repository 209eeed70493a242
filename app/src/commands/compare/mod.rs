//! `terrain compare`: what frames of a flight cost and how far they are from the exact picture.

mod course;
mod exact_pictures;
mod page;
mod run_summary;
mod sweep_plots;
mod worst_frames;
mod write;

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, ensure};
use clap::Args;
use terrain_core::RendererSettings;
use terrain_core::dataset::{Dataset, TileSource};
use terrain_core::gpu::AdapterChoice;
use terrain_core::measure::sweep::{Knob, Sweep};
use terrain_core::measure::{Flight, PlannedFlight};
use terrain_core::selection::Strategy;

use self::course::{Course, RunPlan};
use self::exact_pictures::ExactPictures;
use self::page::{Page, Scene};
use crate::commands::fly::frames_to_draw;
use crate::drawing_args::{DrawingArgs, Size, strategies};
use crate::interrupt::flag_on_ctrl_c;
use crate::progress::FrameProgress;
use crate::{flights, output};

/// What to compare.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  terrain compare alps --flight valley.json --out comparison
  terrain compare alps --sweep texel-px=0.5,1,2,4 --frames-at 60 --error-every 6 --out sweep
  terrain compare alps --sweep dataset=alps-bc7,alps-jpeg --settle --out encodings

Knobs of a sweep, and a value of each:
  texel-px=1               pixels a texel may fill before its tile is split
  cache=6x6                slots of the caches, and with them the most tiles of a selection
  triangle-px=8            size of the mesh's triangles in pixels
  coordinate-size=160x90   size of the coordinate pass
  readback-latency=2       frames that the region in view is held back before it is used
  dataset=FOLDER           another dataset of the same ground, for instance in another encoding;
                           errors are still measured against DATASET")]
pub struct CompareArgs {
    /// The dataset, a folder made by terrain prepare; exact pictures are taken of it
    dataset: PathBuf,

    /// The flight to fly [default: a tour of the dataset]
    #[arg(long, value_name = "FILE.json")]
    flight: Option<PathBuf>,

    /// How tiles are selected, a run each, with commas between them [default: that of --strategy]
    #[arg(
        long,
        value_name = "STRATEGY,..",
        value_delimiter = ',',
        value_parser = strategies(),
        conflicts_with = "strategy"
    )]
    strategies: Vec<Strategy>,

    /// Fly once for each value of a knob
    #[arg(long, value_name = "KNOB=V,V,..")]
    sweep: Option<Sweep>,

    /// The folder for frames.csv, summary.json, report.html and pictures of the worst frames
    #[arg(long, value_name = "DIR")]
    out: PathBuf,

    /// Width and height of the pictures
    #[arg(long, value_name = "WxH", default_value = "1280x720")]
    size: Size,

    /// Draw only this many frames, evenly spread over the flight
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    frames_at: Option<u64>,

    /// Measure the error of every N-th frame drawn
    #[arg(long, value_name = "N", default_value_t = 60, value_parser = clap::value_parser!(u64).range(1..))]
    error_every: u64,

    /// Wait in every frame until nothing is missing: the same tiles and bytes on every run
    #[arg(long)]
    settle: bool,

    #[command(flatten)]
    drawing: DrawingArgs,
}

/// Flies, measures and writes the report.
pub fn run(args: &CompareArgs, adapter: &AdapterChoice) -> anyhow::Result<()> {
    let cancelled = flag_on_ctrl_c()?;
    let source: Arc<dyn TileSource> = Arc::new(Dataset::open(&args.dataset)?);
    let settings = args.drawing.settings(1.0);
    let plans = plans(args, &source, settings)?;
    let flight = flight(args, &*source, settings.vertical_exaggeration)?;
    // Before the work, so that a folder that cannot be made costs none.
    std::fs::create_dir_all(&args.out)
        .with_context(|| format!("{}: cannot make the folder", args.out.display()))?;
    let frames = frames_to_draw(flight.frame_count(), args.frames_at);
    let size_px = args.size.0;
    let (error_every, settle) = (args.error_every, args.settle);
    let course = Course { flight, frames, size_px, error_every, settle, cancelled };

    let mut exact = ExactPictures::new(source, &settings)?;
    let progress = FrameProgress::new((plans.len() * course.frames.len()) as u64);
    let (mut done, mut runs, mut adapter_name) = (0, Vec::new(), String::new());
    for plan in plans {
        let mut headless = course.open(&plan, adapter)?;
        adapter_name = headless.adapter_name();
        runs.push(course.fly(plan, &mut headless, &mut exact, &mut || {
            done += 1;
            progress.advance(done);
        })?);
    }
    progress.finish();

    let scene = Scene {
        dataset: name_of(&args.dataset),
        flight: args.flight.as_deref().map(name_of),
        adapter: adapter_name,
        size_px,
        settle,
        error_every,
        knob: args.sweep.as_ref().map(|sweep| sweep.knob),
    };
    let page = Page::new(scene, runs);
    write::write_all(&args.out, &page)?;
    output::print(&page.text())
}

/// A run for each strategy and each value of the knob.
fn plans(
    args: &CompareArgs,
    source: &Arc<dyn TileSource>,
    settings: RendererSettings,
) -> anyhow::Result<Vec<RunPlan>> {
    let strategies = match args.strategies.as_slice() {
        [] => vec![settings.strategy],
        strategies => strategies.to_vec(),
    };
    let mut plans = Vec::new();
    for strategy in strategies {
        let plain = || RunPlan {
            name: strategy.name().to_owned(),
            settings: RendererSettings { strategy, ..settings },
            source: Arc::clone(source),
        };
        let Some(sweep) = &args.sweep else {
            plans.push(plain());
            continue;
        };
        for value in &sweep.values {
            let mut plan = plain();
            plan.settings = sweep.knob.turned(plan.settings, value)?;
            let setting = format!("{}={}", sweep.knob.name(), short_value(sweep, value));
            let many = args.strategies.len() > 1;
            plan.name = if many { format!("{} {setting}", plan.name) } else { setting };
            if sweep.knob == Knob::Dataset {
                plan.source = same_ground(source, Path::new(value))?;
            }
            plans.push(plan);
        }
    }
    check_names(plans.iter().map(|plan| plan.name.as_str()))?;
    Ok(plans)
}

/// Tables, files and plots tell runs apart by their names alone.
fn check_names<'a>(names: impl IntoIterator<Item = &'a str>) -> anyhow::Result<()> {
    let mut seen = HashSet::new();
    for name in names {
        ensure!(seen.insert(name), "two runs would be called {name}: give each value once");
    }
    Ok(())
}

/// Folders are known by their last name, unless another of the sweep has the same.
fn short_value(sweep: &Sweep, value: &str) -> String {
    let last = |value: &str| name_of(Path::new(value));
    let namesakes = sweep.values.iter().filter(|other| last(other) == last(value)).count();
    if sweep.knob == Knob::Dataset && namesakes == 1 { last(value) } else { value.to_owned() }
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// Opens a dataset whose pictures can be compared with those of `source`.
fn same_ground(source: &Arc<dyn TileSource>, folder: &Path) -> anyhow::Result<Arc<dyn TileSource>> {
    let other = Dataset::open(folder)?;
    let (ours, theirs) = (source.manifest(), other.manifest());
    ensure!(
        ours.crs == theirs.crs && ours.data_extent == theirs.data_extent,
        "{}: lies elsewhere than the dataset it is to be compared with",
        folder.display(),
    );
    Ok(Arc::new(other))
}

fn flight(
    args: &CompareArgs,
    source: &dyn TileSource,
    exaggeration: f64,
) -> anyhow::Result<Flight> {
    match &args.flight {
        Some(name) => flights::find(name, source, exaggeration),
        None => flights::plan(PlannedFlight::Tour, source, exaggeration),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_of_one_name_are_refused() {
        assert!(check_names(["a", "b"]).is_ok());
        let error = check_names(["a", "b", "a"]).unwrap_err().to_string();
        assert!(error.contains("called a:"), "{error}");
    }

    #[test]
    fn folders_with_the_same_last_name_keep_their_paths() {
        let sweep = "dataset=x/alps,y/alps,y/jura".parse::<Sweep>().unwrap();
        let names = sweep.values.iter().map(|value| short_value(&sweep, value));
        assert_eq!(names.collect::<Vec<_>>(), ["x/alps", "y/alps", "jura"]);
    }
}
