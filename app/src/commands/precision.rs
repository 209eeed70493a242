//! `terrain precision`: the study of numerical precision, as a page, tables and plots.

use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;
use terrain_core::gpu::{AdapterChoice, GpuContext};
use terrain_core::precision::study::{
    STUDY_PARTS, Study, StudyOptions, plots, report_page, run_study, tables,
};

use crate::output;
use crate::progress::FrameProgress;

/// Size in pixels of a plot's file.
const PLOT_PX: [u32; 2] = [720, 420];

/// Where to write, and how much to look at.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  terrain precision --out precision --adapter vulkan")]
pub struct PrecisionArgs {
    /// Folder for report.html, summary.json, the tables (CSV) and the plots (SVG)
    #[arg(long, value_name = "DIR")]
    out: PathBuf,

    /// Look at fewer values: the ends of every axis and some between
    #[arg(long)]
    quick: bool,
}

/// Runs the study and writes what it found. Without an adapter the CPU does what it can.
pub fn run(args: &PrecisionArgs, choice: &AdapterChoice) -> anyhow::Result<()> {
    let gpu = match GpuContext::headless(choice) {
        Ok(gpu) => Some(gpu),
        Err(error) if *choice == AdapterChoice::Best => {
            output::say(&format!("terrain: {error}; the study goes on without one"));
            None
        }
        Err(error) => return Err(error.into()),
    };
    let options = if args.quick { StudyOptions::quick() } else { StudyOptions::full() };
    let progress = FrameProgress::over(STUDY_PARTS, "parts");
    let study = run_study(gpu.as_ref(), &options, &|done| progress.advance(done))?;
    progress.finish();
    write(&study, &args.out)?;
    output::print(&findings(&study, &args.out))
}

/// Which encodings keep the contract, and where to read on.
fn findings(study: &Study, folder: &Path) -> String {
    let verdicts = study.encodings.gpu_verdicts.as_ref().unwrap_or(&study.encodings.cpu_verdicts);
    let lines = verdicts.iter().map(|verdict| {
        let kept = if verdict.is_kept() { "kept" } else { "broken" };
        format!(
            "{:<20} contract {kept:<7} {:>10.4} mm  {:>8.4} px  {:>9.5} texels  {:>11.4} mm of height\n",
            verdict.encoding.name(),
            verdict.near_m.value * 1.0e3,
            verdict.far_pixels.value,
            verdict.texels.value,
            verdict.ground_m.value * 1.0e3,
        )
    });
    lines.collect::<String>() + &format!("report: {}\n", folder.join("report.html").display())
}

fn write(study: &Study, folder: &Path) -> anyhow::Result<()> {
    std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    let save =
        |name: String, content: String| output::write_whole(&folder.join(name), content.as_bytes());
    for table in tables(study) {
        save(format!("{}.csv", table.name), table.to_csv())?;
    }
    for plot in plots(study) {
        save(format!("{}.svg", plot.name), plot.plot.to_svg(PLOT_PX)?)?;
    }
    save("summary.json".to_owned(), serde_json::to_string_pretty(&study.summary())? + "\n")?;
    save("report.html".to_owned(), report_page(study, &machine())?)
}

/// What the study runs on, without the adapter.
fn machine() -> String {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let (system, family) = (std::env::consts::OS, std::env::consts::ARCH);
    format!("Machine: {cores} cores, {family}, {system}.")
}
