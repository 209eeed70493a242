use std::sync::Arc;

use glam::dvec2;

use super::source::{RasterGrid, RasterSource, SourceError, Window};
use crate::geodesy::CoordinateSystem;

/// A raster whose place on Earth is known.
#[derive(Clone)]
pub struct PlacedRaster {
    /// The file.
    pub source: Arc<dyn RasterSource>,
    /// Where its cells lie.
    pub grid: RasterGrid,
    /// What its coordinates mean.
    pub crs: CoordinateSystem,
}

/// A rectangle of cells that may reach beyond the raster.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SignedWindow {
    /// First column.
    pub column: i64,
    /// First row.
    pub row: i64,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

/// Rasters that share one grid of cells, read as if they were one. Where they overlap, the first
/// one that holds data counts.
pub struct Mosaic {
    crs: CoordinateSystem,
    grid: RasterGrid,
    size: [u32; 2],
    members: Vec<Member>,
}

/// A part of a window that lies within the mosaic or beyond one of its sides.
struct Piece {
    /// Its cells.
    window: SignedWindow,
    /// Row and column of the window that the first of them goes to.
    at: [usize; 2],
    /// Whether rows come in the reverse order: they are seen over a pole.
    is_turned: bool,
}

struct Member {
    source: Arc<dyn RasterSource>,
    column: i64,
    row: i64,
}

/// Part of a cell by which rasters of one mosaic may be out of step.
const ALIGNMENT_TOLERANCE_CELLS: f64 = 0.01;

impl Mosaic {
    /// Groups rasters into as few mosaics as their grids allow, in their order.
    pub fn group(rasters: Vec<PlacedRaster>) -> Vec<Self> {
        let mut groups: Vec<Vec<PlacedRaster>> = Vec::new();
        for raster in rasters {
            match groups.iter_mut().find(|group| are_aligned(&group[0], &raster)) {
                Some(group) => group.push(raster),
                None => groups.push(vec![raster]),
            }
        }
        groups.into_iter().map(Self::of_aligned).collect()
    }

    fn of_aligned(rasters: Vec<PlacedRaster>) -> Self {
        let first = rasters[0].clone();
        let mut low = [0_i64; 2];
        let mut high = [0_i64; 2];
        let mut members = Vec::new();
        for raster in rasters {
            let corner = first.grid.columns_rows(raster.grid.origin).round();
            let corner = [corner.x as i64, corner.y as i64];
            let size = raster.source.info().size;
            for axis in 0..2 {
                low[axis] = low[axis].min(corner[axis]);
                high[axis] = high[axis].max(corner[axis] + i64::from(size[axis]));
            }
            members.push(Member { source: raster.source, column: corner[0], row: corner[1] });
        }
        for member in &mut members {
            member.column -= low[0];
            member.row -= low[1];
        }
        let shift = dvec2(low[0] as f64, low[1] as f64);
        let grid = RasterGrid { origin: first.grid.position(shift), cell: first.grid.cell };
        let size = [0, 1].map(|axis| (high[axis] - low[axis]).min(i64::from(u32::MAX)) as u32);
        Self { crs: first.crs, grid, size, members }
    }

    /// What the coordinates mean.
    pub fn crs(&self) -> &CoordinateSystem {
        &self.crs
    }

    /// Where the cells lie.
    pub fn grid(&self) -> &RasterGrid {
        &self.grid
    }

    /// Columns and rows.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Columns once round the Earth; `None` for a projected mosaic.
    pub fn columns_round(&self) -> Option<f64> {
        self.crs.is_geographic().then(|| 360.0 / self.grid.cell.x)
    }

    /// Whether the last column is followed by the first.
    pub fn wraps(&self) -> bool {
        self.columns_round().is_some_and(|round| (f64::from(self.size[0]) - round).abs() < 0.01)
    }

    /// Heights in metres; NaN where there is no data or no raster.
    pub fn read_heights(&self, window: SignedWindow) -> Result<Vec<f32>, SourceError> {
        self.read(
            window,
            f32::NAN,
            |height| height.is_nan(),
            |source, window| source.read_heights(window),
        )
    }

    /// sRGB and coverage; all zero where there is no picture.
    pub fn read_colours(&self, window: SignedWindow) -> Result<Vec<[u8; 4]>, SourceError> {
        self.read(
            window,
            [0; 4],
            |colour| colour[3] == 0,
            |source, window| source.read_colours(window),
        )
    }

