//! Settles the CRS, the tiling scheme and the grids of both layers before any tile is made.

use glam::{DVec2, dvec2};

use super::globe_plan::plan_globe;
use super::mosaic::{Mosaic, PlacedRaster};
use super::placement::{extent_in, name_of, place_colours, place_heights};
use super::resample::{LayerGrid, Resampler};
use super::run::Run;
use super::source::RasterGrid;
use super::{PrepareError, PrepareRequest};
use crate::dataset::Shape;
use crate::geodesy::{CoordinateSystem, CoordinateTransform, utm_epsg};
use crate::tiling::{Extent, MAX_LEVEL, TilingScheme};

/// What will be made.
pub struct Plan {
    /// The dataset's CRS.
    pub crs: CoordinateSystem,
    /// The frame of all tiles.
    pub scheme: TilingScheme,
    /// The ground the heights cover.
    pub data_extent: Extent,
    /// The height layer's finest raster.
    pub heights: LayerPlan,
    /// The colour layer's finest raster, where there are pictures.
    pub colours: Option<LayerPlan>,
    /// The smallest difference between two source heights, metres; 0 for floats.
    pub height_step_m: f64,
    /// What a user should know.
    pub notes: Vec<String>,
}

/// One layer's finest raster and its levels.
pub struct LayerPlan {
    /// Where its rows come from.
    pub rows: Resampler,
    /// Levels between the root and this raster, both counted.
    pub level_count: u8,
}

/// Most columns or rows of a layer: beyond this a CRS is mistaken for another.
pub const MOST_CELLS: f64 = 1.0e6;

/// The finest colour texel may be this much larger than a source pixel, so that a picture that all
/// but fits a level does not take four times the space for nothing.
pub const TEXEL_PER_PIXEL: f64 = 1.1;

impl Plan {
    /// Opens all sources and plans the dataset.
    pub fn new(request: &PrepareRequest, run: &Run<'_>) -> Result<Self, PrepareError> {
        check(request)?;
        if request.shape == Shape::Globe {
            return plan_globe(request, run);
        }
        let stated = stated_crs(request)?;
        let mut notes = Vec::new();
        let height_rasters = place_heights(request, &mut notes, run)?;
        let crs = stated.map_or_else(|| crs_of_heights(&height_rasters), Ok)?;
        let colour_rasters = place_colours(request, &height_rasters[0].crs, &mut notes)?;
        note_vertical_datum(&mut notes);

        let steps = height_rasters.iter().map(|raster| raster.source.info().height_step_m);
        let height_step_m = steps.fold(f64::INFINITY, f64::min);
        let grid = height_grid(&height_rasters, &crs, &mut notes)?;
        let extent = extent_of(&grid);
        check_colours_meet(&colour_rasters, &crs, &extent)?;
        let (scheme, level_count) = scheme_of(&grid, request.height_tile_texels)?;
        let rows = Resampler::new(grid, &crs, Mosaic::group(height_rasters));
        let heights = LayerPlan { rows, level_count };
        let colours = if colour_rasters.is_empty() {
            None
        } else {
            Some(colour_plan(request, &scheme, &crs, &extent, colour_rasters, &mut notes)?)
        };
        Ok(Self { crs, scheme, data_extent: extent, heights, colours, height_step_m, notes })
    }

    /// Where both layers' finest rasters and their sources lie.
    pub fn grids(&self) -> Vec<(LayerGrid, Vec<RasterGrid>)> {
        let layers = std::iter::once(&self.heights).chain(&self.colours);
        layers.map(|layer| (*layer.rows.target(), layer.rows.source_grids())).collect()
    }
}

fn check(request: &PrepareRequest) -> Result<(), PrepareError> {
    for size in [request.height_tile_texels, request.colour_tile_texels] {
        if !(16..=2048).contains(&size) || size % 8 != 0 {
            let reason = format!("a tile of {size} texels: give a multiple of 8 from 16 to 2048");
            return Err(PrepareError::Request(reason));
        }
    }
    let is_length = |metres: f64| metres.is_finite() && metres > 0.0;
    if request.points.spacing_m.is_some_and(|spacing_m| !is_length(spacing_m)) {
        return Err(PrepareError::Request("--point-spacing needs metres, more than 0".into()));
    }
    if request.fill_voids_km2.is_some_and(|km2| km2.is_nan() || km2 < 0.0) {
        return Err(PrepareError::Request(
            "--fill-voids needs square kilometres, 0 or more".into(),
        ));
    }
    if request.level_limit == Some(0) {
        return Err(PrepareError::Request("--levels 0: there is at least one level".into()));
    }
    Ok(())
}

