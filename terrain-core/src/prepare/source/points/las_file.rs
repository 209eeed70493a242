//! LAS and LAZ (ASPRS, "LAS Specification 1.4 - R15", 2019).

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Seek};
use std::panic::catch_unwind;
use std::path::Path;

use las::{PointData, PointDataBuilder, Reader, Vlr};

use super::super::SourceError;
use super::super::geo_keys::GeoTags;
use super::las_sizes::check_sizes;
use super::wkt::epsg_of_wkt;
use super::{GROUND_CLASS, PointCloud, name_of};

/// Points decoded at a time.
const BATCH: u64 = 1 << 16;
/// Most points that room is made for before they are there.
const MOST_RESERVED: u64 = 1 << 22;
/// The record of GeoTIFF keys.
const GEO_KEY_DIRECTORY: u16 = 34735;

/// Reads the points of these classes; of none, ground if there is any, else all.
pub fn read(path: &Path, classes: &[u8]) -> Result<PointCloud, SourceError> {
    let bytes = std::fs::metadata(path).map_err(|error| SourceError::io(path, &error))?.len();
    if bytes == 0 {
        return Err(SourceError::no_points(path, "the file is empty"));
    }
    let damaged = |reason: String| SourceError::damaged(path, reason);
    // The decoder trusts what a file says of itself in places that have not all been found: what
    // breaks its assumptions is damage, not a reason to end the program.
    let decoded = catch_unwind(|| decode(path, bytes));
    let decoded = decoded.map_err(|_| damaged("its points cannot be decoded".to_owned()))?;
    let Decoded { epsg, points: all } = decoded.map_err(damaged)?;
    let mut counts = BTreeMap::<u8, usize>::new();
    all.iter().for_each(|(class, _)| *counts.entry(*class).or_default() += 1);
    let chosen: Vec<u8> = match classes {
        [] if counts.contains_key(&GROUND_CLASS) => vec![GROUND_CLASS],
        [] => counts.keys().copied().collect(),
        classes => classes.to_vec(),
    };
    let total = all.len();
    let kept = all.into_iter().filter(|(class, _)| chosen.contains(class));
    let points: Vec<[f64; 3]> = kept.map(|(_, point)| point).collect();
    if points.is_empty() {
        return Err(SourceError::no_points(path, &why_none(total, classes, &counts)));
    }
    if let Some(bad) = points.iter().find(|point| point.iter().any(|value| !value.is_finite())) {
        return Err(SourceError::damaged(path, format!("a point at {bad:?}")));
    }
    let which = match (classes, chosen.as_slice()) {
        ([], [GROUND_CLASS]) => {
            "those of class 2, ground (--point-class chooses others)".to_owned()
        }
        ([], _) => "all classes, since none is ground (--point-class chooses)".to_owned(),
        (classes, _) => format!("those of class {}", listed(classes.iter())),
    };
    let note = format!("{}: {} of {total} points, {which}", name_of(path), points.len());
    let is_own_choice = classes.is_empty();
    Ok(PointCloud { path: path.to_owned(), points, epsg, note, is_own_choice })
}

/// What a file holds.
struct Decoded {
    epsg: Option<u32>,
    /// Class and place of every point that is not withheld.
    points: Vec<(u8, [f64; 3])>,
}

fn decode(path: &Path, file_bytes: u64) -> Result<Decoded, String> {
    let failed = |error: las::Error| error.to_string();
    let mut file = File::open(path).map_err(|error| error.to_string())?;
    check_sizes(&mut file)?;
    file.rewind().map_err(|error| error.to_string())?;
    let mut reader = Reader::new(BufReader::new(file)).map_err(failed)?;
    check_compression(&reader)?;
    let points = read_all(&mut reader, file_bytes).map_err(failed)?;
    Ok(Decoded { epsg: epsg_of(&reader), points })
}

/// The parts that a LAZ file's points are compressed in must make up a point (M. Isenburg, "LASzip:
/// lossless compression of lidar data", 2013).
fn check_compression(reader: &Reader) -> Result<(), String> {
    /// The record that says how points are compressed; a list of parts begins at this byte of it.
    const LASZIP: (&str, u16) = ("laszip encoded", 22204);
    const PARTS_AT: usize = 34;
    let header = reader.header();
    if !header.point_format().is_compressed {
        return Ok(());
    }
    let is_laszip = |record: &&Vlr| (record.user_id.as_str(), record.record_id) == LASZIP;
    let Some(record) = header.all_vlrs().find(is_laszip) else {
        return Err("it does not say how its points are compressed".to_owned());
    };
    // Kind, bytes and version of each, 16 bits each.
    let parts = record.data.get(PARTS_AT..).unwrap_or_default().chunks_exact(6);
    let bytes: u64 = parts.map(|part| u64::from(u16::from_le_bytes([part[2], part[3]]))).sum();
    match u64::from(header.point_format().len()) {
        whole if whole == bytes => Ok(()),
        whole => Err(format!("points of {whole} bytes are compressed as {bytes}")),
    }
}

fn read_all(reader: &mut Reader, file_bytes: u64) -> las::Result<Vec<(u8, [f64; 3])>> {
    // A damaged header may promise any number; a point takes more than a bit of the file.
    let promised = reader.header().number_of_points().min(8 * file_bytes);
    let mut points = Vec::with_capacity(promised.min(MOST_RESERVED) as usize);
    let mut batch = PointDataBuilder::new().for_header(reader.header()).build();
    while reader.fill_points(promised.clamp(1, BATCH), &mut batch)? > 0 {
        let places = batch.x().zip(batch.y()).zip(batch.z()).map(|((x, y), z)| [x, y, z]);
        let kept = batch.classification().zip(places).zip(withheld(&batch));
        points.extend(kept.filter(|(_, withheld)| !withheld).map(|(point, _)| point));
    }
    Ok(points)
}

/// Whether each point is marked as withheld: not to be used.
fn withheld(batch: &PointData) -> impl Iterator<Item = bool> + '_ {
    // Byte 15 holds the class and three flags in the old formats, flags alone in the extended ones.
    let flag = if batch.format().is_extended { 1 << 2 } else { 1 << 7 };
    let records = batch.raw_bytes().chunks_exact(batch.record_len().max(1));
    records.map(move |record| record.get(15).is_some_and(|flags| flags & flag != 0))
}

fn why_none(total: usize, classes: &[u8], counts: &BTreeMap<u8, usize>) -> String {
    if total == 0 {
        return "holds no points".to_owned();
    }
    let has: Vec<String> =
        counts.iter().map(|(class, count)| format!("{class} ({count} points)")).collect();
    let asked = listed(classes.iter());
    format!("no points of class {asked}; it has {}: choose with --point-class", has.join(", "))
}

fn listed<'a>(classes: impl Iterator<Item = &'a u8>) -> String {
    classes.map(u8::to_string).collect::<Vec<_>>().join(", ")
}

/// The EPSG code in the file's records: well-known text or GeoTIFF keys.
fn epsg_of(reader: &Reader) -> Option<u32> {
    let header = reader.header();
    let by_text =
        header.get_wkt_crs_bytes().and_then(|bytes| epsg_of_wkt(&String::from_utf8_lossy(bytes)));
    by_text.or_else(|| header.all_vlrs().find_map(epsg_of_keys))
}

fn epsg_of_keys(record: &Vlr) -> Option<u32> {
    if record.record_id != GEO_KEY_DIRECTORY || !record.is_geotiff_crs() {
        return None;
    }
    let keys = record.data.chunks_exact(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]]));
    GeoTags { key_directory: Some(keys.collect()), ..GeoTags::default() }.epsg()
}
