//! Flights over a dataset.

use std::path::Path;

use anyhow::{bail, ensure};
use terrain_core::dataset::{Manifest, Shape, TileSource};
use terrain_core::measure::{Flight, FlightGround, PlannedFlight};

use crate::ground::Ground;

/// The flight of this name over the dataset: a file, or where there is no such file one that is made
/// for the dataset, over heights as they are drawn.
///
/// # Errors
/// Where there is neither, the file is no flight or in another CRS than the dataset's, or the dataset
/// covers no area.
pub fn find(name: &Path, source: &dyn TileSource, exaggeration: f64) -> anyhow::Result<Flight> {
    if name.is_file() {
        return read(name, source.manifest());
    }
    match name.to_string_lossy().parse() {
        Ok(planned) => plan(planned, source, exaggeration),
        Err(_) => bail!(
            "{}: no such file, and no flight of this name (there are {})",
            name.display(),
            PlannedFlight::names(),
        ),
    }
}

/// Reads a flight over the dataset.
///
/// # Errors
/// Where the file is no flight, or one in another CRS than the dataset's.
pub fn read(path: &Path, manifest: &Manifest) -> anyhow::Result<Flight> {
    let flight = Flight::read(path)?;
    let wanted = manifest.user_crs();
    ensure!(
        flight.crs() == wanted,
        "{}: the flight is in {}, the dataset in {wanted} (record one over this dataset)",
        path.display(),
        flight.crs(),
    );
    Ok(flight)
}

/// A flight made for the dataset, over heights as they are drawn.
///
/// # Errors
/// Where the dataset covers no area.
pub fn plan(
    planned: PlannedFlight,
    source: &dyn TileSource,
    exaggeration: f64,
) -> anyhow::Result<Flight> {
    let manifest = source.manifest();
    let ground = Ground::new(source);
    let height_m = |point, spacing_m| {
        ground.height_about_m(point, spacing_m).map(|height_m| height_m * exaggeration)
    };
    let layout = &manifest.heights.layout;
    let sample_m = layout.texel_size_m(&manifest.scheme, layout.finest_level());
    if manifest.shape == Shape::Globe {
        return Ok(planned.over_globe(sample_m, &height_m)?);
    }
    let (crs, extent) = (manifest.user_crs(), manifest.data_extent);
    Ok(planned.over(&FlightGround { crs, extent, sample_m, height_m: &height_m })?)
}
