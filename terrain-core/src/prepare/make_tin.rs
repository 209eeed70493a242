//! From a raster or points to a TIN.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use glam::{DVec2, dvec2};

use super::PrepareError;
use super::placement::name_of;
use super::source::{
    RasterContent, RasterGrid, RasterSource, SourceError, Window, is_point_file, open_raster,
    read_breaklines, read_points,
};
use crate::geodesy::CoordinateSystem;
use crate::progress::Progress;
use crate::surface::tin::{
    Breakline, DistinctPoints, GlbPlace, SampleGrid, Tin, TinError, tin_of_grid, tin_of_points,
    tin_of_points_within,
};
use crate::tiling::Extent;

/// What to make a TIN of, and how.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TinRequest {
    /// One raster, or files of points in one CRS.
    pub ground: Vec<PathBuf>,
    /// Largest distance in metres of any sample above or below the triangles. A raster needs one; of
    /// points all are joined where there is none.
    pub max_error_m: Option<f64>,
    /// A GeoJSON file of lines that triangles must not cross.
    pub breaklines: Option<PathBuf>,
    /// EPSG code of ground that does not say its own.
    pub epsg: Option<u32>,
    /// LAS classes to take; empty takes ground alone if any point is said to be ground, else all.
    pub point_classes: Vec<u8>,
}

/// A TIN with its place.
#[derive(Clone, Debug)]
pub struct MadeTin {
    /// The TIN, in the ground's CRS.
    pub tin: Tin,
    /// Where it lies.
    pub place: GlbPlace,
    /// Samples that hold data, or points of different x, y.
    pub samples: usize,
    /// Largest distance in metres of any of them above or below the triangles, measured.
    pub largest_error_m: f64,
    /// What a user should know.
    pub notes: Vec<String>,
}

/// Makes a TIN of a raster or of points.
///
/// # Errors
/// Where a file cannot be read or makes no surface, or once `cancel` is set.
pub fn make_tin(
    request: &TinRequest,
    progress: &dyn Progress,
    cancel: &AtomicBool,
) -> Result<MadeTin, PrepareError> {
    let watch = Watch { progress, cancel };
    match &request.ground[..] {
        [] => Err(PrepareError::Request("no raster or file of points is given".to_owned())),
        paths if paths.iter().all(|path| is_point_file(path)) => of_points(request, paths, &watch),
        [path] => of_raster(request, path, &watch),
        _ => Err(PrepareError::Request(
            "one raster or files of points make a TIN; `gdal_merge.py` can join rasters".to_owned(),
        )),
    }
}

/// Whom to tell, and whether to stop.
struct Watch<'a> {
    progress: &'a dyn Progress,
    cancel: &'a AtomicBool,
}

impl Watch<'_> {
    /// Tells of a refinement by how far its error has come down, in powers.
    fn refinement(&self, max_error_m: f64) -> impl FnMut(f64, usize) -> bool {
        const STEPS: f64 = 1000.0;
        let mut first_m = None;
        move |error_m, _| {
            let first_m = *first_m.get_or_insert(error_m);
            let whole = (first_m / max_error_m.max(1e-3)).ln().max(f64::MIN_POSITIVE);
            let part = ((first_m / error_m).ln() / whole).clamp(0.0, 1.0);
            self.progress.advanced("triangles", (STEPS * part) as u64, STEPS as u64);
            !self.cancel.load(Ordering::Relaxed)
        }
    }
}

fn of_raster(
    request: &TinRequest,
    path: &Path,
    watch: &Watch<'_>,
) -> Result<MadeTin, PrepareError> {
    let max_error_m = request.max_error_m.ok_or_else(|| {
        PrepareError::Request(
            "a raster needs a largest error; state it with --max-error".to_owned(),
        )
    })?;
    let source = open_raster(path)?;
    if source.info().content == RasterContent::Picture {
        let reason = "a picture, not heights".to_owned();
        return Err(PrepareError::Misplaced { path: path.to_owned(), reason });
    }
    let raster = source.info().grid.ok_or_else(|| PrepareError::Misplaced {
        path: path.to_owned(),
        reason: "the raster has no georeference; `gdal_translate -a_ullr` can add one".to_owned(),
    })?;
    let crs = crs_of(path, source.info().epsg, request)?;
    let [columns, rows] = source.info().size;
    let heights_m = read_whole(source.as_ref(), watch)?;
    let grid = SampleGrid {
        columns: columns as usize,
        rows: rows as usize,
        heights_m: &heights_m,
        first: raster.position(dvec2(0.5, 0.5)),
        step: raster.cell,
    };
    let lines = breaklines(request, crs.as_ref())?;
    let tin = tin_of_grid(&grid, max_error_m, &lines, &mut watch.refinement(max_error_m))
        .map_err(|error| refused(path, request, error))?;
    let largest_error_m = grid.largest_error_m(&tin);
    let samples = heights_m.iter().filter(|height_m| !height_m.is_nan()).count();
    let place = place_of(crs.as_ref(), extent_of(&raster, source.info().size));
    Ok(MadeTin { tin, place, samples, largest_error_m, notes: source.info().notes.clone() })
}

