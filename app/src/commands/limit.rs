//! `terrain limit`: limit-triangulated surfaces, made of datasets and studied.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::{Args, Subcommand};
use terrain_core::CameraView;
use terrain_core::dataset::{Dataset, TileSource};
use terrain_core::measure::CameraSpec;
use terrain_core::measure::report::ReportPicture;
use terrain_core::reference::limit_surface::{
    GroundComparison, KnotRule, LIMIT_FILE, LimitPrepareSummary, LimitRequest, LimitSurface,
    StudyPlace, StudyRun, StudySettings, compare_on_ground, ground_table_csv,
    prepare_limit_surface, read_limit_file, run_study_case, study_page, study_plot,
    study_profile_csv, study_table_csv, texture_window,
};
use terrain_core::tiling::Extent;

use crate::arg_values::{exaggeration, number_within, parse_extent};
use crate::drawing_args::Size;
use crate::interrupt::flag_on_ctrl_c;
use crate::progress::{FrameProgress, PhaseProgress};
use crate::{output, pictures};

/// Size in pixels of a plot's file.
const PLOT_PX: [u32; 2] = [720, 420];
/// More memory than any machine has, MB.
const MOST_MEMORY_MB: f64 = 1.0e9;

/// What to do.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  terrain limit prepare alps --area 462000,6821000,464000,6823000
  terrain limit study --out study
  terrain limit study --out study --dataset alps \\
      --camera x=463000,y=6822000,height=60000,pitch=-90,fov=2")]
pub struct LimitArgs {
    #[command(subcommand)]
    task: Task,
}

#[derive(Debug, Subcommand)]
enum Task {
    /// Integrate the colours of a dataset's triangles over distance and store them beside its tiles
    Prepare(Box<PrepareArgs>),
    /// Run the published experiment and write tables, plots and a page
    Study(StudyArgs),
}

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  terrain limit prepare alps
  terrain limit prepare alps --area 462000,6821000,464000,6823000 --memory-mb 64
  terrain limit prepare alps --d-min 20000 --angle 0.0005 --colour-error 2")]
struct PrepareArgs {
    /// Folder of the dataset
    #[arg(value_name = "DATASET")]
    dataset: PathBuf,

    /// File to write [default: limit.surface in the dataset's folder]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,

    /// The ground to take, in the dataset's CRS [default: all]
    #[arg(long, value_name = "W,S,E,N", value_parser = parse_extent, allow_hyphen_values = true)]
    area: Option<Extent>,

    /// The admissible angle in radians: the cone's at its apex
    #[arg(long, value_name = "RADIANS", default_value_t = LimitRequest::default().admissible_angle_rad)]
    angle: f64,

    /// The part of that angle a triangle spans from the least distance
    #[arg(long, value_name = "PART", default_value_t = LimitRequest::default().triangle_share)]
    triangle_share: f64,

    /// The least distance in metres [default: that of triangles as large as the imagery's texels]
    #[arg(long, value_name = "METRES")]
    d_min: Option<f64>,

    /// The farthest distance over the least
    #[arg(long, value_name = "FACTOR", default_value_t = LimitRequest::default().reach)]
    reach: f64,

    /// Distances in a doubling
    #[arg(long, value_name = "N", default_value_t = LimitRequest::default().per_doubling)]
    per_doubling: u32,

    /// Largest error of a triangle's reduced colours, in steps of 1/255 of sRGB
    #[arg(
        long,
        value_name = "STEPS",
        default_value_t = 4.0,
        value_parser = number_within(0.0, 255.0),
        allow_hyphen_values = true,
        conflicts_with = "memory_mb"
    )]
    colour_error: f64,

    /// Most MB for all colours; the largest error is then the least possible
    #[arg(
        long,
        value_name = "MB",
        value_parser = number_within(0.0, MOST_MEMORY_MB),
        allow_hyphen_values = true
    )]
    memory_mb: Option<f64>,

    /// Factor on all heights, from 0.01 to 1000
    #[arg(
        long,
        value_name = "FACTOR",
        default_value_t = 1.0,
        value_parser = exaggeration(),
        allow_hyphen_values = true
    )]
    exaggeration: f64,

    /// Print what was made as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  terrain limit study --out study
  terrain limit study --out study --dataset alps \\
      --camera x=463000,y=6822000,height=60000,pitch=-90,fov=2")]