    fn read<T: Copy>(
        &self,
        window: SignedWindow,
        empty: T,
        is_empty: impl Fn(&T) -> bool,
        read: impl Fn(&dyn RasterSource, Window) -> Result<Vec<T>, SourceError>,
    ) -> Result<Vec<T>, SourceError> {
        if let [member] = &self.members[..]
            && let Some((part, 0, 0)) = member.overlap(window)
            && (part.width as usize, part.height as usize) == (window.width, window.height)
        {
            return read(member.source.as_ref(), part);
        }
        let mut out = vec![empty; window.width * window.height];
        for Piece { window: cells, at: [first_row, first_column], is_turned } in self.pieces(window)
        {
            for member in &self.members {
                let Some((part, x, y)) = member.overlap(cells) else { continue };
                let values = read(member.source.as_ref(), part)?;
                for (row, line) in values.chunks_exact(part.width as usize).enumerate() {
                    let row = if is_turned { cells.height - 1 - (y + row) } else { y + row };
                    let at = (first_row + row) * window.width + first_column + x;
                    for (target, value) in out[at..at + line.len()].iter_mut().zip(line) {
                        if is_empty(target) {
                            *target = *value;
                        }
                    }
                }
            }
        }
        Ok(out)
    }

    /// The window cut where it passes the date line or a pole of a mosaic round the whole Earth.
    fn pieces(&self, window: SignedWindow) -> Vec<Piece> {
        if !self.wraps() {
            return vec![Piece { window, at: [0, 0], is_turned: false }];
        }
        let around = i64::from(self.size[0]);
        let mut pieces = Vec::new();
        for Piece { window: rows, at: [first_row, _], is_turned } in self.row_pieces(window) {
            let turn = if is_turned { around / 2 } else { 0 };
            let mut done = 0;
            while done < window.width {
                let column = (window.column + turn + done as i64).rem_euclid(around);
                let width = (window.width - done).min((around - column) as usize);
                let window = SignedWindow { column, width, ..rows };
                pieces.push(Piece { window, at: [first_row, done], is_turned });
                done += width;
            }
        }
        pieces
    }

    /// The window cut where it passes a pole; columns are left as they are. Over the pole lies the row as far from
    /// it on the other side.
    fn row_pieces(&self, window: SignedWindow) -> Vec<Piece> {
        let [north, south] = self.rows_over_poles();
        let height = i64::from(self.size[1]);
        let (first, end) = (window.row, window.row + window.height as i64);
        let mut pieces = Vec::new();
        let mut add = |from: i64, to: i64, over: Option<i64>| {
            if from >= to {
                return;
            }
            let row = over.map_or(from, |sum| sum - (to - 1));
            let window = SignedWindow { row, height: (to - from) as usize, ..window };
            let at = [(from - first) as usize, 0];
            pieces.push(Piece { window, at, is_turned: over.is_some() });
        };
        add(first, end.min(0), north);
        add(first.max(0), end.min(height), None);
        add(first.max(height), end, south);
        pieces
    }

    /// Of a mosaic round the whole Earth that reaches the north and the south pole: the sum of a row beyond the pole
    /// and of the row that lies there. Rows whose centres are on the pole itself are not repeated.
    fn rows_over_poles(&self) -> [Option<i64>; 2] {
        let height = f64::from(self.size[1]);
        let is_even = self.size[0].is_multiple_of(2);
        [(90.0, 0.0), (-90.0, 2.0 * height)].map(|(pole_deg, border)| {
            let sum = 2.0 * (self.grid.origin.y - pole_deg) / self.grid.cell.y;
            let reaches = (sum - border).abs() < 1.0 + ALIGNMENT_TOLERANCE_CELLS;
            let is_whole = (sum - sum.round()).abs() < ALIGNMENT_TOLERANCE_CELLS;
            (is_even && reaches && is_whole).then_some(sum.round() as i64 - 1)
        })
    }
}

impl Member {
    /// The part of the raster in the window, and where in the window it begins.
    fn overlap(&self, window: SignedWindow) -> Option<(Window, usize, usize)> {
        let axis = |first: i64, length: usize, corner: i64, size: u32| {
            let start = first.max(corner);
            let end = (first + length as i64).min(corner + i64::from(size));
            (start < end)
                .then(|| ((start - corner) as u32, (end - start) as u32, (start - first) as usize))
        };
        let size = self.source.info().size;
        let (column, width, x) = axis(window.column, window.width, self.column, size[0])?;
        let (row, height, y) = axis(window.row, window.height, self.row, size[1])?;
        Some((Window { column, row, width, height }, x, y))
    }
}

fn are_aligned(a: &PlacedRaster, b: &PlacedRaster) -> bool {
    let extent = a.source.info().size.into_iter().chain(b.source.info().size).max().unwrap_or(1);
    let stretch = ((a.grid.cell - b.grid.cell) / a.grid.cell).abs() * f64::from(extent);
    let offset = a.grid.columns_rows(b.grid.origin);
    a.crs == b.crs
        && stretch.max_element() < ALIGNMENT_TOLERANCE_CELLS
        && (offset - offset.round()).abs().max_element() < ALIGNMENT_TOLERANCE_CELLS
}