/// The CRS asked for.
fn stated_crs(request: &PrepareRequest) -> Result<Option<CoordinateSystem>, PrepareError> {
    let Some(epsg) = request.epsg else { return Ok(None) };
    let crs = CoordinateSystem::from_epsg(epsg)?;
    match is_in_metres(&crs) {
        true => Ok(Some(crs)),
        false => Err(PrepareError::Request(format!(
            "--crs EPSG:{epsg}: a dataset needs a projected CRS in metres, such as a UTM zone"
        ))),
    }
}

/// The heights' own CRS where it is in metres, else the UTM zone they lie in.
fn crs_of_heights(rasters: &[PlacedRaster]) -> Result<CoordinateSystem, PrepareError> {
    let first = &rasters[0];
    if is_in_metres(&first.crs) {
        return Ok(first.crs.clone());
    }
    let wgs84 = CoordinateSystem::from_epsg(CoordinateSystem::WGS84)?;
    let misplaced =
        |reason: String| PrepareError::Misplaced { path: first.source.path().to_owned(), reason };
    let extents = rasters.iter().filter_map(|raster| extent_in(raster, &wgs84));
    let extent = extents
        .reduce(|a, b| a.union(&b))
        .ok_or_else(|| misplaced("its place on Earth cannot be computed".into()))?;
    const WIDEST_FOR_UTM_DEG: f64 = 24.0;
    let width_deg = extent.size_m().x;
    if width_deg > WIDEST_FOR_UTM_DEG {
        return Err(misplaced(format!(
            "spans {width_deg:.0} degrees of longitude, too wide for a UTM zone; choose a CRS in \
             metres with --crs, such as EPSG:4087 or EPSG:3395 for the whole Earth"
        )));
    }
    Ok(CoordinateSystem::from_epsg(utm_epsg(extent.centre()))?)
}

/// Whether a CRS is projected and its unit the metre.
pub fn is_in_metres(crs: &CoordinateSystem) -> bool {
    !crs.is_geographic() && (crs.metres_per_unit() - 1.0).abs() < 1e-9
}

fn note_vertical_datum(notes: &mut Vec<String>) {
    notes.push("heights are taken as metres above the sources' own vertical datum".to_owned());
}

/// The heights' own grid where it can be kept, else a new one of about the same cells.
fn height_grid(
    rasters: &[PlacedRaster],
    crs: &CoordinateSystem,
    notes: &mut Vec<String>,
) -> Result<LayerGrid, PrepareError> {
    let groups = Mosaic::group(rasters.to_vec());
    if let [mosaic] = &groups[..] {
        let (cell, size) = (mosaic.grid().cell, mosaic.size());
        let drift = (cell.x - cell.y).abs() / cell.x * f64::from(size[0].max(size[1]));
        if mosaic.crs() == crs && drift < 0.01 {
            let [width, height] = size.map(|size| size as usize);
            return Ok(LayerGrid { origin: mosaic.grid().origin, texel_m: cell.x, width, height });
        }
    }
    let grid = new_grid(rasters, crs)?;
    let from = &rasters[0].crs;
    let why = match from == crs {
        true if groups.len() > 1 => "their grids differ".to_owned(),
        true => "the cells are not square".to_owned(),
        false => format!("from {} to {}", from.name(), crs.name()),
    };
    notes.push(format!(
        "heights resampled ({why}) to cells of {} m, bicubic between cells that all hold data",
        grid.texel_m
    ));
    Ok(grid)
}

