//! `terrain compare`: what frames of a flight cost and how far they are from the exact picture.

mod comparison;
mod course;
mod exact_pictures;
mod film_strip;
mod page;
mod plans;
mod run_summary;
mod variant;
mod worst_frames;
mod write;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, ensure};
use clap::Args;
use terrain_core::dataset::{Dataset, DelayedSource, HeightEncoding, Manifest, Shape, TileSource};
use terrain_core::gpu::{AdapterChoice, GpuContext};
use terrain_core::measure::sweep::{Knob, Sweep};
use terrain_core::measure::{Flight, PlannedFlight};
use terrain_core::selection::Strategy;

use self::comparison::ErrorColumn;
use self::course::{Course, Rules, RunResult};
use self::exact_pictures::ExactPictures;
use self::page::{Page, Scene};
use self::plans::RunPlan;
use self::variant::{Variant, VariantList};
use crate::arg_values::positive;
use crate::commands::fly::frames_to_draw;
use crate::drawing_args::{DrawingArgs, Size};
use crate::headless::{Headless, Pace};
use crate::interrupt::flag_on_ctrl_c;
use crate::progress::FrameProgress;
use crate::{flights, output};

/// More runs than so many keep their worst frame alone, or none.
const FEW_RUNS: usize = 3;
const MANY_RUNS: usize = 24;
/// Worst frames that each of few runs keeps.
const WORST_KEPT: usize = 3;

/// What stands for all flights, and for all strategies.
const ALL: &str = "all";

/// Settings that every strategy is swept through to find its cost at an error.
const QUALITIES: [&str; 7] = ["0.5", "0.71", "1", "1.41", "2", "2.83", "4"];

/// What to compare.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  terrain compare alps --flight valley --out comparison
  terrain compare alps --flights all --strategies all --equal-error --settle --only-measured \\
      --error-every 60 --out table
  terrain compare alps --sweep texel-px=0.5,1,2,4 --frames-at 60 --error-every 6 --out sweep
  terrain compare alps --sweep dataset=alps-bc7,alps-jpeg --settle --out encodings

Knobs of a sweep, and a value of each:
  texel-px=1               pixels a texel may fill before its tile is split
  detail=0.5               texel-px and triangle-px together, in multiples of what they are
  cache=6x6                slots of the caches, and with them the most tiles of a selection
  triangle-px=8            size of the mesh's triangles in pixels
  coordinate-size=160x90   size of the coordinate pass
  readback-latency=2       frames that the region in view is held back before it is used
  visibility=exact         what counts as visible for rtt-quadtree: box or exact
  shortening=least-error   which tiles are merged where there are too many: farthest or least-error
  dataset=FOLDER           another dataset of the same ground, for instance in another encoding;
                           errors are still measured against DATASET")]
pub struct CompareArgs {
    /// The dataset, a folder made by terrain prepare; exact pictures are taken of it
    dataset: PathBuf,

    /// The flights to fly, with commas between them: files, or tour, forward-low, forward-high, spin,
    /// orbit, climb-and-descend, valley, teleport, hover; `all` is all of these but the tour
    #[arg(
        long,
        visible_alias = "flight",
        value_name = "FILE.json|NAME,..",
        value_delimiter = ',',
        default_value = "tour"
    )]
    flights: Vec<PathBuf>,

    /// How tiles are selected, a run each, with commas between them; `all` is every strategy. A name may
    /// be followed by +exact and +least-error, settings for it alone: rtt-quadtree+exact [default: that
    /// of --strategy]
    #[arg(long, value_name = "STRATEGY,..", conflicts_with = "strategy")]
    strategies: Option<VariantList>,

    /// Fly once for each value of a knob
    #[arg(long, value_name = "KNOB=V,V,..")]
    sweep: Option<Sweep>,

    /// Compare costs at equal error: each strategy is swept, by --sweep or through texel-px=0.5 to 4, and
    /// its cost taken at the tightest errors that all of them reach on a flight
    #[arg(long)]
    equal_error: bool,

    /// The mean FLIP error to compare costs at, instead of the tightest
    #[arg(long, value_name = "FLIP", requires = "equal_error", value_parser = positive())]
    at_flip: Option<f64>,

    /// The screen-space error (pixels, 99 %) to compare costs at, instead of the tightest
    #[arg(long, value_name = "PIXELS", requires = "equal_error", value_parser = positive())]
    at_screen_error: Option<f64>,

    /// The folder for frames.csv, summary.json, report.html and pictures of the worst frames
    #[arg(long, value_name = "DIR")]
    out: PathBuf,

    /// Width and height of the pictures
    #[arg(long, value_name = "WxH", default_value = "1280x720")]
    size: Size,

    /// Fly only these seconds of each flight, at its own rate of frames
    #[arg(long, value_name = "FROM..TO", value_parser = seconds)]
    seconds: Option<Seconds>,

    /// Draw only this many frames, evenly spread over the flight
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    frames_at: Option<u64>,

    /// Measure the error of every N-th frame drawn
    #[arg(long, value_name = "N", default_value_t = 60, value_parser = clap::value_parser!(u64).range(1..))]
    error_every: u64,

    /// Wait in every frame until nothing is missing: the same tiles and bytes on every run
    #[arg(long)]
    settle: bool,

    /// Wait before every frame for what earlier frames asked for, but not until nothing is missing (the
    /// first frame does): what a flight shows and sends, the same on every run
    #[arg(long, conflicts_with = "settle")]
    in_step: bool,

    /// Tiles come this many frames after they were asked for at the earliest, as from a slow disk or
    /// over a network
    #[arg(long, value_name = "FRAMES", default_value_t = 0, value_parser = clap::value_parser!(u32).range(..=600))]
    load_delay: u32,

    /// Draw only the frames whose error is measured; of all others choose, load and send tiles: the same
    /// tiles and bytes in less time, but no times of frames (with --settle or --in-step)
    #[arg(long)]
    only_measured: bool,

    /// Fly every flight a second time with what the first has left in memory
    #[arg(long)]
    warm: bool,

    #[command(flatten)]
    drawing: DrawingArgs,
}

