//! A ray's way over the cells of one tile, past blocks of cells that it cannot meet.
//!
//! A block is cut into its four quarters where the ray crosses its middle lines, down to single
//! cells. The order of cells and the distances at which the ray enters and leaves each follow from the
//! comparison of its distances to the grid's lines alone, never from rounded places, so that they are
//! the same, bit for bit, whether blocks are passed or not, and no part of the ray is left out.

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
    /// Whether the ray misses all heights of a range (metres) between two distances; then `side`, on
    /// which it was before, becomes the one on which it passes.
    pub fn passes(
        &self,
        [low_m, high_m]: [f64; 2],
        [from, to]: [f64; 2],
        side: &mut Option<Side>,
    ) -> bool {
        let (start, end) =
            (self.origin.z + from * self.direction.z, self.origin.z + to * self.direction.z);
        // Plain comparisons: `f64::min` takes pains over NaN, and this is done for every block.
        let (lowest, highest) = if start < end { (start, end) } else { (end, start) };
        if lowest > high_m * self.exaggeration + self.slack_m {
            *side = Some(Side::Above);
            return true;
        }
        // A ray that was above and is below what comes next meets the surface at the border.
        let passes_below =
            highest < low_m * self.exaggeration - self.slack_m && *side != Some(Side::Above);
        if passes_below {
            *side = Some(Side::Below);
        }
        passes_below
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

/// One axis of the grid as the ray sees it.
#[derive(Clone, Copy)]
struct Axis {
    origin: f64,
    step: f64,
    inverse: f64,
}

impl Axis {
    fn new(origin: f64, step: f64) -> Self {
        Self { origin, step, inverse: 1.0 / step }
    }

    /// Distance at which the ray crosses the line between a cell and the one before it. Infinite,
    /// with the right sign, where it goes along the lines.
    fn distance(&self, cell: i32) -> f64 {
        (f64::from(cell) - 0.5 - self.origin) * self.inverse
    }

    /// Whether the ray goes towards higher cells (if it does at all).
    fn goes_up(&self) -> bool {
        self.inverse > 0.0
    }
}

/// A square of 2^level cells a side by its first cell's column and row.
#[derive(Clone, Copy)]
struct Block {
    level: u32,
    cell: [i32; 2],
}

/// A ray over one tile's grid.
pub(super) struct GridWalk<'a> {
    grid: &'a HeightGrid,
    ray: &'a Ray,
    x: Axis,
    y: Axis,
    search: Search,
    /// Where the ray was when it came to the block at hand; `None` where there was no surface.
    side: Option<Side>,
}

impl<'a> GridWalk<'a> {
    /// `side` is where the ray is when it comes to the tile.
    pub fn new(grid: &'a HeightGrid, ray: &'a Ray, search: Search, side: Option<Side>) -> Self {
        let origin = grid.place_of(ray.origin.truncate());
        let step = grid.direction_of(ray.direction);
        let (x, y) = (Axis::new(origin.x, step.x), Axis::new(origin.y, step.y));
        Self { grid, ray, x, y, search, side }
    }

    /// Where the ray was at the end of what it has walked over.
    pub fn side(&self) -> Option<Side> {
        self.side
    }

    /// Where the ray goes below the surface between two distances at which it is in the tile.
    pub fn first_hit(&mut self, from: f64, to: f64) -> Option<GridHit> {
        self.visit(Block { level: self.grid.top_level(), cell: [0, 0] }, [from, to])
    }

    fn visit(&mut self, block: Block, [from, to]: [f64; 2]) -> Option<GridHit> {
        if block.level == 0 {
            return self.cross(block.cell, [from, to]);
        }
        if self.search == Search::Bounded && self.passes(block, [from, to]) {
            return None;
        }
        let level = block.level - 1;
        let middle = block.cell.map(|first| first + (1 << level));
        let cut = [self.cut(&self.x, middle[0]), self.cut(&self.y, middle[1])];
        let mut at = from;
        loop {
            let is_beyond =
                [(at >= cut[0]) == self.x.goes_up(), (at >= cut[1]) == self.y.goes_up()];
            let first = |axis: usize| if is_beyond[axis] { middle[axis] } else { block.cell[axis] };
            let next = next_cut(cut, at, to);
            let quarter = Block { level, cell: [first(0), first(1)] };
            if let Some(hit) = self.visit(quarter, [at, next]) {
                return Some(hit);
            }
            if next >= to {
                return None;
            }
            at = next;
        }
    }

    /// Distance at which the ray crosses into or out of the half of a block that begins with this
    /// cell; such that it never gets there where the tile ends before.
    fn cut(&self, axis: &Axis, middle: i32) -> f64 {
        match (middle < self.grid.cells(), axis.goes_up()) {
            (true, _) => axis.distance(middle),
            (false, true) => f64::INFINITY,
            (false, false) => f64::NEG_INFINITY,
        }
    }

    /// Whether the ray misses the block; then `side` says how.
    fn passes(&mut self, block: Block, [from, to]: [f64; 2]) -> bool {
        let [low_m, high_m] = self.grid.block_range(block.level, block.cell);
        if low_m > high_m {
            self.side = None;
            return true;
        }
        let range_m = [f64::from(low_m), f64::from(high_m)];
        self.ray.passes(range_m, [from, to], &mut self.side)
    }

    fn cross(&mut self, cell: [i32; 2], [from, to]: [f64; 2]) -> Option<GridHit> {
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
        let crossing = match self.grid.surface(cell) {
            CellSurface::Whole(patch) => patch.crossing(&patch_ray, self.side),
            CellSurface::Partial(patch) => patch.crossing(&patch_ray, self.side),
            CellSurface::Nothing => PatchCrossing::Leaves(None),
        };
        match crossing {
            PatchCrossing::Hit(s) => {
                let within = patch_ray.place + s * patch_ray.step;
                Some(GridHit { distance_m: from + s, cell, within })
            }
            PatchCrossing::Leaves(now) => {
                self.side = now;
                None
            }
        }
    }
}

/// The nearest of two cuts that lies ahead, or the end.
pub(super) fn next_cut(cuts: [f64; 2], at: f64, to: f64) -> f64 {
    let mut next = to;
    for cut in cuts {
        if cut > at && cut < next {
            next = cut;
        }
    }
    next
}