struct StudyArgs {
    /// Folder for report.html, the tables (CSV, JSON) and the plots (SVG)
    #[arg(long, value_name = "DIR")]
    out: PathBuf,

    /// A dataset whose surface (see terrain limit prepare) is compared as well
    #[arg(long, value_name = "DATASET", requires = "camera")]
    dataset: Option<PathBuf>,

    /// The camera of that comparison, as for terrain render
    #[arg(long, value_name = "CAMERA", allow_hyphen_values = true, requires = "dataset")]
    camera: Option<CameraSpec>,

    /// Width and height of its pictures
    #[arg(long, value_name = "WxH", default_value = "192x128")]
    size: Size,
}

/// Does what is asked for.
pub fn run(args: &LimitArgs) -> anyhow::Result<()> {
    match &args.task {
        Task::Prepare(args) => run_prepare(args),
        Task::Study(args) => run_study(args),
    }
}

fn run_prepare(args: &PrepareArgs) -> anyhow::Result<()> {
    let dataset = Dataset::open(&args.dataset)?;
    let rule = match args.memory_mb {
        Some(megabytes) => KnotRule::Memory((megabytes * 1.0e6) as u64),
        None => KnotRule::ColourError(args.colour_error as f32),
    };
    let request = LimitRequest {
        area: args.area,
        admissible_angle_rad: args.angle,
        triangle_share: args.triangle_share,
        least_distance_m: args.d_min,
        reach: args.reach,
        per_doubling: args.per_doubling,
        rule,
        vertical_exaggeration: args.exaggeration,
    };
    let path = args.out.clone().unwrap_or_else(|| args.dataset.join(LIMIT_FILE));
    let cancel = flag_on_ctrl_c()?;
    let progress = PhaseProgress::new();
    let summary = prepare_limit_surface(&dataset, &request, &path, &progress, &cancel);
    progress.clear();
    let summary = summary.with_context(|| args.dataset.display().to_string())?;
    if args.json {
        return output::print(&(serde_json::to_string_pretty(&summary)? + "\n"));
    }
    output::print(&text_of(&summary, &path)?)
}

fn text_of(summary: &LimitPrepareSummary, path: &Path) -> Result<String, std::fmt::Error> {
    let (header, memory) = (&summary.header, &summary.memory);
    let mut text = String::new();
    let distances_m = &header.distances_m;
    let [least_m, farthest_m] =
        [distances_m.first(), distances_m.last()].map(|end| end.copied().unwrap_or(0.0));
    writeln!(
        text,
        "triangles  {} in cells of {:.3} m ({} x {})",
        memory.triangles, header.grid.cell_m, header.grid.columns, header.grid.rows
    )?;
    writeln!(
        text,
        "distances  {} from {least_m:.0} to {farthest_m:.0} m, admissible angle {:.6} rad",
        distances_m.len(),
        header.admissible_angle_rad
    )?;
    writeln!(
        text,
        "colours    {:.2} knots and {:.2} bytes a triangle, error at most {} steps of 255",
        memory.knots_per_triangle(),
        memory.colour_bytes_per_triangle(),
        header.limit_steps
    )?;
    writeln!(
        text,
        "memory     {:.1} MB of colours, {:.1} MB of shape",
        memory.colour_bytes as f64 / 1.0e6,
        memory.shape_bytes as f64 / 1.0e6
    )?;
    writeln!(text, "file       {} ({} bytes)", path.display(), summary.file_bytes)?;
    Ok(text)
}

fn run_study(args: &StudyArgs) -> anyhow::Result<()> {
    let ground = match (&args.dataset, &args.camera) {
        (Some(dataset), Some(camera)) => Some(Ground::open(dataset, camera, args.size.0)?),
        _ => None,
    };
    let runs = run_cases()?;
    let (rows, pictures) = match &ground {
        Some(ground) => ground.compare()?,
        None => (Vec::new(), Vec::new()),
    };
    write_study(&args.out, &runs, &rows, &pictures)?;
    output::print(&(study_table_csv(&runs) + &ground_table_csv_or_nothing(&rows)))?;
    output::print(&format!("report: {}\n", args.out.join("report.html").display()))
}

