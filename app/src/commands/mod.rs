//! The commands, a file each.

pub mod compare;
pub mod doctor;
pub mod fly;
pub mod info;
pub mod limit;
pub mod precision;
pub mod prepare;
pub mod render;
pub mod synth;
pub mod tin;

use std::path::Path;

use clap::Parser;
use terrain_core::gpu::AdapterChoice;

use crate::cli::{Cli, Command};
use crate::{display, output};

/// What `terrain` alone stands for where there is a display, and where there is none.
pub const DEMO_IN_WINDOW: [&str; 2] = ["terrain", "fly"];
const DEMO_FOLDER: &str = "out/demo";
/// See [`DEMO_IN_WINDOW`].
pub const DEMO_TO_FILES: [&str; 8] =
    ["terrain", "fly", "--headless", "--settle", "--frames-at", "24", "--out", DEMO_FOLDER];

/// Does what the command line asks for.
pub fn run(cli: Cli) -> anyhow::Result<()> {
    match cli.command {
        None => run_demo(cli.adapter),
        Some(Command::Prepare(args)) => prepare::run(args),
        Some(Command::Synth(args)) => synth::run(args),
        Some(Command::Tin(args)) => tin::run(&args),
        Some(Command::Info(args)) => info::run(args),
        Some(Command::Fly(args)) => fly::run(&args, &cli.adapter),
        Some(Command::Render(args)) => render::run(&args, &cli.adapter),
        Some(Command::Precision(args)) => precision::run(&args, &cli.adapter),
        Some(Command::Compare(args)) => compare::run(&args, &cli.adapter),
        Some(Command::Limit(args)) => limit::run(&args),
        Some(Command::Doctor(args)) => doctor::run(&args, &cli.adapter),
    }
}

/// The demo in a window; without a display its flight as pictures.
fn run_demo(adapter: AdapterChoice) -> anyhow::Result<()> {
    if display::display().is_some() {
        return run(Cli { adapter, ..Cli::try_parse_from(DEMO_IN_WINDOW)? });
    }
    output::say("terrain: no display; drawing the demo's flight to files ...");
    run(Cli { adapter, ..Cli::try_parse_from(DEMO_TO_FILES)? })?;
    let folder = Path::new(DEMO_FOLDER);
    let folder = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
    output::print(&format!("the pictures of the demo's flight are in {}\n", folder.display()))
}
