use std::f64::consts::TAU;

use glam::DVec3;

use crate::dataset::Shape;

/// Texels of a level that need not be within it: rows from the north, columns from the west.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TexelWindow {
    /// First column; below 0 beyond the west.
    pub column: i64,
    /// First row; below 0 beyond the north.
    pub row: i64,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

impl TexelWindow {
    /// The window of the next coarser level that this one is computed from: the texels over it, and `margin` more on
    /// every side.
    pub fn coarser(self, margin: i64) -> Self {
        let along = |first: i64, length: usize| {
            let coarse = first.div_euclid(2) - margin;
            let end = (first + length as i64 + 1).div_euclid(2) + margin;
            (coarse, (end - coarse) as usize)
        };
        let (column, width) = along(self.column, self.width);
        let (row, height) = along(self.row, self.height);
        Self { column, row, width, height }
    }

    /// The window with so many texels more on every side.
    pub fn grown(self, margin: usize) -> Self {
        Self {
            column: self.column - margin as i64,
            row: self.row - margin as i64,
            width: self.width + 2 * margin,
            height: self.height + 2 * margin,
        }
    }

    /// Number of texels.
    pub fn len(self) -> usize {
        self.width * self.height
    }
}

/// All texels of a level of imagery, and where they lie.
#[derive(Clone, Copy, Debug)]
pub struct TexelGrid {
    /// What the imagery lies on.
    pub shape: Shape,
    /// Texels along the root at this level.
    pub side: i64,
}

impl TexelGrid {
    /// The texels of the level so many finer.
    pub fn finer(self, levels: u8) -> Self {
        Self { side: self.side << levels, ..self }
    }

    /// The column and row that stand for these: on a globe the same place, round it and over its poles, on a plane the
    /// nearest place within the root.
    pub fn own(&self, column: i64, row: i64) -> (i64, i64) {
        let (width, height) = (self.side, self.side / 2);
        match self.shape {
            Shape::Plane => (column.clamp(0, self.side - 1), row.clamp(0, self.side - 1)),
            Shape::Globe => match row {
                _ if row < 0 => ((column + width / 2).rem_euclid(width), -1 - row),
                _ if row >= height => {
                    ((column + width / 2).rem_euclid(width), 2 * height - 1 - row)
                }
                _ => (column.rem_euclid(width), row),
            },
        }
    }

    /// Where the centres of a window's texels lie in space, in texels along the equator (on a plane, along its
    /// sides): positions without a seam or a pole, for noise to be taken at.
    pub fn positions(&self, window: TexelWindow) -> TexelPositions {
        let angle = |index: i64| (index as f64 + 0.5) / self.side as f64 * TAU;
        let columns = (0..window.width as i64).map(|x| window.column + x);
        let columns = match self.shape {
            Shape::Plane => columns.map(|column| [column as f64 + 0.5, 0.0]).collect(),
            Shape::Globe => {
                // Texels over a pole are half a turn away.
                let turns = [0, self.side / 2].map(|turn| {
                    columns.clone().map(move |column| angle((column + turn).rem_euclid(self.side)))
                });
                turns.into_iter().flatten().map(|angle| [angle.cos(), angle.sin()]).collect()
            }
        };
        TexelPositions { grid: *self, window, columns }
    }
}

/// Positions of a window's texels; see [`TexelGrid::positions`].
pub struct TexelPositions {
    grid: TexelGrid,
    window: TexelWindow,
    /// On a plane x of each column, and nothing; on a globe cosine and sine of each column's longitude, then those of
    /// the places half a turn from them.
    columns: Vec<[f64; 2]>,
}

impl TexelPositions {
    /// The positions of the texels of a row of the window, counted from its first.
    pub fn row(&self, row: usize) -> impl Iterator<Item = DVec3> + '_ {
        let TexelGrid { shape, side } = self.grid;
        let row = self.window.row + row as i64;
        let (_, own_row) = self.grid.own(0, row);
        let is_over_pole = shape == Shape::Globe && !(0..side / 2).contains(&row);
        let first = if is_over_pole { self.window.width } else { 0 };
        let (scale, height) = match shape {
            Shape::Plane => (1.0, row as f64 + 0.5),
            Shape::Globe => {
                let radius = side as f64 / TAU;
                let from_pole = (own_row as f64 + 0.5) / side as f64 * TAU;
                (radius * from_pole.sin(), radius * from_pole.cos())
            }
        };
        let columns = self.columns[first..first + self.window.width].iter();
        columns.map(move |&[x, y]| DVec3::new(scale * x, scale * y, height))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_beyond_a_globe_s_edges_are_the_same_places_to_the_bit() {
        let grid = TexelGrid { shape: Shape::Globe, side: 64 };
        assert_eq!(grid.own(-3, 5), (61, 5));
        assert_eq!(grid.own(3, -1), (35, 0));
        assert_eq!(grid.own(40, 33), (8, 30));
        let whole = TexelWindow { column: 0, row: 0, width: 64, height: 32 };
        let own = grid.positions(whole);
        let beyond = grid.positions(whole.grown(6));
        for row in 0..44 {
            for (column, position) in beyond.row(row).enumerate() {
                let (x, y) = grid.own(column as i64 - 6, row as i64 - 6);
                assert_eq!(Some(position), own.row(y as usize).nth(x as usize));
            }
        }
        // Neighbours are a texel apart at the equator.
        let mut equator = own.row(15);
        let step = equator.next().unwrap().distance(equator.next().unwrap());
        assert!((step - 1.0).abs() < 0.01, "{step}");
    }

    #[test]
    fn a_coarser_window_holds_what_lies_under_the_finer_one() {
        let window = TexelWindow { column: -4, row: 5, width: 24, height: 7 };
        let coarser = window.coarser(2);
        assert_eq!(coarser, TexelWindow { column: -4, row: 0, width: 16, height: 8 });
    }
}
