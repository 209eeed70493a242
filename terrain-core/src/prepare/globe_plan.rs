//! Settles the grids of a dataset of the whole globe. Its CRS and its root are always the same; sources say how fine
//! the levels are, and where there is anything.

use super::mosaic::{Mosaic, PlacedRaster};
use super::placement::{extent_in, name_of, place_colours, place_heights};
use super::plan::{LayerPlan, MOST_CELLS, Plan, TEXEL_PER_PIXEL, cell_in, middle_of};
use super::resample::{LayerGrid, Resampler};
use super::run::Run;
use super::source::is_point_file;
use super::{PrepareError, PrepareRequest};
use crate::geodesy::{CoordinateSystem, PlateCarree};
use crate::tiling::MAX_LEVEL;

/// Opens all sources and plans the dataset.
pub fn plan_globe(request: &PrepareRequest, run: &Run<'_>) -> Result<Plan, PrepareError> {
    check(request)?;
    let mut notes = Vec::new();
    let crs = CoordinateSystem::from_epsg(PlateCarree::EPSG)?;
    let height_rasters = match request.heights.is_empty() {
        true => Vec::new(),
        false => {
            let note =
                "heights are taken as metres above the ellipsoid, whatever the sources' own datum";
            notes.push(note.to_owned());
            place_heights(request, &mut notes, run)?
        }
    };
    let wgs84 = CoordinateSystem::from_epsg(CoordinateSystem::WGS84)?;
    let colour_rasters = place_colours(request, &wgs84, &mut notes)?;
    for raster in height_rasters.iter().chain(&colour_rasters) {
        note_part(raster, &mut notes);
    }
    let steps = height_rasters.iter().map(|raster| raster.source.info().height_step_m);
    let height_step_m = steps.reduce(f64::min).unwrap_or(0.0);
    let layer = |rasters, tile_texels| layer_plan(request, &crs, rasters, tile_texels);
    let heights = layer(height_rasters, request.height_tile_texels)?;
    let colours = match colour_rasters.is_empty() {
        true => None,
        false => Some(layer(colour_rasters, request.colour_tile_texels)?),
    };
    let (scheme, data_extent) = (PlateCarree::scheme(), PlateCarree::extent());
    Ok(Plan { crs, scheme, data_extent, heights, colours, height_step_m, notes })
}

fn check(request: &PrepareRequest) -> Result<(), PrepareError> {
    let refused = |reason: &str| Err(PrepareError::Request(reason.to_owned()));
    if request.heights.is_empty() && request.colours.is_empty() {
        return refused("--globe needs rasters: name some with --dem or --dom");
    }
    if request.epsg.is_some() {
        return refused("--globe has a CRS of its own; leave --crs out");
    }
    if request.keep_voids {
        return refused("--globe has heights everywhere; leave --keep-voids out");
    }
    match request.heights.iter().any(|path| is_point_file(path)) {
        true => refused(
            "--globe takes rasters of heights, no points; `terrain tin` can make one of them",
        ),
        false => Ok(()),
    }
}

/// Says so where a raster leaves a part of the globe uncovered.
fn note_part(raster: &PlacedRaster, notes: &mut Vec<String>) {
    let covers_all = match raster.crs.is_geographic() {
        true => {
            let (min, max) = raster.grid.bounds(raster.source.info().size);
            // A raster of nodes may end a cell before it began.
            let size = max - min + 1.01 * raster.grid.cell;
            size.x >= 360.0 && size.y >= 180.0
        }
        false => false,
    };
    if !covers_all {
        notes.push(format!("{}: covers a part of the globe only", name_of(raster.source.path())));
    }
}

/// The coarsest grid of whole tiles round the globe whose texels are small enough for the rasters; without any
/// that of the root.
fn layer_plan(
    request: &PrepareRequest,
    crs: &CoordinateSystem,
    rasters: Vec<PlacedRaster>,
    tile_texels: u32,
) -> Result<LayerPlan, PrepareError> {
    let mut pixel_m = f64::INFINITY;
    for raster in &rasters {
        let cell = extent_in(raster, crs).and_then(|_| cell_in(raster, crs, middle_of(raster)));
        let cell = cell.ok_or_else(|| PrepareError::Misplaced {
            path: raster.source.path().to_owned(),
            reason: "its place on the globe cannot be computed".to_owned(),
        })?;
        pixel_m = pixel_m.min(cell.min_element());
    }
    let texel_m =
        |level: u8| PlateCarree::EQUATOR_M / f64::from(tile_texels) / f64::from(1_u32 << level);
    let finest = request.level_limit.map_or(MAX_LEVEL, |limit| limit - 1);
    let level =
        (0..finest).find(|&level| texel_m(level) <= TEXEL_PER_PIXEL * pixel_m).unwrap_or(finest);
    let width = (tile_texels as usize) << level;
    if width as f64 > MOST_CELLS {
        return Err(PrepareError::Request(format!(
            "pixels of {pixel_m:.3} m make a globe of {width} x {} texels; limit it with --levels",
            width / 2
        )));
    }
    let grid = LayerGrid {
        origin: PlateCarree::scheme().origin,
        texel_m: texel_m(level),
        width,
        height: width / 2,
    };
    let rows = Resampler::new(grid, crs, Mosaic::group(rasters));
    Ok(LayerPlan { rows, level_count: level + 1 })
}
