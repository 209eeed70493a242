//! `terrain info`: what a dataset holds.

use std::path::PathBuf;

use anyhow::bail;
use clap::Args;
use serde_json::json;
use terrain_core::dataset::{Dataset, Inspection, LevelInspection, Manifest, TileSource};

/// Tells what a dataset holds
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  terrain info alps
  terrain info alps --verify
  terrain info alps --json")]
pub struct InfoArgs {
    /// Folder of the dataset
    #[arg(value_name = "DATASET")]
    dataset: PathBuf,

    /// Read and decode every tile, checking its checksum
    #[arg(long)]
    verify: bool,

    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command. Damaged tiles are listed and make it fail.
pub fn run(args: InfoArgs) -> anyhow::Result<()> {
    let dataset = Dataset::open(&args.dataset)?;
    let inspection = dataset.inspect(args.verify);
    if args.json {
        print_json(dataset.manifest(), &inspection)?;
    } else {
        print_text(dataset.manifest(), &inspection);
    }
    match &inspection.faults[..] {
        [] => Ok(()),
        [only] => bail!("{only}"),
        [first, rest @ ..] => bail!("{first} (and {} more tiles)", rest.len()),
    }
}

#[expect(clippy::print_stdout, reason = "the answer is the command's result")]
fn print_json(manifest: &Manifest, inspection: &Inspection) -> anyhow::Result<()> {
    let answer = json!({ "manifest": manifest, "inspection": inspection });
    println!("{}", serde_json::to_string_pretty(&answer)?);
    Ok(())
}

#[expect(clippy::print_stdout, reason = "the answer is the command's result")]
fn print_text(manifest: &Manifest, inspection: &Inspection) {
    let extent = &manifest.data_extent;
    let size_km = extent.size_m() / 1000.0;
    let epsg = manifest.crs.epsg.map(|code| format!(" (EPSG:{code})")).unwrap_or_default();
    println!("CRS       {}{epsg}", manifest.crs.name);
    println!(
        "extent    x {:.3} .. {:.3}, y {:.3} .. {:.3} ({:.3} x {:.3} km)",
        extent.min.x, extent.max.x, extent.min.y, extent.max.y, size_km.x, size_km.y
    );
    let heights = &manifest.heights;
    let range = heights.range;
    println!("heights   {:.2} .. {:.2} m above the sources' datum", range.min_m, range.max_m);
    println!(
        "dem       {:?} of {} m, tiles of {} + 2 x {} texels, finest {:.3} m",
        heights.encoding,
        heights.step_m,
        heights.layout.tile_size_texels,
        heights.layout.gutter_texels,
        heights.layout.texel_size_m(&manifest.scheme, heights.layout.finest_level())
    );
    print_levels(&inspection.heights);
    if let Some(colours) = &manifest.colours {
        println!(
            "dom       {:?} on disk, {:?} on the GPU, tiles of {} + 2 x {} texels, finest {:.3} m",
            colours.encoding,
            colours.format,
            colours.layout.tile_size_texels,
            colours.layout.gutter_texels,
            colours.layout.texel_size_m(&manifest.scheme, colours.layout.finest_level())
        );
        print_levels(&inspection.colours);
    }
    println!("sources   {}", manifest.sources.join(", "));
    for note in &manifest.notes {
        println!("note      {note}");
    }
    let checksums = match (inspection.verified, inspection.faults.len()) {
        (false, _) => "not checked (--verify reads every tile)".to_owned(),
        (true, 0) => "every tile read, all checksums match".to_owned(),
        (true, faults) => format!("{faults} tiles are damaged"),
    };
    println!("checksums {checksums}");
}

#[expect(clippy::print_stdout, reason = "the answer is the command's result")]
fn print_levels(levels: &[LevelInspection]) {
    for level in levels {
        println!(
            "  level {:<2} {:>9} tiles {:>14} bytes",
            level.level, level.tiles, level.disk_bytes
        );
    }
}
