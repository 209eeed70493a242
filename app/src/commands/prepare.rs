//! `terrain prepare`: rasters in, a dataset out.

use std::fmt::Write;
use std::path::PathBuf;

use clap::{Args, ValueEnum};
use terrain_core::dataset::{ColourEncoding, ColourFormat, HeightEncoding, Shape};
use terrain_core::prepare::{LayerSummary, PointOptions, PrepareRequest, PrepareSummary, prepare};
use terrain_core::tiling::Extent;

use crate::arg_values::parse_extent;
use crate::interrupt::flag_on_ctrl_c;
use crate::output;
use crate::progress::PhaseProgress;

/// Makes a dataset of height rasters and pictures
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  terrain prepare --dem dem.tif --dom ortho.tif --out alps
  terrain prepare --dem N46E007.hgt N46E008.hgt --out valais
  terrain prepare --dem survey-1.laz survey-2.laz --point-class 2,9 --out coast
  terrain prepare --dem etopo.tif --dom relief.jpg --dom-extent -180,-90,180,90 \\
      --crs EPSG:4087 --out earth-map
  terrain prepare --globe --dem etopo.tif --dom relief.jpg --out earth")]
pub struct PrepareArgs {
    /// Height rasters (GeoTIFF, SRTM .hgt, grey PNG with a world file) and points (LAS, LAZ, and .csv,
    /// .xyz, .txt of x, y, height); the first one counts where they overlap. All points together make
    /// one surface, that of their natural neighbours
    #[arg(long, value_name = "FILE", num_args = 1.., required_unless_present = "globe")]
    dem: Vec<PathBuf>,

    /// Make the whole globe of rasters, best in longitude and latitude. Where they hold no heights, or none are given,
    /// the ground is the ellipsoid; pictures without a georeference that are twice as wide as high are the whole
    /// Earth
    #[arg(long, conflicts_with_all = ["crs", "keep_voids"])]
    globe: bool,

    /// LAS classes to take, such as 2 for ground or 2,9 [default: 2 if the file has any, else all]
    #[arg(long, value_name = "CLASS", value_delimiter = ',')]
    point_class: Vec<u8>,

    /// Side of the cells that points are interpolated to [default: as many cells as points]
    #[arg(long, value_name = "METRES", allow_hyphen_values = true)]
    point_spacing: Option<f64>,

    /// CRS of points that do not say theirs [default: that of --crs]
    #[arg(long, value_name = "EPSG:n", value_parser = parse_epsg)]
    point_crs: Option<u32>,

    /// Pictures (GeoTIFF, PNG or JPEG with a world file)
    #[arg(long, value_name = "FILE", num_args = 1.., required_unless_present = "dem")]
    dom: Vec<PathBuf>,

    /// Folder to write the dataset to
    #[arg(long, value_name = "DATASET")]
    out: PathBuf,

    /// CRS of the dataset, in metres; also that of heights that do not say theirs [default: the
    /// heights' own, or the UTM zone they lie in]
    #[arg(long, value_name = "EPSG:n", value_parser = parse_epsg)]
    crs: Option<u32>,

    /// Where pictures without a georeference lie
    #[arg(long, value_name = "W,S,E,N", value_parser = parse_extent, allow_hyphen_values = true)]
    dom_extent: Option<Extent>,

    /// CRS of pictures that do not say theirs [default: the heights']
    #[arg(long, value_name = "EPSG:n", value_parser = parse_epsg)]
    dom_crs: Option<u32>,

    /// Texels along a height tile
    #[arg(long, value_name = "TEXELS", default_value_t = 128)]
    dem_tile: u32,

    /// Texels along a colour tile
    #[arg(long, value_name = "TEXELS", default_value_t = 384)]
    dom_tile: u32,

    /// Number of levels, or auto for as many as the sources fill
    #[arg(long, value_name = "N", default_value = "auto", value_parser = parse_levels)]
    levels: Levels,

    /// How heights are stored
    #[arg(long, value_enum, default_value_t = DemEncoding::Steps)]
    dem_encoding: DemEncoding,

    /// How colours are stored
    #[arg(long, value_enum, default_value_t = DomEncoding::Bc7)]
    dom_encoding: DomEncoding,

    /// Leave gaps in the heights as they are; else those that heights enclose are filled, if at most 64
    /// cells wide and high
    #[arg(long)]
    keep_voids: bool,

    /// Fill larger gaps too, of at most so many square kilometres (2048 cells wide and high), and all
    /// of them by the natural neighbours on their rims. Gaps at the raster's border stay [default: 100]
    #[arg(
        long,
        value_name = "KM2",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "100",
        conflicts_with = "keep_voids"
    )]
    fill_voids: Option<f64>,

    /// Go on with the layers (heights, colours) that the same command with --resume finished before
    /// it was interrupted; a layer begun is made anew
    #[arg(long)]
    resume: bool,
}

/// A limit on the number of levels; `None` for auto.
#[derive(Clone, Copy, Debug)]
struct Levels(Option<u8>);

