//! The `terrain` command: prepares datasets, flies over them and measures the flight.

mod arg_values;
mod cli;
mod commands;
mod demo;
mod detail_args;
mod display;
mod drawing_args;
mod flight_summary;
mod flights;
mod ground;
mod headless;
mod interrupt;
mod npy;
mod output;
mod pictures;
mod progress;
mod scene_args;
mod viewer;

use std::io::Write;
use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    match commands::run(cli::Cli::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // Where even this line cannot be written, the exit code has to say it alone.
            let _ = writeln!(std::io::stderr(), "terrain: {}", output::one_line(&error));
            ExitCode::FAILURE
        }
    }
}
