//! Where the sources lie: opening them, and settling what their files leave open.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{DVec2, dvec2};

use super::mosaic::PlacedRaster;
use super::placed_points::place_points;
use super::run::Run;
use super::source::{RasterContent, RasterGrid, RasterSource, is_point_file, open_raster};
use super::{PrepareError, PrepareRequest};
use crate::dataset::Shape;
use crate::geodesy::{CoordinateSystem, CoordinateTransform, epsg_name};
use crate::tiling::Extent;

/// Opens and places all height rasters.
///
/// All files of points make one raster, in the first one's place.
pub fn place_heights(
    request: &PrepareRequest,
    notes: &mut Vec<String>,
    run: &Run<'_>,
) -> Result<Vec<PlacedRaster>, PrepareError> {
    let points = request.heights.iter().filter(|path| is_point_file(path));
    let points: Vec<PathBuf> = points.cloned().collect();
    let mut placed = Vec::new();
    for path in &request.heights {
        if is_point_file(path) {
            if points.first() == Some(path) {
                placed.push(place_points(request, &points, notes, run)?);
            }
            continue;
        }
        let source = open_raster(path)?;
        if source.info().content == RasterContent::Picture {
            let reason = "a picture, not heights; give it with --dom".to_owned();
            return Err(PrepareError::Misplaced { path: path.clone(), reason });
        }
        let grid = source.info().grid.ok_or_else(|| not_georeferenced(path, "--dem"))?;
        let crs = crs_of(source.as_ref(), assumed_epsg(request), notes)?;
        placed.push(checked(source, grid, crs, notes)?);
    }
    match placed.is_empty() {
        true => Err(PrepareError::Request("no height raster is given; name one with --dem".into())),
        false => Ok(placed),
    }
}

/// West, south, east and north of all longitudes and latitudes.
const WHOLE_EARTH_DEG: [f64; 4] = [-180.0, -90.0, 180.0, 90.0];

/// What the CRS of rasters is taken to be that do not say theirs.
fn assumed_epsg(request: &PrepareRequest) -> Option<u32> {
    match request.shape {
        Shape::Plane => request.epsg,
        Shape::Globe => Some(CoordinateSystem::WGS84),
    }
}

/// Where a picture without a georeference lies: where the request says, or everywhere on a globe if it is twice as
/// wide as high.
fn bounds_of(size: [u32; 2], request: &PrepareRequest) -> Option<([f64; 4], &'static str)> {
    if let Some(bounds) = request.colour_bounds {
        return Some((bounds, "placed by --dom-extent"));
    }
    let is_whole =
        request.shape == Shape::Globe && request.colour_epsg.is_none() && size[0] == 2 * size[1];
    let why = "no georeference and twice as wide as high, taken as the whole Earth";
    is_whole.then_some((WHOLE_EARTH_DEG, why))
}

/// Opens and places all pictures. One without a CRS is taken to be in the heights' (`assumed`).
pub fn place_colours(
    request: &PrepareRequest,
    assumed: &CoordinateSystem,
    notes: &mut Vec<String>,
) -> Result<Vec<PlacedRaster>, PrepareError> {
    let mut placed = Vec::new();
    for path in &request.colours {
        let source = open_raster(path)?;
        if source.info().content == RasterContent::Measurements {
            let reason = "heights, not a picture; give it with --dem".to_owned();
            return Err(PrepareError::Misplaced { path: path.clone(), reason });
        }
        let on_globe = (request.shape == Shape::Globe).then_some(CoordinateSystem::WGS84);
        let stated = request.colour_epsg.or(on_globe);
        let (grid, crs) = match (source.info().grid, bounds_of(source.info().size, request)) {
            (Some(grid), _) if source.info().epsg.is_none() && stated.is_none() => {
                notes.push(format!(
                    "{}: no CRS in the file, taken to be that of the heights ({})",
                    name_of(path),
                    assumed.name()
                ));
                (grid, assumed.clone())
            }
            (Some(grid), _) => (grid, crs_of(source.as_ref(), stated, notes)?),
            (None, Some((bounds, why))) => {
                let crs = bounds_crs(request, bounds)?;
                notes.push(format!("{}: {why}, {}", name_of(path), crs.name()));
                (grid_of_bounds(path, bounds, source.info().size)?, crs)
            }
            (None, None) => return Err(not_georeferenced(path, "--dom")),
        };
        placed.push(checked(source, grid, crs, notes)?);
    }
    Ok(placed)
}

