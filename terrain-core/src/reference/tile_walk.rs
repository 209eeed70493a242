//! A ray's way over the tiles of a dataset, from near to far.

use glam::DVec2;

use super::grid_walk::{GridHit, GridWalk, Ray, Search, next_cut};
use super::height_grid::HeightGrid;
use super::lazy_tiles::{LazyTile, LazyTiles};
use super::patch::Side;
use crate::dataset::HeightRanges;

/// What a walk needs to know of the dataset.
#[derive(Clone, Copy)]
pub(super) struct Ground<'a> {
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
        let middle = tile.middle;
        let cut = (middle - self.ray.origin.truncate()) * self.inverse;
        let mut at = from;
        loop {
            // The ray comes to the north as it comes to the east: both are counted upwards.
            let east = (at >= cut.x) == (self.inverse.x > 0.0);
            let north = (at >= cut.y) == (self.inverse.y > 0.0);
            let next = next_cut(cut.to_array(), at, to);
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
        let mut walk = GridWalk::new(grid, &self.ray, self.search, self.side);
        let hit = walk.first_hit(from, to).map(|hit| (grid, hit));
        self.side = walk.side();
        hit
    }

    /// Whether the ray misses all the tile's ground; then `side` says how. The tile is not read.
    fn passes(&mut self, tile: &LazyTile<HeightGrid>, [from, to]: [f64; 2]) -> bool {
        let Some(range) = self.ground.ranges.range(tile.id) else {
            self.side = None;
            return true;
        };
        let range_m = [f64::from(range.min_m), f64::from(range.max_m)];
        self.ray.passes(range_m, [from, to], &mut self.side)
    }
}
