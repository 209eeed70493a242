//! The most memory that preparing takes, with sources of the tile-scheduling paper's size: heights of
//! 8000 x 8000 and a picture of 24000 x 24000 by default, far more than the memory it may use.
//!
//! Prints a record as JSON: `cargo bench -p terrain-core --bench memory`, optionally with the heights'
//! side (the picture's is three times that). Needs 5 GB of disk for temporary files, and Linux for
//! the memory's high-water mark.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a measurement that fails may stop")]

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use serde_json::json;
use terrain_core::prepare::{NoProgress, PrepareRequest, prepare};
use tiff::encoder::colortype::{ColorType, GrayI16, RGB8};
use tiff::encoder::{TiffEncoder, TiffKindBig, TiffValue};
use tiff::tags::Tag;

const HEIGHTS_SIDE: u32 = 8000;
const ROWS_PER_STRIP: u32 = 16;

fn main() {
    let side = std::env::args().find_map(|text| text.parse().ok()).unwrap_or(HEIGHTS_SIDE);
    let folder = tempfile::tempdir().unwrap();
    let [dem, dom, out] = ["dem.tif", "dom.tif", "dataset"].map(|name| folder.path().join(name));
    write_rows::<GrayI16>(&dem, side, 30.0, |row, column| vec![height_m(row, column)]);
    write_rows::<RGB8>(&dom, 3 * side, 10.0, |row, column| {
        let height_m = height_m(row / 3, column / 3);
        let noise = (row.wrapping_mul(2_654_435_761) ^ column.wrapping_mul(40_503)) >> 29;
        [height_m / 16, height_m / 12, 60].map(|part| part as u8 + noise as u8).to_vec()
    });
    let source_bytes = [&dem, &dom].map(|path| path.metadata().unwrap().len());
    let before_mb = most_memory_mb();
    let started = Instant::now();
    let request = PrepareRequest::new(vec![dem], vec![dom], out);
    let summary = prepare(&request, &NoProgress, &AtomicBool::new(false)).unwrap();
    let record = json!({
        "bench": "memory",
        "heights": [side, side],
        "picture": [3 * side, 3 * side],
        "source_bytes": source_bytes,
        "tiles": [summary.heights.tiles, summary.colours.map_or(0, |layer| layer.tiles)],
        "elapsed_s": started.elapsed().as_secs_f64(),
        "most_memory_mb": { "writing the sources": before_mb, "and preparing": most_memory_mb() },
    });
    println!("{record:#}");
}

fn height_m(row: u32, column: u32) -> i16 {
    let wave = (0.01 * f64::from(row)).sin() * (0.013 * f64::from(column)).cos();
    let noise = (row.wrapping_mul(2_654_435_761) ^ column.wrapping_mul(40_503)) >> 30;
    (1200.0 + 900.0 * wave) as i16 + noise as i16
}

/// Writes a square raster strip by strip.
fn write_rows<C: ColorType>(
    path: &Path,
    side: u32,
    cell_m: f64,
    texel: impl Fn(u32, u32) -> Vec<C::Inner>,
) where
    [C::Inner]: TiffValue,
{
    let file = BufWriter::new(File::create(path).unwrap());
    let mut encoder = TiffEncoder::<_, TiffKindBig>::new_generic(file).unwrap();
    let mut image = encoder.new_image::<C>(side, side).unwrap();
    image.rows_per_strip(ROWS_PER_STRIP).unwrap();
    let geo_keys: [u16; 16] = [1, 1, 0, 3, 1024, 0, 1, 1, 1025, 0, 1, 1, 3072, 0, 1, 32632];
    let tie_point = [0.0, 0.0, 0.0, 432_000.0, 6_850_000.0, 0.0];
    let directory = image.encoder();
    directory.write_tag(Tag::ModelPixelScaleTag, &[cell_m, cell_m, 0.0][..]).unwrap();
    directory.write_tag(Tag::ModelTiepointTag, &tie_point[..]).unwrap();
    directory.write_tag(Tag::GeoKeyDirectoryTag, &geo_keys[..]).unwrap();
    for first in (0..side).step_by(ROWS_PER_STRIP as usize) {
        let rows = first..(first + ROWS_PER_STRIP).min(side);
        let places = rows.flat_map(|row| (0..side).map(move |column| (row, column)));
        let strip = places.flat_map(|(row, column)| texel(row, column)).collect::<Vec<_>>();
        image.write_strip(&strip).unwrap();
    }
    image.finish().unwrap();
}

/// The most memory this process has held so far, in MB of 10^6 bytes.
fn most_memory_mb() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap_or("0");
    let kib: u64 = line.trim().trim_end_matches(" kB").parse().unwrap_or(0);
    kib * 1024 / 1_000_000
}