/// The rectangle a raster covers in another CRS: the box around its border, which is followed in
/// steps since straight lines do not stay straight.
pub fn extent_in(raster: &PlacedRaster, crs: &CoordinateSystem) -> Option<Extent> {
    const STEPS: u32 = 64;
    let transform = CoordinateTransform::new(&raster.crs, crs);
    let (mut min, mut max) = raster.grid.bounds(raster.source.info().size);
    if raster.crs.is_geographic() && !transform.is_identity() {
        let [south, north] = crs.latitude_limits_deg();
        (min.y, max.y) = (min.y.clamp(south, north), max.y.clamp(south, north));
        // The map's own date line: what lies beyond comes round on the other side.
        let turn = crs.central_meridian_deg();
        let whole = max.x - min.x > 359.0;
        if whole {
            (min.x, max.x) = (turn - 180.0 + 1e-9, turn + 180.0 - 1e-9);
        }
    }
    // Inner lines too: the extreme of a curved edge may lie at the pole inside the raster.
    let mut found: Option<Extent> = None;
    for row in 0..=STEPS {
        for column in 0..=STEPS {
            let part = dvec2(f64::from(column), f64::from(row)) / f64::from(STEPS);
            let position = min + (max - min) * part;
            let Some(point) = transform.apply(position) else { continue };
            let point = Extent::new(point, point);
            found = Some(found.map_or(point, |extent| extent.union(&point)));
        }
    }
    found
}

fn crs_of(
    source: &dyn RasterSource,
    stated: Option<u32>,
    notes: &mut Vec<String>,
) -> Result<CoordinateSystem, PrepareError> {
    let epsg = match (source.info().epsg, stated) {
        (Some(epsg), _) => epsg,
        (None, Some(epsg)) => {
            let name = name_of(source.path());
            notes.push(format!("{name}: no CRS in the file, taken to be {}", epsg_name(epsg)));
            epsg
        }
        (None, None) => {
            let reason = "its CRS is not known; state it with --crs EPSG:n".to_owned();
            return Err(PrepareError::Misplaced { path: source.path().to_owned(), reason });
        }
    };
    CoordinateSystem::from_epsg(epsg).map_err(|error| match source.info().epsg {
        Some(_) => {
            PrepareError::Misplaced { path: source.path().to_owned(), reason: error.to_string() }
        }
        None => error.into(),
    })
}

fn bounds_crs(
    request: &PrepareRequest,
    bounds: [f64; 4],
) -> Result<CoordinateSystem, PrepareError> {
    let [west, south, east, north] = bounds;
    let in_degrees = west >= -360.0 && east <= 540.0 && south >= -90.0 && north <= 90.0;
    let epsg = match (request.colour_epsg, request.epsg) {
        (Some(epsg), _) => epsg,
        (None, _) if in_degrees => CoordinateSystem::WGS84,
        (None, Some(epsg)) => epsg,
        (None, None) => {
            let reason = "--dom-extent is not in degrees; state its CRS with --dom-crs EPSG:n";
            return Err(PrepareError::Request(reason.to_owned()));
        }
    };
    Ok(CoordinateSystem::from_epsg(epsg)?)
}

fn grid_of_bounds(
    path: &Path,
    [west, south, east, north]: [f64; 4],
    size: [u32; 2],
) -> Result<RasterGrid, PrepareError> {
    let extent = dvec2(east - west, north - south);
    if !(extent.is_finite() && extent.min_element() > 0.0) {
        let reason = "--dom-extent needs W,S,E,N with W < E and S < N".to_owned();
        return Err(PrepareError::Misplaced { path: path.to_owned(), reason });
    }
    let cell = extent / dvec2(f64::from(size[0]), f64::from(size[1]));
    Ok(RasterGrid { origin: DVec2::new(west, north), cell })
}

fn checked(
    source: Box<dyn RasterSource>,
    grid: RasterGrid,
    crs: CoordinateSystem,
    notes: &mut Vec<String>,
) -> Result<PlacedRaster, PrepareError> {
    if let Some(fault) = grid.fault(source.info().size, crs.is_geographic()) {
        let reason = format!("georeference cannot be used: {fault}");
        return Err(PrepareError::Misplaced { path: source.path().to_owned(), reason });
    }
    notes.extend(source.info().notes.iter().cloned());
    Ok(PlacedRaster { source: Arc::from(source), grid, crs })
}

fn not_georeferenced(path: &Path, option: &str) -> PrepareError {
    let reason = match option {
        "--dom" => {
            "the picture has no georeference; add a world file or say where it lies with \
             --dom-extent W,S,E,N"
        }
        _ => "the raster has no georeference; `gdal_translate -a_ullr` can add one",
    };
    PrepareError::Misplaced { path: PathBuf::from(path), reason: reason.to_owned() }
}

/// The name of a file, without its folder.
pub fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}
