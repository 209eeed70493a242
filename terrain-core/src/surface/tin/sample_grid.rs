use glam::{DVec2, DVec3, dvec2};
use rayon::prelude::*;

use super::triangle_scan::{plane_slope, visit_rows};
use super::{Tin, TinError};

/// Heights on a north-up grid, each standing for a point.
#[derive(Clone, Copy, Debug)]
pub struct SampleGrid<'a> {
    /// Samples from west to east.
    pub columns: usize,
    /// Samples from north to south.
    pub rows: usize,
    /// Heights in metres, north row first, west first; NaN where there is none.
    pub heights_m: &'a [f32],
    /// Where the north-western sample lies, in the dataset's CRS.
    pub first: DVec2,
    /// Distance between samples, eastwards and southwards, both positive.
    pub step: DVec2,
}

/// Most samples of a grid: all counts fit 32 bits.
const MOST_SAMPLES: usize = 1 << 30;
/// A place this near to a cell, in cells, counts as its border: where lines cross it is rounded.
const BORDER_SLACK: f64 = 1e-9;

impl SampleGrid<'_> {
    /// The largest distance in metres of a sample above or below the triangles over it; 0 for those
    /// that none covers.
    pub fn largest_error_m(&self, tin: &Tin) -> f64 {
        let errors = tin.triangles.par_iter().map(|triangle| {
            let corners = triangle.map(|index| DVec3::from(tin.vertices[index as usize]));
            let places = corners.map(|corner| self.place(corner.truncate()));
            let heights_m = corners.map(|corner| corner.z);
            let mut largest_m = 0.0_f64;
            let Some(slope) = plane_slope(places, heights_m) else { return largest_m };
            visit_rows(places, [self.columns, self.rows], |row, start, end| {
                for column in start..end {
                    let from = dvec2(column as f64, row as f64) - places[0];
                    let plane_m = heights_m[0] + slope.dot(from);
                    // max leaves NaN out.
                    largest_m = largest_m.max((plane_m - self.height_m(column, row)).abs());
                }
            });
            largest_m
        });
        errors.reduce(|| 0.0, f64::max)
    }

    /// Why there can be no surface, if so.
    pub(super) fn check(&self) -> Result<(), TinError> {
        let (columns, rows) = (self.columns, self.rows);
        match columns.checked_mul(rows) {
            _ if columns < 2 || rows < 2 => Err(TinError::TooFewSamples { columns, rows }),
            Some(count) if count > MOST_SAMPLES => Err(TinError::TooManySamples { columns, rows }),
            Some(count) if count == self.heights_m.len() => Ok(()),
            _ => Err(TinError::NoData),
        }
    }

    /// The position of a place given in samples from the first, eastwards and southwards.
    pub fn position(&self, place: DVec2) -> DVec2 {
        dvec2(self.first.x + place.x * self.step.x, self.first.y - place.y * self.step.y)
    }

    /// Samples from the first, eastwards and southwards, of a position.
    pub fn place(&self, position: DVec2) -> DVec2 {
        dvec2(position.x - self.first.x, self.first.y - position.y) / self.step
    }

    /// The sample's height in metres, NaN where there is none.
    pub(super) fn height_m(&self, column: usize, row: usize) -> f64 {
        f64::from(self.heights_m[row * self.columns + column])
    }

    /// Whether all four samples of the cell east and south of a sample hold data.
    pub(super) fn is_cell_held(&self, column: i64, row: i64) -> bool {
        let (Ok(column), Ok(row)) = (usize::try_from(column), usize::try_from(row)) else {
            return false;
        };
        let held = |column, row| !self.height_m(column, row).is_nan();
        column + 1 < self.columns
            && row + 1 < self.rows
            && held(column, row)
            && held(column + 1, row)
            && held(column, row + 1)
            && held(column + 1, row + 1)
    }

    /// The height in metres between four samples, bilinear; `None` outside all cells that hold data.
    pub(super) fn bilinear_m(&self, place: DVec2) -> Option<f64> {
        let near = |coordinate: f64| {
            [coordinate + BORDER_SLACK, coordinate - BORDER_SLACK].map(|near| near.floor() as i64)
        };
        let [east, west] = near(place.x);
        let [south, north] = near(place.y);
        let cells = [(east, south), (west, south), (east, north), (west, north)];
        let (column, row) = cells.into_iter().find(|cell| self.is_cell_held(cell.0, cell.1))?;
        let part = (place - dvec2(column as f64, row as f64)).clamp(DVec2::ZERO, DVec2::ONE);
        let (column, row) = (column as usize, row as usize);
        let mix = |a: f64, b: f64, part: f64| a * (1.0 - part) + b * part;
        let along = |row| mix(self.height_m(column, row), self.height_m(column + 1, row), part.x);
        Some(mix(along(row), along(row + 1), part.y))
    }
}
