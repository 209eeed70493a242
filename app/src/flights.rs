//! Flights over a dataset.

use std::path::Path;

use anyhow::ensure;
use terrain_core::dataset::{Manifest, TileSource};
use terrain_core::measure::Flight;

use crate::ground::Ground;

/// Level whose heights are fine enough to plan a flight by.
const PLANNING_LEVEL: u8 = 4;

/// The dataset's CRS as flight files name it.
pub fn crs_code(manifest: &Manifest) -> String {
    manifest.crs.epsg.map_or_else(|| manifest.crs.name.clone(), |code| format!("EPSG:{code}"))
}

/// Reads a flight over the dataset.
///
/// # Errors
/// Where the file is no flight, or one in another CRS than the dataset's.
pub fn read(path: &Path, manifest: &Manifest) -> anyhow::Result<Flight> {
    let flight = Flight::read(path)?;
    let wanted = crs_code(manifest);
    ensure!(
        flight.crs() == wanted,
        "{}: the flight is in {}, the dataset in {wanted} (record one over this dataset)",
        path.display(),
        flight.crs(),
    );
    Ok(flight)
}

/// A tour of the whole dataset, over heights as they are drawn.
///
/// # Errors
/// Where the dataset covers no area.
pub fn tour(source: &dyn TileSource, exaggeration: f64) -> anyhow::Result<Flight> {
    let manifest = source.manifest();
    let ground = Ground::to_level(source, PLANNING_LEVEL);
    let height_m = |point| ground.height_m(point).unwrap_or(f64::NAN) * exaggeration;
    Ok(Flight::tour(crs_code(manifest), &manifest.data_extent, &height_m)?)
}
