//! A ray's way over the cells of one tile, past blocks of cells that it cannot meet.
//!
//! The order of cells and the distances at which the ray enters and leaves each follow from the
//! comparison of its distances to the grid's lines alone, never from rounded places, so that they are
//! the same, bit for bit, whether blocks are passed or not.

use glam::{DVec2, DVec3};

use super::height_grid::{CellSurface, HeightGrid};
use super::patch::{PatchCrossing, PatchRay, Side};

/// Whether blocks of cells and tiles that a ray cannot meet are passed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Search {
    /// They are.
    Bounded,
    /// Every cell along the ray is looked at: slow, to hold the other against.
    Exhaustive,
}

/// A ray over exaggerated heights.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ray {
    pub origin: DVec3,
    /// Of length 1.
    pub direction: DVec3,
    /// Not negative.
    pub exaggeration: f64,
    /// Metres by which a ray must miss a block to pass it: far more than rounding amounts to.
    pub slack_m: f64,
}

impl Ray {
    /// Which side of everything within a range of heights the ray is on between two distances;
    /// `None` where it may meet it.
    pub fn side_of(&self, [low_m, high_m]: [f64; 2], from: f64, to: f64) -> Option<Side> {
        let [start, end] = [from, to].map(|t| self.origin.z + t * self.direction.z);
        if start.min(end) > high_m * self.exaggeration + self.slack_m {
            return Some(Side::Above);
        }
        (start.max(end) < low_m * self.exaggeration - self.slack_m).then_some(Side::Below)
    }
}

/// Where a ray goes below the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct GridHit {
    /// Metres from the ray's origin.
    pub distance_m: f64,
    pub cell: [i32; 2],
    /// Place within the cell, in parts of its side.
    pub within: DVec2,
}

/// One axis of the grid as the ray sees it. Line k separates cells k and k + 1.
#[derive(Clone, Copy)]
struct Axis {
    origin: f64,
    step: f64,
    inverse: f64,
    cells: i32,
}

impl Axis {
    fn new(origin: f64, step: f64, cells: i32) -> Self {
        Self { origin, step, inverse: 1.0 / step, cells }
    }

    /// Distance at which the ray crosses line `line`.
    fn distance(&self, line: i32) -> f64 {
        (f64::from(line) + 0.5 - self.origin) * self.inverse
    }

    /// The line at which the ray leaves the block of 2^level cells that holds the cell, and where;
    /// infinitely far where the tile ends first or the ray does not go along this axis.
    fn exit(&self, cell: i32, level: u32) -> (i32, f64) {
        let first = (cell >> level) << level;
        let line = if self.step > 0.0 { first + (1 << level) - 1 } else { first - 1 };
        let is_inside = self.step != 0.0 && line >= 0 && line < self.cells - 1;
        (line, if is_inside { self.distance(line) } else { f64::INFINITY })
    }

    /// The cell beyond a line.
    fn beyond(&self, line: i32) -> i32 {
        if self.step > 0.0 { line + 1 } else { line }
    }

    /// The cell at a distance: the lines that are crossed by then lie behind, the others ahead. From
    /// the rounded place, then corrected by the distances of the lines themselves.
    fn cell_at(&self, distance: f64, is_crossed: impl Fn(f64) -> bool) -> i32 {
        let last = self.cells - 1;
        let mut cell = ((self.origin + distance * self.step + 0.5).floor() as i32).clamp(0, last);
        if self.step > 0.0 {
            while cell < last && is_crossed(self.distance(cell)) {
                cell += 1;
            }
            while cell > 0 && !is_crossed(self.distance(cell - 1)) {
                cell -= 1;
            }
        } else if self.step < 0.0 {
            while cell > 0 && is_crossed(self.distance(cell - 1)) {
                cell -= 1;
            }
            while cell < last && !is_crossed(self.distance(cell)) {
                cell += 1;
            }
        }
        cell
    }
}

/// A ray over one tile's grid.
pub(super) struct GridWalk<'a> {
    grid: &'a HeightGrid,
    ray: &'a Ray,
    x: Axis,
    y: Axis,
    search: Search,
}

