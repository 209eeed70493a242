//! The command line: what can be asked for.

use clap::{Parser, Subcommand};
use terrain_core::gpu::AdapterChoice;

use crate::commands::compare::CompareArgs;
use crate::commands::doctor::DoctorArgs;
use crate::commands::fly::FlyArgs;
use crate::commands::info::InfoArgs;
use crate::commands::limit::LimitArgs;
use crate::commands::precision::PrecisionArgs;
use crate::commands::prepare::PrepareArgs;
use crate::commands::render::RenderArgs;
use crate::commands::synth::SynthArgs;
use crate::commands::tin::TinArgs;

const EXAMPLE: &str = "Example:
  terrain prepare --dem dem.tif --dom orthophoto.tif --out alps
  terrain fly alps";

/// Streams and draws terrain far larger than memory, and measures itself while it does.
///
/// Without a command it flies over the bundled demo.
#[derive(Debug, Parser)]
#[command(name = "terrain", version, max_term_width = 100, after_help = EXAMPLE)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Option<Command>,

    /// The graphics adapter: best, vulkan, gl, cpu, or a part of its name.
    #[arg(long, global = true, default_value = "best", value_name = "ADAPTER")]
    pub adapter: AdapterChoice,
}

/// A command, a file each in `commands/`.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Make a dataset of height rasters and pictures.
    Prepare(PrepareArgs),
    /// Write rasters of synthetic mountains, as large as wanted.
    Synth(SynthArgs),
    /// Make triangles of a raster or of points, within a stated error.
    Tin(TinArgs),
    /// Tell what a dataset holds.
    Info(InfoArgs),
    /// Fly over a dataset, in a window or measured without one.
    Fly(FlyArgs),
    /// Draw one picture of a dataset.
    Render(RenderArgs),
    /// Study how exact places, texture coordinates and depth are.
    Precision(PrecisionArgs),
    /// Measure what a flight's frames cost and how far they are from exact pictures.
    Compare(CompareArgs),
    /// Make and study limit-triangulated surfaces: colours integrated over distance.
    Limit(LimitArgs),
    /// Say which graphics adapters there are, what they can do and what would be left out.
    Doctor(DoctorArgs),
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn the_definition_is_sound() {
        Cli::command().debug_assert();
    }

    #[test]
    fn every_command_shows_an_example() {
        let mut command = Cli::command();
        command.build();
        assert!(command.render_long_help().to_string().contains("  terrain prepare"));
        for sub in command.get_subcommands().filter(|sub| sub.get_name() != "help") {
            let help = sub.clone().render_long_help().to_string();
            let example = format!("  terrain {}", sub.get_name());
            assert!(help.contains(&example), "{} has no example", sub.get_name());
        }
    }

    #[test]
    fn what_the_demo_stands_for_is_a_valid_command() {
        use crate::commands::{DEMO_IN_WINDOW, DEMO_TO_FILES};
        assert!(Cli::try_parse_from(DEMO_IN_WINDOW).is_ok());
        assert!(Cli::try_parse_from(DEMO_TO_FILES).is_ok());
    }

    #[test]
    fn the_adapter_can_stand_before_or_after_the_command() {
        for line in
            [["terrain", "--adapter", "cpu", "doctor"], ["terrain", "doctor", "--adapter", "cpu"]]
        {
            let cli = Cli::try_parse_from(line).unwrap();
            assert_eq!(cli.adapter, AdapterChoice::Cpu);
        }
    }
}
