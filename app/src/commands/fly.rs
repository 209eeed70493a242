//! `terrain fly`: over a dataset, in a window or measured without one.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, bail};
use clap::Args;
use terrain_core::RendererSettings;
use terrain_core::dataset::{Dataset, TileSource};
use terrain_core::gpu::AdapterChoice;
use terrain_core::measure::{Flight, FrameRecord, PlannedFlight};
use terrain_core::selection::Strategy;

use crate::demo::Demo;
use crate::detail_args::DetailArgs;
use crate::drawing_args::{DrawingArgs, Size, strategies};
use crate::flight_summary::FlightSummary;
use crate::headless::{Headless, Pace};
use crate::progress::FrameProgress;
use crate::scene_args::SceneArgs;
use crate::viewer::{self, ViewerOptions};
use crate::{display, flights, output, pictures};

/// What to fly over, and how.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  terrain fly alps
  terrain fly alps --flight valley
  terrain fly alps --strategy rtt-quadtree --compare cpu-frustum
  terrain fly alps --flight recorded.json --headless --csv frames.csv
  terrain fly earth --strategy page-table --detail 10
  terrain fly alps --headless --settle --frames-at 24 --out pictures")]
pub struct FlyArgs {
    /// The dataset: a folder made by terrain prepare [default: the demo]
    dataset: Option<PathBuf>,

    /// The flight to fly: a file, or one made for the dataset: tour, forward-low, forward-high, spin,
    /// orbit, climb-and-descend, valley, teleport, hover [default: tour]
    #[arg(long, value_name = "FILE.json|NAME")]
    flight: Option<PathBuf>,

    /// Record what is flown in the window to this file; without a window, write the flight itself
    #[arg(long, value_name = "FILE.json")]
    record: Option<PathBuf>,

    /// Close the window when the flight has been flown, unless somebody has taken the controls
    #[arg(long, requires = "flight", conflicts_with = "headless")]
    close_at_end: bool,

    /// Show another strategy beside the chosen one: in a window divided in two
    #[arg(long, value_name = "STRATEGY", conflicts_with = "headless", value_parser = strategies())]
    compare: Option<Strategy>,

    /// Draw the flight without a window
    #[arg(long)]
    headless: bool,

    /// Write a row a frame
    #[arg(long, value_name = "FILE.csv", requires = "headless")]
    csv: Option<PathBuf>,

    /// Write every frame drawn as PNG into this folder
    #[arg(long, value_name = "DIR", requires = "headless")]
    out: Option<PathBuf>,

    /// Wait in every frame until nothing is missing
    #[arg(long, requires = "headless")]
    settle: bool,

    /// Draw only this many frames, evenly spread over the flight
    #[arg(long, value_name = "N", requires = "headless", value_parser = clap::value_parser!(u64).range(1..))]
    frames_at: Option<u64>,

    /// Print the summary as JSON
    #[arg(long, requires = "headless")]
    json: bool,

    /// Width and height of the pictures without a window
    #[arg(long, value_name = "WxH", default_value = "1280x720")]
    size: Size,

    #[command(flatten)]
    detail: DetailArgs,

    #[command(flatten)]
    scene: SceneArgs,

    #[command(flatten)]
    drawing: DrawingArgs,
}

/// What there is to fly over.
struct Scene {
    source: Arc<dyn TileSource>,
    title: String,
    settings: RendererSettings,
    /// The flight asked for; the demo has one of its own.
    flight: Option<Flight>,
}

/// Flies in a window, or without one.
pub fn run(args: &FlyArgs, adapter: &AdapterChoice) -> anyhow::Result<()> {
    let scene = open(args)?;
    if args.headless {
        fly_headless(args, adapter, scene)
    } else {
        fly_in_window(args, adapter, scene)
    }
}

fn open(args: &FlyArgs) -> anyhow::Result<Scene> {
    let Some(folder) = &args.dataset else {
        let Demo { source, title, exaggeration, flight } = Demo::open()?;
        let source = args.detail.continued(source)?;
        let settings = args.drawing.settings(source.manifest().shape, exaggeration);
        let flight = asked_flight(args, &*source, &settings)?.unwrap_or(flight);
        return Ok(Scene { source, title, settings, flight: Some(flight) });
    };
    let source = args.detail.continued(Arc::new(Dataset::open(folder)?))?;
    let title = folder.file_name().unwrap_or(folder.as_os_str()).to_string_lossy().into_owned();
    let settings = args.drawing.settings(source.manifest().shape, 1.0);
    let flight = asked_flight(args, &*source, &settings)?;
    Ok(Scene { source, title, settings, flight })
}

fn asked_flight(
    args: &FlyArgs,
    source: &dyn TileSource,
    settings: &RendererSettings,
) -> anyhow::Result<Option<Flight>> {
    let find = |name| flights::find(name, source, settings.vertical_exaggeration);
    args.flight.as_deref().map(find).transpose()
}

