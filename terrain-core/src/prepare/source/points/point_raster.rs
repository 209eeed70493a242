//! Points as a raster: natural neighbours at the centres of cells.

use std::path::{Path, PathBuf};

use glam::{DVec2, dvec2};
use rayon::prelude::*;

use super::super::chunk_cache::ChunkCache;
use super::super::{RasterContent, RasterGrid, RasterInfo, RasterSource, SourceError, Window};
use super::PointCloud;
use crate::surface::tin::{DistinctPoints, NaturalNeighbours, TinError};

/// Rows interpolated together.
const BAND_ROWS: u32 = 32;
/// Bytes of rows kept.
const CACHE_BYTES: usize = 160 << 20;
/// Most columns or rows.
const MOST_CELLS: f64 = 1.0e6;

/// Scattered points, read as heights of a raster: those of the natural neighbours of each cell's
/// centre; outside the points' convex hull there is no data.
///
/// The triangulation of all points is in memory, the raster is not: rows are interpolated as windows
/// ask for them, on all threads.
pub struct PointRaster {
    path: PathBuf,
    info: RasterInfo,
    grid: RasterGrid,
    ground: NaturalNeighbours,
    bands: ChunkCache<Vec<f32>>,
}

impl PointRaster {
    /// The surface through points that share a CRS in metres, the files' in this order. `spacing_m`
    /// is the side of a cell; by default as many cells as points would cover the hull.
    ///
    /// # Errors
    /// Where the points make no surface, or the spacing makes none or too many cells.
    pub fn new(
        clouds: Vec<PointCloud>,
        epsg: u32,
        spacing_m: Option<f64>,
    ) -> Result<Self, SourceError> {
        let path = clouds.first().map(|cloud| cloud.path.clone()).unwrap_or_default();
        let more = clouds.len().saturating_sub(1);
        let refused = |error: TinError| match more {
            0 => SourceError::no_points(&path, &error.to_string()),
            _ => SourceError::no_points(&path, &format!("with {more} more: {error}")),
        };
        let mut notes: Vec<String> = clouds.iter().map(|cloud| cloud.note.clone()).collect();
        let points = clouds.into_iter().flat_map(|cloud| cloud.points).collect();
        let points = DistinctPoints::new(points).map_err(refused)?;
        let ground = NaturalNeighbours::new(&points).map_err(refused)?;
        let count = points.points().len() as f64;
        let spacing_m =
            spacing_m.unwrap_or_else(|| three_digits((ground.hull_area() / count).sqrt()));
        let (grid, size) = grid_over(&points, spacing_m)
            .map_err(|reason| SourceError::no_points(&path, &reason))?;
        if points.merged > 0 {
            notes.push(format!(
                "{} points at places of others left out, the median height kept",
                points.merged
            ));
        }
        notes.push(format!(
            "heights of {count} points' natural neighbours in cells of {spacing_m} m; none outside \
             the points' hull"
        ));
        let info = RasterInfo {
            grid: Some(grid),
            size,
            epsg: Some(epsg),
            content: RasterContent::Measurements,
            height_step_m: 0.0,
            notes,
        };
        Ok(Self { path, info, grid, ground, bands: ChunkCache::new(CACHE_BYTES) })
    }

    /// Some whole rows.
    fn interpolate(&self, band: u32) -> (Vec<f32>, usize) {
        let [width, height] = self.info.size;
        let rows = band * BAND_ROWS..((band + 1) * BAND_ROWS).min(height);
        let heights: Vec<f32> = rows
            .into_par_iter()
            .map_init(
                || self.ground.sampler(),
                |sampler, row| {
                    let at = |column| dvec2(f64::from(column) + 0.5, f64::from(row) + 0.5);
                    let heights = (0..width).map(|column| {
                        let position = self.grid.position(at(column));
                        sampler.height_m(position.x, position.y).map_or(f32::NAN, |m| m as f32)
                    });
                    heights.collect::<Vec<f32>>()
                },
            )
            .flatten_iter()
            .collect();
        let bytes = 4 * heights.len();
        (heights, bytes)
    }
}

impl RasterSource for PointRaster {
    fn path(&self) -> &Path {
        &self.path
    }

    fn info(&self) -> &RasterInfo {
        &self.info
    }

    fn read_heights(&self, window: Window) -> Result<Vec<f32>, SourceError> {
        let width = self.info.size[0] as usize;
        let columns = window.column as usize..(window.column + window.width) as usize;
        let mut out = Vec::with_capacity(window.len());
        for row in window.row..window.row + window.height {
            let (band, within) = (row / BAND_ROWS, (row % BAND_ROWS) as usize);
            let rows = self.bands.get(band, || Ok::<_, SourceError>(self.interpolate(band)))?;
            out.extend_from_slice(&rows[within * width..][columns.clone()]);
        }
        Ok(out)
    }