fn new_grid(rasters: &[PlacedRaster], crs: &CoordinateSystem) -> Result<LayerGrid, PrepareError> {
    let mut extent: Option<Extent> = None;
    let mut texel_m = f64::INFINITY;
    for raster in rasters {
        let misplaced = || PrepareError::Misplaced {
            path: raster.source.path().to_owned(),
            reason: format!("does not lie where {} can show it; try another --crs", crs.name()),
        };
        let own = extent_in(raster, crs).ok_or_else(misplaced)?;
        extent = Some(extent.map_or(own, |extent| extent.union(&own)));
        let cell = cell_in(raster, crs, middle_of(raster)).ok_or_else(misplaced)?;
        texel_m = texel_m.min((cell.x * cell.y).sqrt());
    }
    let extent = extent.unwrap_or(Extent::new(DVec2::ZERO, DVec2::ZERO));
    let texel_m = rounded_down(texel_m);
    let origin = dvec2(
        (extent.min.x / texel_m).floor() * texel_m,
        (extent.max.y / texel_m).ceil() * texel_m,
    );
    let cells = (dvec2(extent.max.x - origin.x, origin.y - extent.min.y) / texel_m).ceil();
    if !(cells.is_finite() && cells.min_element() >= 1.0 && cells.max_element() <= MOST_CELLS) {
        let path = rasters[0].source.path().to_owned();
        let reason = format!("{} x {} cells of {texel_m} m; is --crs right?", cells.x, cells.y);
        return Err(PrepareError::Misplaced { path, reason });
    }
    Ok(LayerGrid { origin, texel_m, width: cells.x as usize, height: cells.y as usize })
}

/// Columns and rows of the raster's place nearest to a point of another CRS. A picture of the whole
/// Earth has pixels of very different size in a CRS made for a small part of it.
fn place_nearest(raster: &PlacedRaster, crs: &CoordinateSystem, point: DVec2) -> Option<DVec2> {
    let position = CoordinateTransform::new(crs, &raster.crs).apply(point)?;
    let [width, height] = raster.source.info().size.map(f64::from);
    Some(raster.grid.columns_rows(position).clamp(DVec2::ZERO, dvec2(width, height)))
}

/// Columns and rows of a raster's middle.
pub fn middle_of(raster: &PlacedRaster) -> DVec2 {
    let [width, height] = raster.source.info().size.map(f64::from);
    0.5 * dvec2(width, height)
}

/// Width and height in metres of the raster's cell at `place` (columns and rows) in another CRS.
pub fn cell_in(raster: &PlacedRaster, crs: &CoordinateSystem, place: DVec2) -> Option<DVec2> {
    let transform = CoordinateTransform::new(&raster.crs, crs);
    let [south, north] = crs.latitude_limits_deg();
    let at = |column: f64, row: f64| {
        let mut position = raster.grid.position(place + dvec2(column, row));
        if raster.crs.is_geographic() {
            position.y = position.y.clamp(south, north);
        }
        transform.apply(position)
    };
    let east = at(0.5, 0.0)? - at(-0.5, 0.0)?;
    let north = at(0.0, -0.5)? - at(0.0, 0.5)?;
    let cell = dvec2(east.length(), north.length());
    (cell.is_finite() && cell.min_element() > 0.0).then_some(cell)
}

/// Three significant digits, not more than the value.
fn rounded_down(value: f64) -> f64 {
    let unit = 10.0_f64.powf(value.log10().floor() - 2.0);
    // Dividing by the inverse keeps decimal values such as 76.6 exact.
    if unit < 1.0 {
        (value / unit).floor() / (1.0 / unit).round()
    } else {
        (value / unit).floor() * unit
    }
}

fn extent_of(grid: &LayerGrid) -> Extent {
    let far = grid.origin + grid.texel_m * dvec2(grid.width as f64, -(grid.height as f64));
    Extent::new(dvec2(grid.origin.x, far.y), dvec2(far.x, grid.origin.y))
}

/// The smallest root of whole tiles over the heights' finest raster, and its levels.
fn scheme_of(grid: &LayerGrid, tile_texels: u32) -> Result<(TilingScheme, u8), PrepareError> {
    let tiles = grid.width.max(grid.height).div_ceil(tile_texels as usize);
    let levels = tiles.next_power_of_two().trailing_zeros();
    if levels > u32::from(MAX_LEVEL) {
        let reason = format!("{} x {} cells are more than can be tiled", grid.width, grid.height);
        return Err(PrepareError::Request(reason));
    }
    let root_size_m = grid.texel_m * f64::from(tile_texels) * f64::from(1_u32 << levels);
    Ok((TilingScheme { origin: grid.origin, root_size_m }, levels as u8 + 1))
}