/// All heights, some rows at a time.
fn read_whole(source: &dyn RasterSource, watch: &Watch<'_>) -> Result<Vec<f32>, PrepareError> {
    const BAND_ROWS: u32 = 256;
    let [width, height] = source.info().size;
    let mut heights_m = Vec::new();
    for row in (0..height).step_by(BAND_ROWS as usize) {
        if watch.cancel.load(Ordering::Relaxed) {
            return Err(PrepareError::Cancelled);
        }
        let window = Window { column: 0, row, width, height: BAND_ROWS.min(height - row) };
        heights_m.extend(source.read_heights(window)?);
        watch.progress.advanced("heights", u64::from(row), u64::from(height));
    }
    Ok(heights_m)
}

fn of_points(
    request: &TinRequest,
    paths: &[PathBuf],
    watch: &Watch<'_>,
) -> Result<MadeTin, PrepareError> {
    let mut all = Vec::new();
    let mut notes = Vec::new();
    let mut crs: Option<CoordinateSystem> = None;
    for (index, path) in paths.iter().enumerate() {
        let cloud = read_points(path, &request.point_classes)?;
        if cloud.is_own_choice {
            watch.progress.note(&cloud.note);
        }
        notes.push(cloud.note);
        let own = crs_of(path, cloud.epsg, request)?;
        if index > 0 && own != crs {
            let reason = format!("its CRS is not that of {}", name_of(&paths[0]));
            return Err(PrepareError::Misplaced { path: path.clone(), reason });
        }
        crs = own;
        all.extend(cloud.points);
        watch.progress.advanced("points", index as u64 + 1, paths.len() as u64);
    }
    let lines = breaklines(request, crs.as_ref())?;
    let refused = |error| refused(&paths[0], request, error);
    let points = DistinctPoints::new(all).map_err(refused)?;
    if points.merged > 0 {
        let merged = points.merged;
        notes.push(format!("{merged} points at places of others left out, the median height kept"));
    }
    let (tin, largest_error_m) = match request.max_error_m {
        None => (tin_of_points(&points, &lines).map_err(refused)?, 0.0),
        Some(max_error_m) => {
            let mut keep_going = watch.refinement(max_error_m);
            tin_of_points_within(&points, max_error_m, &lines, &mut keep_going).map_err(refused)?
        }
    };
    let [min, max] = tin.bounds().map(|corner| dvec2(corner[0], corner[1]));
    let place = place_of(crs.as_ref(), Extent::new(min, max));
    let samples = points.points().len();
    Ok(MadeTin { tin, place, samples, largest_error_m, notes })
}

/// The file's own CRS, else the stated one, else none: a TIN can do without.
fn crs_of(
    path: &Path,
    own: Option<u32>,
    request: &TinRequest,
) -> Result<Option<CoordinateSystem>, PrepareError> {
    let Some(epsg) = own.or(request.epsg) else { return Ok(None) };
    CoordinateSystem::from_epsg(epsg).map(Some).map_err(|error| PrepareError::Misplaced {
        path: path.to_owned(),
        reason: error.to_string(),
    })
}

fn breaklines(
    request: &TinRequest,
    crs: Option<&CoordinateSystem>,
) -> Result<Vec<Breakline>, SourceError> {
    request.breaklines.as_ref().map_or(Ok(Vec::new()), |path| read_breaklines(path, crs))
}

/// The error with the file that is to blame.
fn refused(path: &Path, request: &TinRequest, error: TinError) -> PrepareError {
    let lines = request.breaklines.as_deref().unwrap_or(path);
    let path = match error {
        TinError::Cancelled => return PrepareError::Cancelled,
        TinError::MaxError(_) => return PrepareError::Request(error.to_string()),
        TinError::BreaklinesElsewhere | TinError::BreaklineWithoutHeight { .. } => lines,
        _ => path,
    };
    PrepareError::Misplaced { path: path.to_owned(), reason: error.to_string() }
}

fn extent_of(raster: &RasterGrid, size: [u32; 2]) -> Extent {
    let (min, max) = raster.bounds(size);
    Extent::new(min, max)
}

fn place_of(crs: Option<&CoordinateSystem>, extent: Extent) -> GlbPlace {
    let metres_per_unit = match crs {
        Some(crs) if crs.is_geographic() => metres_per_degree(extent.centre().y),
        Some(crs) => DVec2::splat(crs.metres_per_unit()),
        None => DVec2::ONE,
    };
    GlbPlace { crs: crs.map(|crs| format!("EPSG:{}", crs.epsg())), metres_per_unit, extent }
}

/// Metres in a degree of longitude and of latitude on WGS 84, from its radii of curvature.
fn metres_per_degree(latitude_deg: f64) -> DVec2 {
    const EQUATOR_M: f64 = 6_378_137.0;
    const ECCENTRICITY_SQUARED: f64 = 0.006_694_379_990_141;
    let (sin, cos) = latitude_deg.clamp(-90.0, 90.0).to_radians().sin_cos();
    let flattened = 1.0 - ECCENTRICITY_SQUARED * sin * sin;
    let across_m = EQUATOR_M / flattened.sqrt();
    let along_m = EQUATOR_M * (1.0 - ECCENTRICITY_SQUARED) / flattened.powf(1.5);
    dvec2((across_m * cos).max(1e-3), along_m).map(f64::to_radians)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_degree_has_its_known_length() {
        // National Geospatial-Intelligence Agency, "Length of a Degree of Latitude and Longitude".
        for (latitude_deg, east_m, north_m) in
            [(0.0, 111_319.5, 110_574.3), (45.0, 78_846.8, 111_131.8), (60.0, 55_800.0, 111_412.2)]
        {
            let got = metres_per_degree(latitude_deg);
            assert!((got - dvec2(east_m, north_m)).abs().max_element() < 0.5, "{got}");
        }
    }
}
