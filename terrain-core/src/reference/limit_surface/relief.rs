use glam::{DVec2, DVec3};

use super::footprint::Relief;
use super::height_pyramid::HeightPyramid;
use super::{LimitGrid, LimitSurfaceError};

/// The shape of a limit-triangulated surface: heights at the nodes of its grid.
#[derive(Clone, Debug, PartialEq)]
pub struct LimitRelief {
    grid: LimitGrid,
    heights_m: Vec<f32>,
    pyramid: HeightPyramid,
}

impl LimitRelief {
    /// Of a grid and a height in metres above the datum a node, row by row; NaN where there is none.
    ///
    /// # Errors
    /// [`LimitSurfaceError::Setting`] where there are not as many heights as nodes, or one is infinite.
    pub fn new(grid: LimitGrid, heights_m: Vec<f32>) -> Result<Self, LimitSurfaceError> {
        if heights_m.len() != grid.node_count() {
            let reason = format!("{} heights for {} nodes", heights_m.len(), grid.node_count());
            return Err(LimitSurfaceError::Setting(reason));
        }
        if heights_m.iter().any(|height_m| height_m.is_infinite()) {
            return Err(LimitSurfaceError::Setting("a height is infinite".to_owned()));
        }
        let pyramid = HeightPyramid::new(&grid, &heights_m);
        Ok(Self { grid, heights_m, pyramid })
    }

    /// Where the triangles lie.
    pub fn grid(&self) -> &LimitGrid {
        &self.grid
    }

    /// Heights at the nodes, metres above the datum, row by row; NaN where there is none.
    pub fn heights_m(&self) -> &[f32] {
        &self.heights_m
    }

    /// The ranges by which rays skip.
    pub fn pyramid(&self) -> &HeightPyramid {
        &self.pyramid
    }

    /// A triangle's corners in metres, or `None` where it holds no data or is none.
    pub fn corners(&self, triangle: usize) -> Option<[DVec3; 3]> {
        if triangle >= self.grid.triangle_count() {
            return None;
        }
        self.grid.corners(triangle, &self.heights_m)
    }

    /// The surface with each node at another height, given its place and its height.
    ///
    /// # Errors
    /// [`LimitSurfaceError::Setting`] where a new height is infinite.
    pub fn deformed(
        &self,
        height_m: impl Fn(DVec2, f32) -> f32,
    ) -> Result<Self, LimitSurfaceError> {
        let mut heights_m = self.heights_m.clone();
        for row in 0..=self.grid.rows {
            for column in 0..=self.grid.columns {
                let height = &mut heights_m[self.grid.node_index(row, column)];
                *height = height_m(self.grid.node(row, column), *height);
            }
        }
        Self::new(self.grid, heights_m)
    }

    /// Bytes in memory: heights and ranges.
    pub fn byte_len(&self) -> u64 {
        4 * self.heights_m.len() as u64 + self.pyramid.byte_len()
    }

    /// Height of the triangles at a point, the grid's border continued beyond it; NaN in a void.
    pub fn height_m(&self, point: DVec2) -> f64 {
        let size = DVec2::new(f64::from(self.grid.columns), f64::from(self.grid.rows));
        let place = DVec2::new(point.x - self.grid.origin.x, self.grid.origin.y - point.y);
        let place = (place / self.grid.cell_m).clamp(DVec2::ZERO, size);
        let cell = place.floor().min(size - 1.0);
        self.cell(cell.y as u32, cell.x as u32).height_m(place - cell)
    }

    /// The heights of a cell's nodes.
    pub(super) fn cell(&self, row: u32, column: u32) -> CellHeights {
        let start = self.grid.node_index(row, column);
        let below = self.grid.node_index(row + 1, column);
        let at = |index: usize| f64::from(self.heights_m[index]);
        CellHeights {
            north_west: at(start),
            north_east: at(start + 1),
            south_west: at(below),
            south_east: at(below + 1),
        }
    }
}

/// Heights of a cell's nodes in metres.
#[derive(Clone, Copy)]
pub(super) struct CellHeights {
    north_west: f64,
    north_east: f64,
    south_west: f64,
    south_east: f64,
}

impl CellHeights {
    /// Height at a place of the cell, 0..=1 to the east and to the south.
    pub fn height_m(&self, place: DVec2) -> f64 {
        self.height_of_half_m(if place.x >= place.y { 0 } else { 1 }, place)
    }

    /// Height of a half's plane at a place: 0 the north-eastern half, 1 the south-western.
    pub fn height_of_half_m(&self, half: u32, place: DVec2) -> f64 {
        let [east, south] = match half {
            0 => [self.north_east - self.north_west, self.south_east - self.north_east],
            _ => [self.south_east - self.south_west, self.south_west - self.north_west],
        };
        self.north_west + place.x * east + place.y * south
    }
}

/// The ray from the apex is followed to the surface by secants from the tangent plane, which is near.
impl Relief for &LimitRelief {
    fn meet(&self, apex: DVec3, through: DVec3) -> DVec3 {
        const STEPS: usize = 3;
        let ray = through - apex;
        let above_m = |t: f64| {
            let point = apex + ray * t;
            point.z - self.height_m(point.truncate())
        };
        let within = |t: f64| t.clamp(0.5, 1.5);
        let (mut last, mut next) = (1.0, 1.0);
        let mut last_above_m = above_m(1.0);
        if ray.z != 0.0 {
            next = within(1.0 - last_above_m / ray.z);
        }
        for _ in 0..STEPS {
            let next_above_m = above_m(next);
            let fall = next_above_m - last_above_m;
            if next_above_m.abs() < 1.0e-6 || fall == 0.0 {
                break;
            }
            let better = within(next - next_above_m * (next - last) / fall);
            (last, last_above_m, next) = (next, next_above_m, better);
        }
        if next.is_finite() { apex + ray * next } else { through }
    }
}