/// A part of a flight.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Seconds {
    from_s: f64,
    to_s: f64,
}

impl Seconds {
    /// The frames of the flight within the part, or `wanted` spread evenly over them.
    fn frames(self, flight: &Flight, wanted: Option<u64>) -> Vec<u64> {
        let [begins_s, _] = flight.time_range_s();
        let is_within = |frame: &u64| {
            let time_s = flight.frame_time_s(*frame) - begins_s;
            (self.from_s..=self.to_s).contains(&time_s)
        };
        let within = (0..flight.frame_count()).filter(is_within).collect::<Vec<_>>();
        let chosen = frames_to_draw(within.len() as u64, wanted);
        chosen.into_iter().filter_map(|index| within.get(index as usize).copied()).collect()
    }
}

fn seconds(text: &str) -> Result<Seconds, String> {
    let parts = text.split_once("..").and_then(|(from, to)| {
        Some(Seconds { from_s: from.trim().parse().ok()?, to_s: to.trim().parse().ok()? })
    });
    let parts = parts.filter(|part| 0.0 <= part.from_s && part.from_s <= part.to_s);
    parts.ok_or_else(|| "give two times in seconds, such as 4..6".to_owned())
}

/// Flies, measures and writes the report.
pub fn run(args: &CompareArgs, adapter: &AdapterChoice) -> anyhow::Result<()> {
    let pace = args.pace();
    ensure!(
        pace != Pace::Free || !args.only_measured,
        "--only-measured: frames that do not wait need the time their pictures take; add --in-step or \
         --settle"
    );
    let source: Arc<dyn TileSource> = Arc::new(Dataset::open(&args.dataset)?);
    let gpu = Arc::new(GpuContext::headless(adapter)?);
    let settings =
        args.drawing.settings(source.manifest().shape, 1.0).for_adapter(gpu.is_software());
    let strategies = match &args.strategies {
        None => vec![settings.strategy.into()],
        Some(list) => list.0.clone(),
    };
    let draws_globe = |variant: &Variant| variant.strategy() == Strategy::PageTable;
    ensure!(
        source.manifest().shape == Shape::Plane || strategies.iter().all(draws_globe),
        "the exact pictures of a globe are those of page-table alone: the other strategies draw it as a map"
    );
    let sweep = args.sweep();
    let plans = plans::plans(&strategies, sweep.as_ref(), &source, settings)?;
    let courses = courses(args, &*source, settings.vertical_exaggeration, plans.len())?;
    // Before the work, so that a folder that cannot be made costs none.
    std::fs::create_dir_all(&args.out)
        .with_context(|| format!("{}: cannot make the folder", args.out.display()))?;
    let mut exact = ExactPictures::new(Arc::clone(&source), &settings)?;
    let runs = fly_all(&courses, &plans, args.load_delay, &gpu, &mut exact)?;
    let scene = Scene {
        dataset: name_of(&args.dataset),
        encoding: encoding(source.manifest()),
        flights: courses.iter().map(|course| course.name.clone()).collect(),
        adapter: gpu.adapter_name(),
        is_software: gpu.is_software(),
        size_px: args.size.0,
        pace: args.pace(),
        load_delay_frames: args.load_delay,
        error_every: args.error_every,
        only_measured: args.only_measured,
        knob: sweep.map(|sweep| sweep.knob),
        equal_errors: args.equal_errors(),
    };
    let page = Page::new(scene, runs);
    write::write_all(&args.out, &page)?;
    output::print(&page.text())
}

/// The source with its tiles so many frames late.
fn delayed(source: &Arc<dyn TileSource>, delay_frames: u32) -> Arc<dyn TileSource> {
    match delay_frames {
        0 => Arc::clone(source),
        _ => Arc::new(DelayedSource { source: Arc::clone(source), delay_frames }),
    }
}

