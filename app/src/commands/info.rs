//! `terrain info`: what a dataset holds.

use std::fmt::Write;
use std::path::PathBuf;

use anyhow::bail;
use clap::Args;
use serde_json::json;
use terrain_core::dataset::{
    ColourLayer, Dataset, HeightLayer, Inspection, LevelInspection, Manifest, Shape, TileSource,
};
use terrain_core::tiling::TilingScheme;

use crate::output;
use crate::progress::PhaseProgress;

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
    let bar = PhaseProgress::new();
    let inspection = dataset.inspect(args.verify, &bar);
    bar.clear();
    let answer = if args.json {
        json_of(dataset.manifest(), &inspection)?
    } else {
        text_of(dataset.manifest(), &inspection)?
    };
    output::print(&answer)?;
    match &inspection.faults[..] {
        [] => Ok(()),
        [only] => bail!("{only}"),
        [first, rest @ ..] => bail!("{first} (and {} more tiles)", rest.len()),
    }
}

fn json_of(manifest: &Manifest, inspection: &Inspection) -> anyhow::Result<String> {
    let answer = json!({ "manifest": manifest, "inspection": inspection });
    Ok(serde_json::to_string_pretty(&answer)? + "\n")
}

fn text_of(manifest: &Manifest, inspection: &Inspection) -> Result<String, std::fmt::Error> {
    let mut text = String::new();
    let extent = &manifest.data_extent;
    let size_km = extent.size_m() / 1000.0;
    let epsg = manifest.crs.epsg.map(|code| format!(" (EPSG:{code})")).unwrap_or_default();
    writeln!(text, "CRS       {}{epsg}", manifest.crs.name)?;
    let [min, max] = [extent.min, extent.max].map(|corner| manifest.shape.user_from_world(corner));
    match manifest.shape {
        Shape::Plane => writeln!(
            text,
            "extent    x {:.3} .. {:.3}, y {:.3} .. {:.3} ({:.3} x {:.3} km)",
            min.x, max.x, min.y, max.y, size_km.x, size_km.y
        )?,
        Shape::Globe => writeln!(
            text,
            "shape     the globe: longitude {:.0} .. {:.0}, latitude {:.0} .. {:.0} degrees",
            min.x, max.x, min.y, max.y
        )?,
    }
    write_heights(&mut text, &manifest.heights, &manifest.scheme, &inspection.heights)?;
    if let Some(colours) = &manifest.colours {
        write_colours(&mut text, colours, &manifest.scheme, &inspection.colours)?;
    }
    writeln!(text, "sources   {}", manifest.sources.join(", "))?;
    for note in &manifest.notes {
        writeln!(text, "note      {note}")?;
    }
    let checksums = match (inspection.verified, inspection.faults.len()) {
        (false, _) => "not checked (--verify reads every tile)".to_owned(),
        (true, 0) => "every tile read, all checksums match".to_owned(),
        (true, faults) => format!("{faults} tiles are damaged"),
    };
    writeln!(text, "checksums {checksums}")?;
    Ok(text)
}

fn write_heights(
    text: &mut String,
    layer: &HeightLayer,
    scheme: &TilingScheme,
    levels: &[LevelInspection],
) -> std::fmt::Result {
    let (range, layout) = (layer.range, layer.layout);
    writeln!(
        text,
        "heights   {:.2} .. {:.2} m above the sources' datum",
        range.min_m, range.max_m
    )?;
    writeln!(
        text,
        "dem       {:?} of {} m, tiles of {} + 2 x {} texels, finest {:.3} m",
        layer.encoding,
        layer.step_m,
        layout.tile_size_texels,
        layout.gutter_texels,
        layout.texel_size_m(scheme, layout.finest_level())
    )?;
    write_levels(text, levels)
}

fn write_colours(
    text: &mut String,
    layer: &ColourLayer,
    scheme: &TilingScheme,
    levels: &[LevelInspection],
) -> std::fmt::Result {
    let layout = layer.layout;
    writeln!(
        text,
        "dom       {:?} on disk, {:?} on the GPU, tiles of {} + 2 x {} texels, finest {:.3} m",
        layer.encoding,
        layer.format,
        layout.tile_size_texels,
        layout.gutter_texels,
        layout.texel_size_m(scheme, layout.finest_level())
    )?;
    write_levels(text, levels)
}

fn write_levels(text: &mut String, levels: &[LevelInspection]) -> std::fmt::Result {
    for LevelInspection { level, tiles, disk_bytes } in levels {
        writeln!(text, "  level {level:<2} {tiles:>9} tiles {disk_bytes:>14} bytes")?;
    }
    Ok(())
}
