//! `terrain synth`: synthetic mountains as source rasters.

use std::path::PathBuf;

use clap::Args;
use terrain_core::synth::{Preset, SynthRequest, SynthSummary, synthesise};

use crate::interrupt::flag_on_ctrl_c;
use crate::output;
use crate::progress::PhaseProgress;

/// Writes rasters of synthetic mountains: no real place
#[derive(Args, Debug)]
#[command(after_help = "\
Presets, all parts of one ground, heights 30 m and picture 10 m a cell:
  sichuan        8000 x 8000 heights, 24000 x 24000 picture (1.9 GB)
  sichuan-half   4000 x 4000 and 12000 x 12000 (460 MB)
  sichuan-small  1000 x 1000 and 3000 x 3000 (29 MB)
  sichuan-tiny   250 x 250 and 750 x 750 (2 MB)

Example:
  terrain synth --preset sichuan-small --out rasters
  terrain prepare --dem rasters/dem.tif --dom rasters/dom.tif --out mountains")]
pub struct SynthArgs {
    /// Which part of the ground: sichuan, sichuan-half, sichuan-small or sichuan-tiny
    #[arg(long, value_name = "NAME", value_parser = parse_preset)]
    preset: Preset,

    /// Folder to write dem.tif and dom.tif to
    #[arg(long, value_name = "DIR")]
    out: PathBuf,

    /// Another seed is another ground of the same kind
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u32,
}

/// Runs the command.
pub fn run(args: SynthArgs) -> anyhow::Result<()> {
    let cancel = flag_on_ctrl_c()?;
    let bar = PhaseProgress::new();
    let request = SynthRequest { preset: args.preset, seed: args.seed, out: args.out };
    let summary = synthesise(&request, &bar, &cancel);
    bar.clear();
    output::print(&text_of(&request, &summary?))
}

fn text_of(request: &SynthRequest, summary: &SynthSummary) -> String {
    let [low_m, high_m] = summary.height_range_m;
    let (heights, colours) = (request.preset.heights_side, request.preset.colours_side());
    let seconds = summary.elapsed.as_secs_f64();
    let megapixels = (heights * heights + colours * colours) as f64 / 1e6;
    format!(
        "SYNTHETIC ground, no real place: preset {}, seed {}\n\
         dem      {}: {heights} x {heights}, {low_m} .. {high_m} m\n\
         dom      {}: {colours} x {colours}\n\
         time     {seconds:.1} s, {:.1} Mpx/s\n",
        request.preset.name,
        request.seed,
        summary.heights_path.display(),
        summary.colours_path.display(),
        megapixels / seconds.max(1e-9),
    )
}

fn parse_preset(name: &str) -> Result<Preset, String> {
    Preset::by_name(name).ok_or_else(|| {
        let names = Preset::ALL.map(|preset| preset.name);
        format!("there are {}", names.join(", "))
    })
}