impl<'a> GridWalk<'a> {
    pub fn new(grid: &'a HeightGrid, ray: &'a Ray, search: Search) -> Self {
        let origin = grid.place_of(ray.origin.truncate());
        let step = grid.direction_of(ray.direction);
        let axis = |origin, step| Axis::new(origin, step, grid.cells());
        Self { grid, ray, x: axis(origin.x, step.x), y: axis(origin.y, step.y), search }
    }

    /// Where the ray goes below the surface between two distances at which it is in the tile. `side`
    /// is where the ray was when it came, and is kept up to date; `None` where there was no surface.
    pub fn first_hit(&self, from: f64, to: f64, side: &mut Option<Side>) -> Option<GridHit> {
        let top = self.grid.top_level();
        let mut level = if self.search == Search::Bounded { top } else { 0 };
        let mut cell =
            [self.x.cell_at(from, |line| line <= from), self.y.cell_at(from, |line| line <= from)];
        let mut at = from;
        loop {
            let (line_x, exit_x) = self.x.exit(cell[0], level);
            let (line_y, exit_y) = self.y.exit(cell[1], level);
            let end = exit_x.min(exit_y).min(to);
            if level > 0 && !self.passes(level, cell, [at, end], side) {
                level -= 1;
                continue;
            }
            if level == 0 {
                if let Some(hit) = self.cross(cell, [at, end], side) {
                    return Some(hit);
                }
            }
            if end >= to {
                return None;
            }
            at = end;
            // Lines of rows that are met together with one of columns are crossed first.
            let crossed = if exit_y <= exit_x {
                cell = [self.x.cell_at(at, |line| line < at), self.y.beyond(line_y)];
                line_y
            } else {
                cell = [self.x.beyond(line_x), self.y.cell_at(at, |line| line <= at)];
                line_x
            };
            // Over the border of a larger block: that may be passed as a whole.
            let is_border = (crossed + 1) >> level & 1 == 0;
            if self.search == Search::Bounded && is_border && level < top {
                level += 1;
            }
        }
    }

    /// Whether the ray misses the block; then `side` says how.
    fn passes(
        &self,
        level: u32,
        cell: [i32; 2],
        [from, to]: [f64; 2],
        side: &mut Option<Side>,
    ) -> bool {
        let [low_m, high_m] = self.grid.block_range(level, cell);
        if low_m > high_m {
            *side = None;
            return true;
        }
        let range_m = [f64::from(low_m), f64::from(high_m)];
        match self.ray.side_of(range_m, from, to) {
            // It was above when it came to this block: it meets the surface at the border.
            Some(Side::Below) if *side == Some(Side::Above) => false,
            Some(found) => {
                *side = Some(found);
                true
            }
            None => false,
        }
    }

    fn cross(
        &self,
        cell: [i32; 2],
        [from, to]: [f64; 2],
        side: &mut Option<Side>,
    ) -> Option<GridHit> {
        let surface = self.grid.surface(cell);
        let place =
            |axis: &Axis, cell: i32| axis.origin + from * axis.step - (f64::from(cell) - 0.5);
        let patch_ray = PatchRay {
            place: DVec2::new(place(&self.x, cell[0]), place(&self.y, cell[1])),
            step: DVec2::new(self.x.step, self.y.step),
            z_m: self.ray.origin.z + from * self.ray.direction.z,
            rise: self.ray.direction.z,
            length_m: to - from,
            exaggeration: self.ray.exaggeration,
        };
        let crossing = match surface {
            CellSurface::Whole(patch) => patch.crossing(&patch_ray, *side),
            CellSurface::Partial(patch) => patch.crossing(&patch_ray, *side),
            CellSurface::Nothing => PatchCrossing::Leaves(None),
        };
        match crossing {
            PatchCrossing::Hit(s) => {
                let within = patch_ray.place + s * patch_ray.step;
                Some(GridHit { distance_m: from + s, cell, within })
            }
            PatchCrossing::Leaves(now) => {
                *side = now;
                None
            }
        }
    }
}
