//! Where points lie, and how they become a raster.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use glam::{DVec2, dvec2};
use rayon::prelude::*;

use super::mosaic::PlacedRaster;
use super::placement::name_of;
use super::plan::is_in_metres;
use super::run::Run;
use super::source::{PointCloud, PointRaster, RasterSource, read_points};
use super::{PrepareError, PrepareRequest};
use crate::geodesy::{CoordinateSystem, CoordinateTransform, epsg_name, utm_epsg};

/// Reads all point files into one raster, so that there are no gaps between them.
///
/// Points are brought into the dataset's CRS before they are triangulated: neighbours are to be near
/// in metres, and what is interpolated once need not be resampled. Without a stated CRS that is the
/// first file's own where it is in metres, else the UTM zone it lies in.
pub fn place_points(
    request: &PrepareRequest,
    paths: &[PathBuf],
    notes: &mut Vec<String>,
    run: &Run<'_>,
) -> Result<PlacedRaster, PrepareError> {
    let mut target = request.epsg.map(CoordinateSystem::from_epsg).transpose()?;
    let mut clouds = Vec::new();
    for (index, path) in paths.iter().enumerate() {
        if run.cancel.load(Ordering::Relaxed) {
            return Err(PrepareError::Cancelled);
        }
        let mut cloud = read_points(path, &request.points.classes)?;
        if cloud.is_own_choice {
            run.progress.note(&cloud.note);
        }
        let own = crs_of(&cloud, request, notes)?;
        let target = match &mut target {
            Some(target) => target,
            None => target.insert(dataset_crs(&cloud, &own)?),
        };
        transform(&mut cloud, &own, target)?;
        clouds.push(cloud);
        run.progress.advanced("points", index as u64 + 1, paths.len() as u64);
    }
    let Some(crs) = target else {
        return Err(PrepareError::Request("no file of points is given".to_owned()));
    };
    let raster = PointRaster::new(clouds, crs.epsg(), request.points.spacing_m)?;
    let misplaced = || PrepareError::Misplaced {
        path: raster.path().to_owned(),
        reason: "its points have no place".to_owned(),
    };
    let grid = raster.info().grid.ok_or_else(misplaced)?;
    if let Some(fault) = grid.fault(raster.info().size, crs.is_geographic()) {
        let reason = format!("its points cannot be placed: {fault}; is their CRS right?");
        return Err(PrepareError::Misplaced { path: raster.path().to_owned(), reason });
    }
    notes.extend(raster.info().notes.iter().cloned());
    Ok(PlacedRaster { source: Arc::new(raster), grid, crs })
}

fn crs_of(
    cloud: &PointCloud,
    request: &PrepareRequest,
    notes: &mut Vec<String>,
) -> Result<CoordinateSystem, PrepareError> {
    let misplaced = |reason: String| PrepareError::Misplaced { path: cloud.path.clone(), reason };
    if let Some(epsg) = cloud.epsg {
        return CoordinateSystem::from_epsg(epsg).map_err(|error| misplaced(error.to_string()));
    }
    let stated = request.points.epsg.or(request.epsg).ok_or_else(|| {
        misplaced("the points' CRS is not known; state it with --point-crs EPSG:n".to_owned())
    })?;
    let name = name_of(&cloud.path);
    notes.push(format!("{name}: no CRS in the file, taken to be {}", epsg_name(stated)));
    Ok(CoordinateSystem::from_epsg(stated)?)
}

fn dataset_crs(
    cloud: &PointCloud,
    own: &CoordinateSystem,
) -> Result<CoordinateSystem, PrepareError> {
    if is_in_metres(own) {
        return Ok(own.clone());
    }
    let wgs84 = CoordinateSystem::from_epsg(CoordinateSystem::WGS84)?;
    let to_wgs84 = CoordinateTransform::new(own, &wgs84);
    let sum: DVec2 = cloud.points.iter().map(|point| dvec2(point[0], point[1])).sum();
    let centre = to_wgs84.apply(sum / cloud.points.len() as f64).ok_or_else(|| {
        let reason = "its place on Earth cannot be computed; is its CRS right?".to_owned();
        PrepareError::Misplaced { path: cloud.path.clone(), reason }
    })?;
    Ok(CoordinateSystem::from_epsg(utm_epsg(centre))?)
}

fn transform(
    cloud: &mut PointCloud,
    from: &CoordinateSystem,
    to: &CoordinateSystem,
) -> Result<(), PrepareError> {
    if from == to {
        return Ok(());
    }
    let transform = CoordinateTransform::new(from, to);
    let path = &cloud.path;
    cloud.points.par_iter_mut().try_for_each(|point| {
        let position = transform.apply(dvec2(point[0], point[1])).ok_or_else(|| {
            let reason = format!(
                "the point {}, {} lies where {} cannot show it; is the points' CRS right?",
                point[0],
                point[1],
                to.name()
            );
            PrepareError::Misplaced { path: path.clone(), reason }
        })?;
        [point[0], point[1]] = position.to_array();
        Ok(())
    })
}