fn ground_table_csv_or_nothing(rows: &[GroundComparison]) -> String {
    if rows.is_empty() { String::new() } else { ground_table_csv(rows) }
}

fn run_cases() -> anyhow::Result<Vec<StudyRun>> {
    let settings =
        [("as published", StudySettings::published()), ("half the cone", StudySettings::default())];
    let places = StudyPlace::published();
    let progress = FrameProgress::over((settings.len() * places.len()) as u64, "cases");
    let mut done = 0;
    let mut runs = Vec::new();
    for (name, settings) in settings {
        let mut cases = Vec::new();
        for &place in &places {
            cases.push(run_study_case(&settings, place)?);
            done += 1;
            progress.advance(done);
        }
        runs.push(StudyRun { name: name.to_owned(), settings, cases });
    }
    progress.finish();
    Ok(runs)
}

/// A dataset's surface, and a view of it.
struct Ground {
    dataset: Dataset,
    surface: LimitSurface,
    view: CameraView,
}

impl Ground {
    fn open(folder: &Path, camera: &CameraSpec, size_px: [u32; 2]) -> anyhow::Result<Self> {
        let dataset = Dataset::open(folder)?;
        let camera = camera.placed_on(dataset.manifest().shape)?;
        let path = folder.join(LIMIT_FILE);
        if !path.exists() {
            bail!("{}: not there; `terrain limit prepare` makes it", path.display());
        }
        let (_, surface) = read_limit_file(&path)?;
        let relief = surface.relief();
        let view = camera.view(size_px, |point| {
            Some(relief.height_m(point)).filter(|h| h.is_finite()).unwrap_or(0.0)
        });
        Ok(Self { dataset, surface, view })
    }

    fn compare(&self) -> anyhow::Result<(Vec<GroundComparison>, Vec<ReportPicture>)> {
        let extent = self.surface.relief().grid().extent();
        let texture = texture_window(&self.dataset as &dyn TileSource, &extent)?;
        let texture = texture.context("the dataset has no imagery")?;
        let (rows, compared) = compare_on_ground(&self.surface, &texture, self.view);
        let mut report = Vec::new();
        for one in compared {
            let png = pictures::png_bytes(one.picture.size_px, &one.picture.to_rgba())?;
            report.push(ReportPicture { png, caption: format!("{}, 16 rays a pixel", one.name) });
        }
        if let Some(ideal) = report.first_mut() {
            ideal.caption = "ideal: 1024 unfiltered rays a pixel".to_owned();
        }
        Ok((rows, report))
    }
}

fn write_study(
    folder: &Path,
    runs: &[StudyRun],
    rows: &[GroundComparison],
    pictures: &[ReportPicture],
) -> anyhow::Result<()> {
    std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    let save = |name: &str, content: &[u8]| output::write_whole(&folder.join(name), content);
    for run in runs {
        for case in &run.cases {
            let name = format!(
                "{}-{}deg-{}",
                run.name.replace(' ', "-"),
                case.place.border_deg,
                case.place.part
            );
            save(&format!("{name}.csv"), study_profile_csv(case).as_bytes())?;
            save(&format!("{name}.svg"), study_plot(run, case).to_svg(PLOT_PX)?.as_bytes())?;
        }
    }
    for picture in pictures {
        let name = picture.caption.split([':', ',']).next().unwrap_or("picture");
        save(&format!("ground-{name}.png"), &picture.png)?;
    }
    save("experiment.csv", study_table_csv(runs).as_bytes())?;
    let json = serde_json::json!({ "experiment": runs, "ground": rows });
    save("experiment.json", (serde_json::to_string_pretty(&json)? + "\n").as_bytes())?;
    if !rows.is_empty() {
        save("ground.csv", ground_table_csv(rows).as_bytes())?;
    }
    save("report.html", study_page(runs, rows, pictures)?.as_bytes())
}