#[derive(Clone, Copy, Debug, ValueEnum)]
enum DemEncoding {
    /// 16-bit steps of a power of two of a metre, at most 1 cm or half the source's step lost
    Steps,
    /// float32, unchanged
    Float,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum DomEncoding {
    /// 8 bits a texel
    Bc7,
    /// 4 bits a texel
    Bc1,
    /// 32 bits a texel
    Rgba8,
    /// JPEG on disk, BC7 on the GPU: for slow links
    Jpeg,
}

/// Runs the command.
pub fn run(args: PrepareArgs) -> anyhow::Result<()> {
    let cancel = flag_on_ctrl_c()?;
    let bar = PhaseProgress::new();
    let summary = prepare(&request_of(args), &bar, &cancel);
    bar.clear();
    output::print(&text_of(&summary?)?)
}

fn request_of(args: PrepareArgs) -> PrepareRequest {
    PrepareRequest {
        shape: if args.globe { Shape::Globe } else { Shape::Plane },
        epsg: args.crs,
        points: PointOptions {
            classes: args.point_class,
            spacing_m: args.point_spacing,
            epsg: args.point_crs,
        },
        colour_bounds: args.dom_extent.map(|Extent { min, max }| [min.x, min.y, max.x, max.y]),
        colour_epsg: args.dom_crs,
        height_tile_texels: args.dem_tile,
        colour_tile_texels: args.dom_tile,
        level_limit: args.levels.0,
        height_encoding: match args.dem_encoding {
            DemEncoding::Steps => HeightEncoding::Steps,
            DemEncoding::Float => HeightEncoding::Float,
        },
        colour_encoding: match args.dom_encoding {
            DomEncoding::Bc7 => ColourEncoding::Bc7,
            DomEncoding::Bc1 => ColourEncoding::Bc1,
            DomEncoding::Rgba8 => ColourEncoding::Rgba8,
            DomEncoding::Jpeg => ColourEncoding::Jpeg,
        },
        jpeg_format: ColourFormat::Bc7,
        keep_voids: args.keep_voids,
        fill_voids_km2: args.fill_voids,
        is_resumable: args.resume,
        ..PrepareRequest::new(args.dem, args.dom, args.out)
    }
}

fn text_of(summary: &PrepareSummary) -> Result<String, std::fmt::Error> {
    let mut text = String::new();
    let manifest = &summary.manifest;
    writeln!(text, "CRS      {}", manifest.crs.name)?;
    let size_km = manifest.data_extent.size_m() / 1000.0;
    match manifest.shape {
        Shape::Plane => writeln!(text, "ground   {:.1} x {:.1} km", size_km.x, size_km.y)?,
        Shape::Globe => writeln!(text, "ground   the globe")?,
    }
    let range = manifest.heights.range;
    writeln!(text, "heights  {:.1} .. {:.1} m", range.min_m, range.max_m)?;
    let mut texels =
        write_layer(&mut text, "dem", manifest.heights.layout.level_count, &summary.heights)?;
    if let Some((layer, written)) = manifest.colours.as_ref().zip(summary.colours.as_ref()) {
        texels += write_layer(&mut text, "dom", layer.layout.level_count, written)?;
    }
    for note in &manifest.notes {
        writeln!(text, "note     {note}")?;
    }
    let seconds = summary.elapsed.as_secs_f64();
    writeln!(text, "time     {seconds:.1} s, {:.1} Mpx/s", texels / 1e6 / seconds.max(1e-9))?;
    Ok(text)
}

/// A line for the layer; returns the texels of its finest level.
fn write_layer(
    text: &mut String,
    name: &str,
    levels: u8,
    layer: &LayerSummary,
) -> Result<f64, std::fmt::Error> {
    let [width, height] = layer.size_texels;
    let megabytes = layer.payload_bytes as f64 / 1e6;
    let tiles = layer.tiles;
    writeln!(
        text,
        "{name}      {width} x {height}, {levels} levels, {tiles} tiles, {megabytes:.1} MB"
    )?;
    Ok(width as f64 * height as f64)
}

/// Reads a CRS given as `EPSG:32632` or as the number alone.
pub fn parse_epsg(text: &str) -> Result<u32, String> {
    let digits = text.strip_prefix("EPSG:").or_else(|| text.strip_prefix("epsg:")).unwrap_or(text);
    digits.parse().map_err(|_| format!("{text:?} is not of the form EPSG:32632"))
}

fn parse_levels(text: &str) -> Result<Levels, String> {
    match text {
        "auto" => Ok(Levels(None)),
        _ => match text.parse() {
            Ok(levels) if (1..=25).contains(&levels) => Ok(Levels(Some(levels))),
            _ => Err("give auto or a number from 1 to 25".to_owned()),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_are_parsed_or_refused() {
        assert_eq!(parse_epsg("EPSG:32632"), Ok(32632));
        assert_eq!(parse_epsg("3857"), Ok(3857));
        assert!(parse_epsg("UTM32").is_err());
        assert!(parse_levels("auto").is_ok() && parse_levels("0").is_err());
    }
}