/// Every run of every flight; each begins with empty caches.
fn fly_all(
    courses: &[Course],
    plans: &[RunPlan],
    delay_frames: u32,
    gpu: &Arc<GpuContext>,
    exact: &mut ExactPictures,
) -> anyhow::Result<Vec<RunResult>> {
    let frames = courses.iter().map(Course::frame_count).sum::<u64>();
    let progress = FrameProgress::new(plans.len() as u64 * frames);
    let (mut done, mut runs) = (0, Vec::new());
    for course in courses {
        exact.begin_flight();
        for plan in plans {
            let source = delayed(&plan.source, delay_frames);
            let size_px = course.rules.size_px;
            let mut headless = Headless::on(Arc::clone(gpu), source, plan.settings, size_px)?;
            runs.push(course.fly(plan, &mut headless, exact, &mut || {
                done += 1;
                progress.advance(done);
            })?);
        }
    }
    progress.finish();
    Ok(runs)
}

impl CompareArgs {
    fn pace(&self) -> Pace {
        match (self.settle, self.in_step) {
            (true, _) => Pace::Settled,
            (_, true) => Pace::InStep,
            _ => Pace::Free,
        }
    }

    /// What is swept, if anything.
    fn sweep(&self) -> Option<Sweep> {
        let qualities =
            || Sweep { knob: Knob::TexelPx, values: QUALITIES.map(str::to_owned).to_vec() };
        self.sweep.clone().or_else(|| self.equal_error.then(qualities))
    }

    /// Errors to compare costs at, with those that are given.
    fn equal_errors(&self) -> Vec<(ErrorColumn, Option<f64>)> {
        if !self.equal_error {
            return Vec::new();
        }
        vec![
            (ErrorColumn::FlipMean, self.at_flip),
            (ErrorColumn::ScreenErrorPxP99, self.at_screen_error),
        ]
    }
}

/// The flights asked for.
fn courses(
    args: &CompareArgs,
    source: &dyn TileSource,
    exaggeration: f64,
    runs_a_flight: usize,
) -> anyhow::Result<Vec<Course>> {
    let names = match args.flights.as_slice() {
        [all] if all.as_os_str() == ALL => {
            PlannedFlight::measuring().map(|flight| flight.name().into()).collect()
        }
        names => names.to_vec(),
    };
    let rules = Rules {
        size_px: args.size.0,
        error_every: args.error_every,
        pace: args.pace(),
        only_measured: args.only_measured,
        warm: args.warm,
        worst_kept: match names.len() * runs_a_flight {
            runs if runs <= FEW_RUNS => WORST_KEPT,
            runs => usize::from(runs <= MANY_RUNS),
        },
        cancelled: flag_on_ctrl_c()?,
    };
    let course = |path: &PathBuf| {
        let flight = flights::find(path, source, exaggeration)?;
        let frames = match args.seconds {
            None => frames_to_draw(flight.frame_count(), args.frames_at),
            Some(seconds) => seconds.frames(&flight, args.frames_at),
        };
        ensure!(!frames.is_empty(), "{} is over by then: see --seconds", path.display());
        Ok(Course { name: name_of(path), flight, frames, rules: rules.clone() })
    };
    let courses = names.iter().map(course).collect::<anyhow::Result<Vec<_>>>()?;
    let names = courses.iter().map(|course| course.name.as_str());
    plans::check_names("flights", names)?;
    Ok(courses)
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// How the tiles are stored, in words.
fn encoding(manifest: &Manifest) -> String {
    let heights = match manifest.heights.encoding {
        HeightEncoding::Steps => format!("16-bit steps of {} m", manifest.heights.step_m),
        HeightEncoding::Float => "32-bit floats".to_owned(),
    };
    let imagery = match &manifest.colours {
        None => "there is no imagery".to_owned(),
        Some(colours) => {
            let (stored, on_gpu) = (colours.encoding, colours.format);
            format!("imagery as {stored:?}, on the GPU {on_gpu:?}").replace("Rgba8", "RGBA8")
        }
    };
    format!("heights as {heights}, {imagery}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_of_a_flight_are_the_frames_within_them() {
        let view = terrain_core::CameraView {
            eye: glam::DVec3::new(0.0, 0.0, 100.0),
            heading_deg: 0.0,
            pitch_deg: 0.0,
            fov_y_deg: 50.0,
            viewport_px: [16, 9],
        };
        let keyframes = [0.0, 2.0].map(|t| terrain_core::measure::Keyframe::of_view(t, &view));
        let flight = Flight::new("EPSG:3395", 10.0, keyframes.to_vec()).unwrap();
        let frames = |text: &str, wanted| seconds(text).map(|part| part.frames(&flight, wanted));
        assert_eq!(frames("0.5..0.8", None), Ok(vec![5, 6, 7, 8]));
        assert_eq!(frames("0.5..0.8", Some(2)), Ok(vec![5, 8]));
        assert_eq!(frames("7..9", None), Ok(Vec::new()));
        for wrong in ["", "3", "4..3", "-1..2", "a..b", "0..NaN"] {
            assert!(seconds(wrong).is_err(), "{wrong}");
        }
    }
}
