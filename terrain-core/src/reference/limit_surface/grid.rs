use glam::{DVec2, DVec3, dvec2};
use serde::Serialize;

use super::LimitSurfaceError;
use crate::tiling::Extent;

/// Where the triangles of a limit-triangulated surface lie: a grid of square cells, two triangles
/// each.
///
/// Rows run south from the north-western corner and columns east, as in rasters. A cell's diagonal
/// runs from its north-western to its south-eastern node. Triangle `2 * (row * columns + column)` is
/// the north-eastern half of a cell, the one after it the south-western.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LimitGrid {
    /// North-western corner, metres of the CRS.
    pub origin: DVec2,
    /// Side of a cell, metres.
    pub cell_m: f64,
    /// Cells from west to east.
    pub columns: u32,
    /// Cells from north to south.
    pub rows: u32,
}

impl LimitGrid {
    /// Most triangles of a surface: their knots are found by 31-bit offsets.
    pub const MOST_TRIANGLES: u64 = 1 << 28;

    /// Side of the cells of which a triangle, lying flat, just spans the admissible angle from the
    /// least distance: its longest side, the diagonal, is the width of the cone's footprint there.
    ///
    /// On a slope a triangle is longer by `sqrt(1 + slope^2)` and, seen from above, no larger.
    pub fn cell_m_for(least_distance_m: f64, admissible_angle_rad: f64) -> f64 {
        2.0 * least_distance_m * (0.5 * admissible_angle_rad).tan() / std::f64::consts::SQRT_2
    }

    /// The least distance for cells of this side: the inverse of [`Self::cell_m_for`].
    pub fn least_distance_m_for(cell_m: f64, admissible_angle_rad: f64) -> f64 {
        cell_m * std::f64::consts::SQRT_2 / (2.0 * (0.5 * admissible_angle_rad).tan())
    }

    /// The grid of whole cells from the extent's north-western corner that lies within it.
    ///
    /// # Errors
    /// [`LimitSurfaceError::Setting`] where there is no room for a cell, or there are too many.
    pub fn over(extent: &Extent, cell_m: f64) -> Result<Self, LimitSurfaceError> {
        let wrong = |reason: String| Err(LimitSurfaceError::Setting(reason));
        if !(cell_m > 0.0 && cell_m.is_finite()) {
            return wrong(format!("cells of {cell_m} m are none"));
        }
        // What rounding takes from a whole number of cells is no reason to lose one.
        let cells = (extent.size_m() / cell_m * (1.0 + 1.0e-12)).floor();
        if !cells.cmpge(DVec2::ONE).all() {
            return wrong(format!("there is no room for a triangle of {cell_m} m"));
        }
        let triangles = 2.0 * cells.x * cells.y;
        if triangles > Self::MOST_TRIANGLES as f64 {
            return wrong(format!(
                "{triangles:.0} triangles of {cell_m:.3} m are too many (at most {}); take a \
                 smaller area or a larger least distance",
                Self::MOST_TRIANGLES
            ));
        }
        let origin = dvec2(extent.min.x, extent.max.y);
        Ok(Self { origin, cell_m, columns: cells.x as u32, rows: cells.y as u32 })
    }

    /// How many triangles there are.
    pub fn triangle_count(&self) -> usize {
        2 * self.columns as usize * self.rows as usize
    }

    /// How many nodes there are: one more than cells either way.
    pub fn node_count(&self) -> usize {
        (self.columns as usize + 1) * (self.rows as usize + 1)
    }

    /// The place of a node in row-major lists.
    pub fn node_index(&self, row: u32, column: u32) -> usize {
        row as usize * (self.columns as usize + 1) + column as usize
    }

    /// Where a node lies.
    pub fn node(&self, row: u32, column: u32) -> DVec2 {
        self.origin + dvec2(f64::from(column), -f64::from(row)) * self.cell_m
    }

