//! `terrain render`: one picture of a dataset.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use anyhow::Context;
use clap::{ArgGroup, Args};
use glam::{DVec3, dvec2};
use terrain_core::dataset::{Dataset, TileSource};
use terrain_core::gpu::AdapterChoice;
use terrain_core::measure::{CameraSpec, FrameRecord};
use terrain_core::reference::{ReferenceScene, ReferenceSettings, render_reference};
use terrain_core::{CameraView, RendererSettings};

use crate::detail_args::DetailArgs;
use crate::drawing_args::{DrawingArgs, Size};
use crate::ground::Ground;
use crate::headless::{Headless, Pace, true_place};
use crate::progress::{FrameProgress, PhaseProgress};
use crate::scene_args::SceneArgs;
use crate::{flights, npy, output, pictures};

/// What to draw.
#[derive(Debug, Args)]
#[command(group(
    ArgGroup::new("results").required(true).multiple(true).args(["out", "coordinates", "json"])
))]
#[command(after_help = "\
Examples:
  terrain render alps --camera x=463500,y=6820000,agl=800,heading=215,pitch=-12,fov=50 \\
      --size 1280x720 --out view.png
  terrain render alps --camera x=463500,y=6820000,agl=800,heading=215,pitch=-12 \\
      --reference --out exact.png --coordinates exact.npy
  terrain render earth --camera x=8.0,y=46.0,height=900000,pitch=-60 --out alps.png
  terrain render earth --camera x=8.0,y=46.0,height=20000,pitch=-40 --detail 10 --out near.png
  terrain render alps --flight valley --at 7.5 --out valley.png
  terrain render alps --models village.json --camera x=463500,y=6820000,agl=80,pitch=-10 \\
      --out village.png")]
pub struct RenderArgs {
    /// The dataset: a folder made by terrain prepare
    dataset: PathBuf,

    /// The camera: x=..,y=.. in the dataset's CRS (longitude and latitude in degrees for a globe), height=.. (metres above the datum) or agl=..
    /// (above the ground), heading=.. (degrees clockwise from north), pitch=.. (negative looks
    /// down), fov=.. (vertical, degrees)
    #[arg(
        long,
        value_name = "CAMERA",
        allow_hyphen_values = true,
        required_unless_present = "flight"
    )]
    camera: Option<CameraSpec>,

    /// Take the camera of a flight instead: a file, or one made for the dataset: tour, forward-low,
    /// forward-high, spin, orbit, climb-and-descend, valley, teleport, hover
    #[arg(long, value_name = "FILE.json|NAME", conflicts_with = "camera")]
    flight: Option<PathBuf>,

    /// Time in the flight, seconds [default: its beginning]
    #[arg(long, value_name = "SECONDS", requires = "flight", allow_hyphen_values = true)]
    at: Option<f64>,

    /// Width and height of the picture in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720")]
    size: Size,

    /// The PNG file to write
    #[arg(long, value_name = "FILE.png")]
    out: Option<PathBuf>,

    /// Write x, y, z of the ground at each pixel: float64 (height, width, 3), NaN where there is sky; x and y as
    /// a camera's are given
    #[arg(long, value_name = "FILE.npy")]
    coordinates: Option<PathBuf>,

    /// Keep drawing until nothing is missing (the default)
    #[arg(long, conflicts_with = "frames")]
    settle: bool,

    /// Draw exactly this many frames, whatever is missing then
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    frames: Option<u32>,

    /// Trace the exact picture on the CPU instead, from the full-resolution data, to tell how true a
    /// drawn one is; of the options on drawing only --exaggeration counts
    #[arg(long, conflicts_with_all = ["settle", "frames", "json", "models", "tin"])]
    reference: bool,

    /// Print what the frames did and cost, as JSON
    #[arg(long)]
    json: bool,

    #[command(flatten)]
    detail: DetailArgs,

    #[command(flatten)]
    scene: SceneArgs,

    #[command(flatten)]
    drawing: DrawingArgs,
}

/// Draws the picture and writes what is asked for.
pub fn run(args: &RenderArgs, adapter: &AdapterChoice) -> anyhow::Result<()> {
    let source = args.detail.continued(Arc::new(Dataset::open(&args.dataset)?))?;
    // One picture may take its time: drawn as on hardware, whatever the adapter.
    let settings = args.drawing.settings(source.manifest().shape, 1.0).for_adapter(false);
    let view = view_of(args, &*source, settings.vertical_exaggeration)?;
    let shape = source.manifest().shape;
    let drawn = match args.reference {
        true => trace(source, &view, &settings)?,
        false => draw(args, source, &view, adapter, settings)?,
    };
    if let Some(path) = &args.out {
        pictures::write_png(path, args.size.0, &drawn.rgba)?;
    }
    if let Some(path) = &args.coordinates {
        let [width, height] = args.size.0.map(|side| side as usize);
        let points = drawn.ground.into_iter().flat_map(|[x, y, z]| {
            let place = shape.user_from_world(dvec2(x, y));
            [place.x, place.y, z]
        });
        npy::write_f64(path, [height, width, 3], points)?;
    }
    if let Some(record) = drawn.record.filter(|_| args.json) {
        output::print(&(serde_json::to_string_pretty(&record)? + "\n"))?;
    }
    Ok(())
}

