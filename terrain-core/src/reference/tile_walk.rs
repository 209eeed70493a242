//! A ray's way over the tiles of a dataset, from near to far.

use glam::{DVec2, DVec3};

use super::grid_walk::{GridHit, GridWalk, Ray, Search};
use super::height_grid::HeightGrid;
use super::lazy_tiles::{LazyTile, LazyTiles};
use super::patch::Side;
use crate::dataset::HeightRanges;
use crate::tiling::{Extent, TilingScheme};

/// What a walk needs to know of the dataset.
#[derive(Clone, Copy)]
pub(super) struct Ground<'a> {
    pub scheme: &'a TilingScheme,
    pub tiles: &'a LazyTiles<HeightGrid>,
    pub ranges: &'a HeightRanges,
}

/// One ray over the tiles.
pub(super) struct TileWalk<'a> {
    ground: Ground<'a>,
    ray: Ray,
    search: Search,
    inverse: DVec2,
    /// Where the ray was when it left the tile before.
    side: Option<Side>,
}

/// Where a ray meets the ground, and in which tile's grid.
pub(super) type TileHit<'a> = (&'a HeightGrid, GridHit);

impl<'a> TileWalk<'a> {
    pub fn new(ground: Ground<'a>, ray: Ray, search: Search) -> Self {
        let inverse = 1.0 / ray.direction.truncate();
        Self { ground, ray, search, inverse, side: None }
    }

    /// Where the ray goes below the surface between two distances at which it is in the root.
    pub fn first_hit(&mut self, from: f64, to: f64) -> Option<TileHit<'a>> {
        let root = self.ground.tiles.root();
        let ancestor = root.is_present().then_some(root);
        self.visit(root, ancestor, [from, to])
    }

    /// The same within one tile. `shown` is the finest tile present that holds it.
    fn visit(
        &mut self,
        tile: &'a LazyTile<HeightGrid>,
        shown: Option<&'a LazyTile<HeightGrid>>,
        [from, to]: [f64; 2],
    ) -> Option<TileHit<'a>> {
        if self.search == Search::Bounded && self.passes(tile, [from, to]) {
            return None;
        }
        let Some(children) = self.ground.tiles.children(tile) else {
            return self.visit_leaf(shown, [from, to]);
        };
        let middle = self.ground.scheme.tile_origin(children[3].id);
        let cut = (middle - self.ray.origin.truncate()) * self.inverse;
        let mut at = from;
        loop {
            // On the border a point belongs to the east and the south.
            let east = is_beyond(self.ray.direction.x, at >= cut.x, self.ray.origin.x >= middle.x);
            let north = is_beyond(self.ray.direction.y, at >= cut.y, self.ray.origin.y > middle.y);
            let next = [cut.x, cut.y].into_iter().filter(|&cut| cut > at).fold(to, f64::min);
            let child = &children[usize::from(!north) * 2 + usize::from(east)];
            let shown = if child.is_present() { Some(child) } else { shown };
            if let Some(hit) = self.visit(child, shown, [at, next]) {
                return Some(hit);
            }
            if next >= to {
                return None;
            }
            at = next;
        }
    }

    fn visit_leaf(
        &mut self,
        shown: Option<&'a LazyTile<HeightGrid>>,
        [from, to]: [f64; 2],
    ) -> Option<TileHit<'a>> {
        let Some(grid) = shown.and_then(|tile| self.ground.tiles.content(tile)) else {
            self.side = None;
            return None;
        };
        let walk = GridWalk::new(grid, &self.ray, self.search);
        walk.first_hit(from, to, &mut self.side).map(|hit| (grid, hit))
    }

    /// Whether the ray misses all the tile's ground; then `side` says how. The tile is not read.
    fn passes(&mut self, tile: &LazyTile<HeightGrid>, [from, to]: [f64; 2]) -> bool {
        let Some(range) = self.ground.ranges.range(tile.id) else {
            self.side = None;
            return true;
        };
        let range_m = [f64::from(range.min_m), f64::from(range.max_m)];
        match self.ray.side_of(range_m, from, to) {
            Some(Side::Below) if self.side == Some(Side::Above) => false,
            Some(found) => {
                self.side = Some(found);
                true
            }
            None => false,
        }
    }
}

/// Whether the ray is east or north of a line: by whether it has crossed it, or by where it starts
/// if it goes along it.
fn is_beyond(direction: f64, has_crossed: bool, starts_beyond: bool) -> bool {
    match direction {
        d if d > 0.0 => has_crossed,
        d if d < 0.0 => !has_crossed,
        _ => starts_beyond,
    }
}

/// The part of the ray within a box, as distances from its origin; `None` where it misses it.
/// Borders count as in.
pub(super) fn part_within(
    origin: DVec3,
    direction: DVec3,
    extent: &Extent,
    heights_m: [f64; 2],
) -> Option<[f64; 2]> {
    let (low, high) = (extent.min.extend(heights_m[0]), extent.max.extend(heights_m[1]));
    let (mut from, mut to) = (0.0_f64, f64::INFINITY);
    for axis in 0..3 {
        if direction[axis] == 0.0 {
            if origin[axis] < low[axis] || origin[axis] > high[axis] {
                return None;
            }
            continue;
        }
        let a = (low[axis] - origin[axis]) / direction[axis];
        let b = (high[axis] - origin[axis]) / direction[axis];
        from = from.max(a.min(b));
        to = to.min(a.max(b));
    }
    (from <= to).then_some([from, to])
}