    /// The ground the grid covers.
    pub fn extent(&self) -> Extent {
        let south_east = self.node(self.rows, self.columns);
        Extent::new(dvec2(self.origin.x, south_east.y), dvec2(south_east.x, self.origin.y))
    }

    /// Rows and columns of a triangle's three nodes.
    pub fn triangle_nodes(&self, triangle: usize) -> [[u32; 2]; 3] {
        let cell = triangle / 2;
        let row = (cell / self.columns as usize) as u32;
        let column = (cell % self.columns as usize) as u32;
        let (north_west, south_east) = ([row, column], [row + 1, column + 1]);
        match triangle % 2 {
            0 => [north_west, [row, column + 1], south_east],
            _ => [north_west, south_east, [row + 1, column]],
        }
    }

    /// A triangle's corners over heights in metres, one a node; `None` where a node has none (NaN).
    pub fn corners(&self, triangle: usize, heights_m: &[f32]) -> Option<[DVec3; 3]> {
        let corners = self.triangle_nodes(triangle).map(|[row, column]| {
            let height_m = heights_m[self.node_index(row, column)];
            self.node(row, column).extend(f64::from(height_m))
        });
        corners.iter().all(|corner| !corner.z.is_nan()).then_some(corners)
    }
}

/// The middle of a triangle and its upward unit normal.
pub fn middle_and_normal([a, b, c]: [DVec3; 3]) -> (DVec3, DVec3) {
    let normal = (b - a).cross(c - a).normalize();
    ((a + b + c) / 3.0, if normal.z < 0.0 { -normal } else { normal })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flat_triangle_just_spans_the_angle_from_the_least_distance() {
        let cell_m = LimitGrid::cell_m_for(5_000.0, 0.001);
        let seen_rad = 2.0 * (0.5 * cell_m * std::f64::consts::SQRT_2 / 5_000.0).atan();
        assert!((seen_rad - 0.001).abs() < 1.0e-12);
        assert!((LimitGrid::least_distance_m_for(cell_m, 0.001) - 5_000.0).abs() < 1.0e-9);
    }

    #[test]
    fn triangles_tile_the_grid() {
        let extent = Extent::new(dvec2(100.0, 200.0), dvec2(131.0, 219.5));
        let grid = LimitGrid::over(&extent, 5.0).unwrap();
        assert_eq!((grid.columns, grid.rows), (6, 3));
        let heights_m = vec![7.0; grid.node_count()];
        let mut area_m2 = 0.0;
        for triangle in 0..grid.triangle_count() {
            let [a, b, c] = grid.corners(triangle, &heights_m).unwrap();
            area_m2 += 0.5 * (b - a).cross(c - a).length();
            let (middle, normal) = middle_and_normal([a, b, c]);
            assert!(grid.extent().contains(middle.truncate()));
            assert_eq!(normal, DVec3::Z);
        }
        assert!((area_m2 - 30.0 * 15.0).abs() < 1.0e-9);
        assert_eq!(grid.extent().max, dvec2(130.0, 219.5));
    }

    #[test]
    fn grids_that_cannot_be_are_refused() {
        let extent = Extent::new(DVec2::ZERO, DVec2::splat(10.0));
        for cell_m in [0.0, -1.0, f64::NAN, f64::INFINITY, 11.0, 1.0e-5] {
            assert!(LimitGrid::over(&extent, cell_m).is_err(), "{cell_m}");
        }
    }

    #[test]
    fn a_triangle_with_a_void_node_is_none() {
        let extent = Extent::new(DVec2::ZERO, DVec2::splat(2.0));
        let grid = LimitGrid::over(&extent, 1.0).unwrap();
        let mut heights_m = vec![0.0; grid.node_count()];
        heights_m[grid.node_index(0, 1)] = f32::NAN;
        let whole: Vec<bool> =
            (0..8).map(|triangle| grid.corners(triangle, &heights_m).is_some()).collect();
        // The north-eastern half of cell (0, 0) and both halves of (0, 1) touch the node.
        assert_eq!(whole, [false, true, false, false, true, true, true, true]);
    }
}