    fn read_colours(&self, _window: Window) -> Result<Vec<[u8; 4]>, SourceError> {
        Err(SourceError::unsupported(&self.path, "points are heights, not a picture"))
    }
}

/// The cells that hold all points, their borders at whole multiples of the spacing.
fn grid_over(points: &DistinctPoints, spacing_m: f64) -> Result<(RasterGrid, [u32; 2]), String> {
    if !(spacing_m.is_finite() && spacing_m > 0.0) {
        return Err(format!("cells of {spacing_m} m cannot be; state others with --point-spacing"));
    }
    let (mut min, mut max) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for [x, y, _] in points.points() {
        min = min.min(dvec2(*x, *y));
        max = max.max(dvec2(*x, *y));
    }
    let first = (min / spacing_m).floor();
    let end = (max / spacing_m).ceil().max(first + DVec2::ONE);
    let cells = end - first;
    if !(cells.is_finite() && cells.max_element() <= MOST_CELLS) {
        return Err(format!(
            "{} x {} cells of {spacing_m} m are too many; state larger ones with --point-spacing, or \
             the points' CRS with --crs",
            cells.x, cells.y
        ));
    }
    let origin = dvec2(first.x, end.y) * spacing_m;
    let grid = RasterGrid { origin, cell: DVec2::splat(spacing_m) };
    Ok((grid, [cells.x as u32, cells.y as u32]))
}

/// Three significant digits.
fn three_digits(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cloud(points: Vec<[f64; 3]>) -> PointCloud {
        PointCloud {
            path: "points.xyz".into(),
            points,
            epsg: None,
            note: "all".to_owned(),
            is_own_choice: false,
        }
    }

    fn plane(x: f64, y: f64) -> f64 {
        100.0 + 0.5 * x - 0.25 * y
    }

    /// A plane sampled without any order.
    fn points() -> Vec<[f64; 3]> {
        (0..500_u32)
            .map(|index| {
                let (x, y) = (f64::from(index * 37 % 101), f64::from(index * 53 % 97));
                [x, y, plane(x, y)]
            })
            .collect()
    }

    #[test]
    fn cells_take_the_heights_of_their_centres() {
        let (west, east): (Vec<_>, Vec<_>) =
            points().into_iter().partition(|point| point[0] < 40.0);
        let raster = PointRaster::new(vec![cloud(west), cloud(east)], 32632, Some(3.0)).unwrap();
        let grid = raster.info().grid.unwrap();
        assert_eq!((grid.origin, raster.info().size), (dvec2(0.0, 96.0), [34, 32]));
        let window = Window { column: 3, row: 2, width: 29, height: 28 };
        let heights = raster.read_heights(window).unwrap();
        let mut held = 0;
        for (index, height_m) in heights.iter().enumerate() {
            let place = dvec2((index % 29 + 3) as f64 + 0.5, (index / 29 + 2) as f64 + 0.5);
            let position = grid.position(place);
            if !height_m.is_nan() {
                assert!((f64::from(*height_m) - plane(position.x, position.y)).abs() < 1e-3);
                held += 1;
            }
        }
        assert!(held > 28 * 27, "{held} cells within the hull");
        let whole = Window { column: 0, row: 0, width: 34, height: 32 };
        let cell = raster.read_heights(whole).unwrap()[2 * 34 + 3];
        assert_eq!(cell.to_bits(), heights[0].to_bits());
    }

    #[test]
    fn the_spacing_follows_the_density_and_must_be_possible() {
        let raster = PointRaster::new(vec![cloud(points())], 32632, None).unwrap();
        let cell_m = raster.info().grid.unwrap().cell.x;
        // 500 points on 100 m by 96 m, the corners of the hull cut a little.
        assert!((4.0..4.4).contains(&cell_m), "{cell_m}");
        for spacing_m in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-9] {
            let refused = PointRaster::new(vec![cloud(points())], 32632, Some(spacing_m));
            assert!(refused.is_err(), "{spacing_m}");
        }
        let line = (0..9).map(|index| [f64::from(index), 0.0, 1.0]).collect();
        let error = PointRaster::new(vec![cloud(line)], 32632, None).err().unwrap().to_string();
        assert!(error.contains("points.xyz") && error.contains("one line"), "{error}");
    }
}
