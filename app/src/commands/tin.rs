//! `terrain tin`: a raster or points in, triangles as binary glTF out.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::Context;
use clap::Args;
use terrain_core::prepare::{MadeTin, TinRequest, make_tin};
use terrain_core::surface::tin::write_glb;

use crate::commands::prepare::parse_epsg;
use crate::interrupt::flag_on_ctrl_c;
use crate::output;
use crate::progress::PhaseProgress;

/// Makes triangles of a raster or of points
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  terrain tin dem.tif --max-error 5 --out dem.glb
  terrain tin dem.tif --max-error 5 --breaklines ridges.geojson --out dem.glb
  terrain tin survey.laz --point-class 2 --out survey.glb

The file's axes are x east, y up, z south, in metres from the origin that its node's extras name
together with the CRS. Texture coordinates span the raster, north-west corner first.")]
pub struct TinArgs {
    /// A height raster (GeoTIFF, SRTM .hgt, grey PNG with a world file), or points (LAS, LAZ, and
    /// .csv, .xyz, .txt of x, y, height)
    #[arg(value_name = "FILE", num_args = 1.., required = true)]
    ground: Vec<PathBuf>,

    /// Farthest that any sample may lie above or below the triangles; a raster needs it, of points
    /// all are joined without
    #[arg(long, value_name = "METRES", allow_hyphen_values = true)]
    max_error: Option<f64>,

    /// Lines that triangles must not cross: GeoJSON, with heights or without
    #[arg(long, value_name = "FILE")]
    breaklines: Option<PathBuf>,

    /// File to write, binary glTF
    #[arg(long, value_name = "FILE")]
    out: PathBuf,

    /// CRS of a file that does not say its own
    #[arg(long, value_name = "EPSG:n", value_parser = parse_epsg)]
    crs: Option<u32>,

    /// LAS classes to take, such as 2 for ground or 2,9 [default: 2 if the file has any, else all]
    #[arg(long, value_name = "CLASS", value_delimiter = ',')]
    point_class: Vec<u8>,

    /// Print what was made as JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(args: &TinArgs) -> anyhow::Result<()> {
    let started = Instant::now();
    let request = TinRequest {
        ground: args.ground.clone(),
        max_error_m: args.max_error,
        breaklines: args.breaklines.clone(),
        epsg: args.crs,
        point_classes: args.point_class.clone(),
    };
    let cancel = flag_on_ctrl_c()?;
    let bar = PhaseProgress::new();
    let made = make_tin(&request, &bar, &cancel);
    bar.clear();
    let made = made?;
    let file = write_glb(&made.tin, &made.place).with_context(|| args.out.display().to_string())?;
    output::write_whole(&args.out, &file)?;
    let seconds = started.elapsed().as_secs_f64();
    match args.json {
        true => output::print(&format!("{:#}\n", json_of(args, &made, file.len(), seconds))),
        false => output::print(&text_of(args, &made, file.len(), seconds)),
    }
}

fn json_of(args: &TinArgs, made: &MadeTin, bytes: usize, seconds: f64) -> serde_json::Value {
    let extent = made.place.extent;
    serde_json::json!({
        "file": args.out,
        "bytes": bytes,
        "triangles": made.tin.triangles.len(),
        "vertices": made.tin.vertices.len(),
        "samples": made.samples,
        "max_error_m": args.max_error,
        "largest_error_m": made.largest_error_m,
        "crs": made.place.crs,
        "extent": [extent.min.x, extent.min.y, extent.max.x, extent.max.y],
        "notes": made.notes,
        "seconds": seconds,
    })
}

fn text_of(args: &TinArgs, made: &MadeTin, bytes: usize, seconds: f64) -> String {
    let (triangles, vertices) = (made.tin.triangles.len(), made.tin.vertices.len());
    let percent = 100.0 * vertices as f64 / made.samples.max(1) as f64;
    let mut text = format!(
        "CRS        {}\ntriangles  {triangles}\nvertices   {vertices}, {percent:.1} % of {} samples\n\
         error      {:.4} m at most at any sample\n",
        made.place.crs.as_deref().unwrap_or("not known"),
        made.samples,
        made.largest_error_m,
    );
    for note in &made.notes {
        text += &format!("note       {note}\n");
    }
    text + &format!(
        "file       {}, {:.1} MB\ntime       {seconds:.2} s\n",
        args.out.display(),
        bytes as f64 / 1e6
    )
}