fn check_colours_meet(
    rasters: &[PlacedRaster],
    crs: &CoordinateSystem,
    extent: &Extent,
) -> Result<(), PrepareError> {
    for raster in rasters {
        let own = extent_in(raster, crs);
        if !own.is_some_and(|own| own.overlaps(extent)) {
            return Err(PrepareError::Misplaced {
                path: raster.source.path().to_owned(),
                reason: "does not meet the heights' extent; is its CRS right (--dom-crs)?".into(),
            });
        }
    }
    Ok(())
}

fn colour_plan(
    request: &PrepareRequest,
    scheme: &TilingScheme,
    crs: &CoordinateSystem,
    extent: &Extent,
    rasters: Vec<PlacedRaster>,
    notes: &mut Vec<String>,
) -> Result<LayerPlan, PrepareError> {
    let pixels = rasters
        .iter()
        .filter_map(|raster| cell_in(raster, crs, place_nearest(raster, crs, extent.centre())?));
    let pixel_m = pixels.map(DVec2::min_element).fold(f64::INFINITY, f64::min);
    let tile_texels = f64::from(request.colour_tile_texels);
    let texel_m = |level: u8| scheme.tile_size_m(level) / tile_texels;
    let level = (0..MAX_LEVEL)
        .find(|&level| texel_m(level) <= TEXEL_PER_PIXEL * pixel_m)
        .ok_or_else(|| PrepareError::Request("the pictures' pixels are too small".into()))?;
    for raster in &rasters {
        let own = extent_in(raster, crs);
        let inside = own.is_some_and(|own| {
            let slack_m = 2.0 * pixel_m;
            let margin = own.grown(slack_m);
            margin.contains(extent.min) && margin.contains(extent.max)
        });
        let name = name_of(raster.source.path());
        if !inside && rasters.len() == 1 {
            notes.push(format!("{name}: covers a part of the heights only"));
        }
        let kept = extent.grown(2.0 * pixel_m);
        if own.is_some_and(|own| !(kept.contains(own.min) && kept.contains(own.max))) {
            notes.push(format!("{name}: cut to the ground that the heights cover"));
        }
    }
    let size = (extent.size_m() / texel_m(level) - 1e-6).ceil();
    if size.max_element() > MOST_CELLS {
        let path = rasters[0].source.path().to_owned();
        let reason = format!(
            "pixels of {pixel_m} m are too small for the heights' extent; is its CRS right (--dom-crs)?"
        );
        return Err(PrepareError::Misplaced { path, reason });
    }
    let grid = LayerGrid {
        origin: scheme.origin,
        texel_m: texel_m(level),
        width: size.x.max(1.0) as usize,
        height: size.y.max(1.0) as usize,
    };
    let rows = Resampler::new(grid, crs, Mosaic::group(rasters));
    if rows.unchanged().is_none() {
        notes.push(format!(
            "colours resampled in linear light from pixels of {pixel_m:.3} m to texels of {:.3} m",
            grid.texel_m
        ));
    }
    Ok(LayerPlan { rows, level_count: level + 1 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_rounded_down_to_three_digits() {
        for (value, expected) in [(76.68, 76.6), (117.19, 117.0), (9276.6, 9270.0), (0.2519, 0.251)]
        {
            assert_eq!(rounded_down(value), expected);
        }
    }

    #[test]
    fn the_root_is_the_smallest_that_holds_the_raster() {
        let grid = |width, height| LayerGrid { origin: DVec2::ZERO, texel_m: 30.0, width, height };
        for (width, height, levels) in [(1, 1, 1), (128, 128, 1), (129, 5, 2), (8000, 8000, 7)] {
            let (scheme, level_count) = scheme_of(&grid(width, height), 128).unwrap();
            assert_eq!(level_count, levels);
            assert_eq!(scheme.root_size_m, 30.0 * 128.0 * f64::from(1 << (levels - 1)));
        }
    }
}