/// A picture, however it came about.
struct Drawn {
    /// RGBA, 8 bits a channel, first row on top.
    rgba: Vec<u8>,
    /// The ground at every pixel, in true heights; empty where it is not asked for.
    ground: Vec<[f64; 3]>,
    /// What the frames did; `None` where none were drawn.
    record: Option<FrameRecord>,
}

/// Draws frames on the GPU.
fn draw(
    args: &RenderArgs,
    source: Arc<dyn TileSource>,
    view: &CameraView,
    adapter: &AdapterChoice,
    settings: RendererSettings,
) -> anyhow::Result<Drawn> {
    let objects = args.scene.open(&*source)?;
    let mut headless = Headless::open(source, adapter, settings, args.size.0)?;
    headless.add(&objects)?;
    let record = draw_frames(args, &mut headless, view)?;
    let rgba = headless.picture()?;
    let ground = match args.coordinates {
        Some(_) => headless.ground_coordinates(view)?,
        None => Vec::new(),
    };
    Ok(Drawn { rgba, ground, record: Some(record) })
}

/// Traces the exact picture on the CPU.
fn trace(
    source: Arc<dyn TileSource>,
    view: &CameraView,
    settings: &RendererSettings,
) -> anyhow::Result<Drawn> {
    let scene = ReferenceScene::open(source)?;
    let bar = PhaseProgress::new();
    let settings = ReferenceSettings::of_renderer(settings);
    let picture = render_reference(&scene, view, &settings, &bar, &AtomicBool::new(false));
    bar.clear();
    let picture = picture?;
    let place = |point: &DVec3| {
        true_place(scene.shape(), view, settings.vertical_exaggeration, point.to_array())
    };
    Ok(Drawn {
        ground: picture.coordinates.iter().map(place).collect(),
        rgba: picture.rgba.into_flattened(),
        record: None,
    })
}

/// The view asked for, by a camera or a moment of a flight.
fn view_of(
    args: &RenderArgs,
    source: &dyn TileSource,
    exaggeration: f64,
) -> anyhow::Result<CameraView> {
    if let Some(camera) = &args.camera {
        return camera_view(args, camera, source, exaggeration);
    }
    let name = args.flight.as_deref().context("give --camera or --flight")?;
    let flight = flights::find(name, source, exaggeration)?;
    let [start, _] = flight.time_range_s();
    Ok(flight.view_at(args.at.unwrap_or(start), args.size.0))
}

/// The camera's view; its height above ground goes by the finest heights there are.
fn camera_view(
    args: &RenderArgs,
    camera: &CameraSpec,
    source: &dyn TileSource,
    exaggeration: f64,
) -> anyhow::Result<CameraView> {
    let shape = source.manifest().shape;
    let camera = camera.placed_on(shape)?;
    let ground = Ground::new(source);
    let mut beside_data = None;
    let view = camera.view(args.size.0, |point| {
        let height_m = ground.height_m(point);
        if height_m.is_none() {
            beside_data = Some(point);
        }
        height_m.unwrap_or(0.0) * exaggeration
    });
    let outside = beside_data.map(|point| {
        let place = shape.user_from_world(point);
        format!("x={}, y={}", place.x, place.y)
    });
    match outside {
        None => Ok(view),
        Some(place) => {
            Err(anyhow::anyhow!("no height at {place} (give height=.. instead of agl=..)"))
                .with_context(|| args.dataset.display().to_string())
        }
    }
}

fn draw_frames(
    args: &RenderArgs,
    headless: &mut Headless,
    view: &CameraView,
) -> anyhow::Result<FrameRecord> {
    let Some(frames) = args.frames else {
        let bar = PhaseProgress::new();
        let record = headless.draw_settled(view, &bar);
        bar.clear();
        return record;
    };
    let bar = FrameProgress::new(u64::from(frames));
    let mut record = FrameRecord::default();
    for frame in 1..=frames {
        record = headless.draw(view, Pace::Free)?;
        bar.advance(u64::from(frame));
    }
    bar.finish();
    Ok(record)
}