fn tour(source: &dyn TileSource, settings: &RendererSettings) -> anyhow::Result<Flight> {
    flights::plan(PlannedFlight::Tour, source, settings.vertical_exaggeration)
}

fn fly_in_window(args: &FlyArgs, adapter: &AdapterChoice, scene: Scene) -> anyhow::Result<()> {
    if display::display().is_none() {
        bail!(
            "no display for a window: neither WAYLAND_DISPLAY nor DISPLAY is set \
             (--headless with --csv or --out draws the flight without one)"
        );
    }
    let Scene { source, title, settings, flight } = scene;
    let plays_at_once = flight.is_some();
    let flight = flight.or_else(|| tour(&*source, &settings).ok());
    viewer::run(ViewerOptions {
        objects: args.scene.open(&*source)?,
        source,
        title,
        adapter: adapter.clone(),
        settings,
        compare_with: args.compare,
        flight,
        plays_at_once,
        closes_at_end: args.close_at_end,
        record_to: args.record.clone(),
    })
}

fn fly_headless(args: &FlyArgs, adapter: &AdapterChoice, scene: Scene) -> anyhow::Result<()> {
    let Scene { source, settings, flight, .. } = scene;
    let flight = match flight {
        Some(flight) => flight,
        None => tour(&*source, &settings)?,
    };
    if let Some(path) = &args.record {
        flight.write(path)?;
    }
    let objects = args.scene.open(&*source)?;
    let mut headless = Headless::open(source, adapter, settings, args.size.0)?;
    headless.add(&objects)?;
    let mut csv = args.csv.as_deref().map(CsvFile::create).transpose()?;
    if let Some(folder) = &args.out {
        let failed = || format!("{}: cannot make the folder", folder.display());
        std::fs::create_dir_all(folder).with_context(failed)?;
    }
    let frames = frames_to_draw(flight.frame_count(), args.frames_at);
    let pace = if args.settle { Pace::Settled } else { Pace::Free };
    let mut summary = FlightSummary::default();
    let progress = FrameProgress::new(frames.len() as u64);
    for (index, frame) in frames.into_iter().enumerate() {
        let time_s = flight.frame_time_s(frame);
        let view = flight.view_at(time_s, args.size.0);
        let mut record = headless.draw(&view, pace)?;
        (record.frame, record.time_s) = (frame, time_s);
        summary.add(&record);
        if let Some(csv) = &mut csv {
            csv.write(&record)?;
        }
        if let Some(folder) = &args.out {
            let path = folder.join(format!("frame-{frame:05}.png"));
            pictures::write_png(&path, args.size.0, &headless.picture()?)?;
        }
        progress.advance(index as u64 + 1);
    }
    progress.finish();
    if let Some(csv) = csv {
        csv.finish()?;
    }
    let json = args.json.then(|| serde_json::to_string_pretty(&summary)).transpose()?;
    output::print(&json.map_or_else(|| summary.page(), |json| Ok(json + "\n"))?)
}

/// The frames to draw: all of them, or `wanted` spread evenly from the first to the last.
pub fn frames_to_draw(count: u64, wanted: Option<u64>) -> Vec<u64> {
    let wanted = wanted.unwrap_or(count).min(count);
    if wanted <= 1 {
        return vec![0];
    }
    (0..wanted).map(|index| index * (count - 1) / (wanted - 1)).collect()
}

/// `frames.csv` while it is written.
struct CsvFile {
    path: PathBuf,
    file: std::io::BufWriter<std::fs::File>,
}

impl CsvFile {
    fn create(path: &Path) -> anyhow::Result<Self> {
        let file = std::fs::File::create(path)
            .with_context(|| format!("{}: cannot write the table", path.display()))?;
        let mut csv = Self { path: path.to_owned(), file: std::io::BufWriter::new(file) };
        csv.line(&FrameRecord::csv_header())?;
        Ok(csv)
    }

    fn write(&mut self, record: &FrameRecord) -> anyhow::Result<()> {
        self.line(&record.csv_row())
    }

    fn line(&mut self, text: &str) -> anyhow::Result<()> {
        let written = writeln!(self.file, "{text}");
        written.with_context(|| format!("{}: cannot write the table", self.path.display()))
    }

    fn finish(mut self) -> anyhow::Result<()> {
        let written = self.file.flush();
        written.with_context(|| format!("{}: cannot write the table", self.path.display()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_spread_from_the_first_to_the_last() {
        assert_eq!(frames_to_draw(4, None), [0, 1, 2, 3]);
        assert_eq!(frames_to_draw(101, Some(5)), [0, 25, 50, 75, 100]);
        assert_eq!(frames_to_draw(3, Some(10)), [0, 1, 2]);
        assert_eq!(frames_to_draw(7, Some(1)), [0]);
    }
}
