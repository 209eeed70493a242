use glam::{DVec2, USizeVec2, Vec2, dvec2, vec2};

use super::noise::mixed;

/// Side of the ground in metres; what presets show lies within it, away from its border.
pub const GROUND_SIZE_M: f64 = 288_000.0;

/// Heights of the whole ground at the centres of square cells, row by row from the north-west.
#[derive(Clone, Debug)]
pub struct HeightGrid {
    /// Cells along a side.
    pub side: usize,
    /// Metres above the datum.
    pub heights_m: Vec<f32>,
}

impl HeightGrid {
    /// Side of a cell in metres.
    pub fn cell_m(&self) -> f64 {
        GROUND_SIZE_M / self.side as f64
    }

    /// Metres east and south of the ground's north-west corner.
    pub fn centre_m(&self, cell: usize) -> DVec2 {
        (dvec2((cell % self.side) as f64, (cell / self.side) as f64) + 0.5) * self.cell_m()
    }

    /// The up to eight cells around a cell, each with its distance in cells.
    pub fn neighbours(&self, cell: usize) -> impl Iterator<Item = (usize, f32)> + use<> {
        let side = self.side;
        let (x, y) = (cell % side, cell / side);
        NEIGHBOURS.iter().filter_map(move |&(dx, dy, distance)| {
            let (x, y) = (x.wrapping_add_signed(dx), y.wrapping_add_signed(dy));
            (x < side && y < side).then(|| (y * side + x, distance))
        })
    }

    /// Whether water leaves the ground here: at the border of the plain, in the south-east.
    pub fn is_outlet(&self, cell: usize) -> bool {
        let (x, y, last) = (cell % self.side, cell / self.side, self.side - 1);
        (x == last || y == last) && 5 * (x + y) > 8 * last
    }

    /// The height at a place, straight between centres; beyond the border that of the border.
    pub fn height_at_m(&self, place_m: DVec2) -> f32 {
        let last = DVec2::splat((self.side - 1) as f64);
        let position = (place_m / self.cell_m() - 0.5).clamp(DVec2::ZERO, last);
        let corner = position.floor().as_usizevec2();
        let far = (corner + 1).min(USizeVec2::splat(self.side - 1));
        let at = (position - position.floor()).as_vec2();
        let row = |y: usize| {
            let height_m = |x: usize| self.heights_m[y * self.side + x];
            mixed(height_m(corner.x), height_m(far.x), at.x)
        };
        mixed(row(corner.y), row(far.y), at.y)
    }

    /// Height and gradient of the grid by cubic B-splines: smooth enough to be drawn from near.
    pub fn smooth_height(&self, place_m: DVec2) -> (f32, Vec2) {
        let position = place_m / self.cell_m() - dvec2(0.5, 0.5);
        let corner = position.floor();
        let at = (position - corner).as_vec2();
        let (along_x, along_y) = (spline_weights(at.x), spline_weights(at.y));
        let last = self.side as i64 - 1;
        let index = |corner: f64, offset: i64| (corner as i64 + offset).clamp(0, last) as usize;
        let (mut height_m, mut gradient) = (0.0, Vec2::ZERO);
        for (row, (weight_y, steepness_y)) in (-1..).zip(along_y) {
            let y = index(corner.y, row);
            let (mut value, mut slope) = (0.0, 0.0);
            for (column, (weight_x, steepness_x)) in (-1..).zip(along_x) {
                let height_m = self.heights_m[y * self.side + index(corner.x, column)];
                value += weight_x * height_m;
                slope += steepness_x * height_m;
            }
            height_m += weight_y * value;
            gradient += vec2(weight_y * slope, steepness_y * value);
        }
        (height_m, gradient / self.cell_m() as f32)
    }
}

/// Weights of the four nearest cells, and their derivatives.
fn spline_weights(t: f32) -> [(f32, f32); 4] {
    let s = 1.0 - t;
    [
        (s * s * s / 6.0, -0.5 * s * s),
        ((4.0 - 6.0 * t * t + 3.0 * t * t * t) / 6.0, 0.5 * t * (3.0 * t - 4.0)),
        ((4.0 - 6.0 * s * s + 3.0 * s * s * s) / 6.0, -0.5 * s * (3.0 * s - 4.0)),
        (t * t * t / 6.0, 0.5 * t * t),
    ]
}

const DIAGONAL: f32 = std::f32::consts::SQRT_2;
const NEIGHBOURS: [(isize, isize, f32); 8] = [
    (-1, -1, DIAGONAL),
    (0, -1, 1.0),
    (1, -1, DIAGONAL),
    (-1, 0, 1.0),
    (1, 0, 1.0),
    (-1, 1, DIAGONAL),
    (0, 1, 1.0),
    (1, 1, DIAGONAL),
];
