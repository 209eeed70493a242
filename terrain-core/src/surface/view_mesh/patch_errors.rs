use glam::IVec2;

use super::right_triangle::RightTriangle;

/// Heights on the lattice of a tile, for judging triangles: the corners of `cells` x `cells` squares and
/// their middles. Points count half cells.
pub(super) struct Lattice {
    /// Cells along a side, a power of two.
    pub cells: u32,
    /// Side of a cell in metres.
    pub cell_m: f64,
    /// Heights in metres at points whose coordinates are both even or both odd, row by row; NaN where
    /// there is no data. The other points are not looked at.
    pub heights_m: Vec<f32>,
}

/// The largest vertical distance in metres of the ground from each triangle of the bisection of a tile,
/// at every point of the lattice in it.
///
/// Triangles whose ground holds data in part only are to be cut until they are small: theirs is at
/// least their longest side.
pub(super) struct PatchErrors {
    /// Depth below the tile's halves of the smallest triangles judged.
    depth: u8,
    /// Of either half, triangles as in a heap: the children of `i` are `2 i` and `2 i + 1`, from 1.
    errors_m: [Vec<f32>; 2],
}

impl PatchErrors {
    /// Judges every triangle down to those whose longest side is two cells.
    pub fn of(lattice: &Lattice, position: (u32, u32)) -> Self {
        let depth = (2 * lattice.cells.ilog2()).saturating_sub(1) as u8;
        let side = 2 * lattice.cells as i32;
        let halves = RightTriangle::halves(IVec2::ZERO, side, position);
        let errors_m = halves.map(|half| {
            let mut judged = Judged::new(lattice, depth);
            judged.take_points(half);
            judged.mark_voids(half, 1, 0);
            judged.errors_m
        });
        Self { depth, errors_m }
    }

    /// The error of the triangle that `path` (a bit a cut, the last in the lowest bit; 1 for the second
    /// child) leads to from the half in `depth` steps; `None` for triangles smaller than those judged.
    pub fn error_m(&self, half: u32, depth: u8, path: u64) -> Option<f32> {
        (depth <= self.depth).then(|| {
            let first = 1_u64 << depth;
            self.errors_m[half as usize & 1][(first | (path & (first - 1))) as usize]
        })
    }

    /// Depth of the smallest triangles judged.
    pub fn depth(&self) -> u8 {
        self.depth
    }
}

struct Judged<'a> {
    lattice: &'a Lattice,
    depth: u8,
    errors_m: Vec<f32>,
}

/// What of a triangle's ground holds data.
#[derive(Clone, Copy)]
struct Held {
    some: bool,
    all: bool,
}

impl<'a> Judged<'a> {
    fn new(lattice: &'a Lattice, depth: u8) -> Self {
        Self { lattice, depth, errors_m: vec![0.0; 2 << depth] }
    }

    fn height_m(&self, point: IVec2) -> f32 {
        let width = 2 * self.lattice.cells as usize + 1;
        self.lattice.heights_m[point.y as usize * width + point.x as usize]
    }

    /// Takes every point of the half down through the triangles that hold it.
    fn take_points(&mut self, half: RightTriangle) {
        let side = 2 * self.lattice.cells as i32;
        for y in 0..=side {
            for x in ((y & 1)..=side).step_by(2) {
                let point = IVec2::new(x, y);
                let [left, right] = half.parts(point);
                if left >= 0.0 && right >= 0.0 && left + right <= 1.0 {
                    self.take_point(half, point);
                }
            }
        }
    }

    fn take_point(&mut self, half: RightTriangle, point: IVec2) {
        let height_m = self.height_m(point);
        if height_m.is_nan() {
            return;
        }
        let (mut triangle, mut index) = (half, 1);
        let mut corners_m = [half.apex, half.left, half.right].map(|corner| self.height_m(corner));
        for depth in 0..=self.depth {
            let [left, right] = triangle.parts(point);
            let [apex_m, left_m, right_m] = corners_m;
            let plane_m = apex_m + left * (left_m - apex_m) + right * (right_m - apex_m);
            // A plane through a void is none; such triangles are marked.
            self.errors_m[index] = self.errors_m[index].max((height_m - plane_m).abs());
            let Some(middle) = triangle.middle().filter(|_| depth < self.depth) else { break };
            let is_second = right > left;
            triangle = triangle.children(middle)[usize::from(is_second)];
            let middle_m = self.height_m(middle);
            corners_m = match is_second {
                false => [middle_m, apex_m, left_m],
                true => [middle_m, right_m, apex_m],
            };
            index = 2 * index + usize::from(is_second);
        }
    }

    /// Sets the errors of triangles with a void in them; returns what of the triangle holds data.
    fn mark_voids(&mut self, triangle: RightTriangle, index: usize, depth: u8) -> Held {
        let corners = [triangle.apex, triangle.left, triangle.right];
        let held = corners.map(|corner| !self.height_m(corner).is_nan());
        let mut held = Held { some: held.contains(&true), all: !held.contains(&false) };
        if let Some(middle) = triangle.middle().filter(|_| depth < self.depth) {
            let [first, second] = triangle.children(middle);
            for (child, index) in [(first, 2 * index), (second, 2 * index + 1)] {
                let below = self.mark_voids(child, index, depth + 1);
                held = Held { some: held.some | below.some, all: held.all & below.all };
            }
        } else if let Some(middle) = triangle.middle() {
            let has_middle = !self.height_m(middle).is_nan();
            held = Held { some: held.some | has_middle, all: held.all & has_middle };
        }
        if !held.all {
            let units = (triangle.left - triangle.right).as_dvec2().length();
            let longest_m = (0.5 * units * self.lattice.cell_m) as f32;
            let error_m = &mut self.errors_m[index];
            *error_m = if held.some { error_m.max(longest_m) } else { 0.0 };
        }
        held
    }
}
