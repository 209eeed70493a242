//! Which height tiles the mesh takes its ground from.

use std::sync::Arc;

use glam::{DVec2, IVec2};

use super::bisection::NONE;
use super::height_patch::HeightPatch;
use super::right_triangle::RightTriangle;
use super::{GroundSample, ViewMesh};
use crate::tiling::{FIXED_UNITS_PER_ROOT, TileId};

/// A patch in use.
pub(super) struct UsedPatch {
    patch: Arc<HeightPatch>,
    /// How many of the four finer tiles in it are in use.
    children: u8,
}

impl UsedPatch {
    pub fn new(patch: Arc<HeightPatch>) -> Self {
        Self { patch, children: 0 }
    }
}

impl ViewMesh {
    /// Whether the tile's heights are in use.
    pub fn uses(&self, tile: TileId) -> bool {
        self.patches.contains_key(&tile)
    }

    /// Number of tiles in use.
    pub fn patch_count(&self) -> usize {
        self.patches.len()
    }

    /// The tiles in use, in no order.
    pub fn tiles_in_use(&self) -> impl Iterator<Item = TileId> + '_ {
        self.patches.keys().copied()
    }

    /// Height in metres without exaggeration from the finest tile in use that has data there.
    pub fn height_at_m(&self, point: DVec2) -> Option<f64> {
        let scheme = &self.frame.scheme;
        (0..=self.frame.layout.finest_level()).rev().find_map(|level| {
            self.patches.get(&scheme.tile_at(level, point)?)?.patch.height_at_m(point)
        })
    }

    /// Takes the ground of the patch's tile from it from now on. Does nothing where the tile above is
    /// not in use, or the tile is already.
    pub fn use_patch(&mut self, patch: Arc<HeightPatch>) {
        let tile = patch.tile();
        if self.uses(tile) {
            return;
        }
        let parent = tile.parent().and_then(|parent| self.patches.get_mut(&parent));
        let Some(above) = parent else { return };
        above.children += 1;
        self.patches.insert(tile, UsedPatch::new(patch));
        let halves = self.cut_to(tile);
        self.take_ground_of(&halves, tile.level);
    }

    /// Takes the ground of the tile from the one above it again. Does nothing where the tile is not in
    /// use, is level 0, or finer ones in it are in use.
    pub fn drop_patch(&mut self, tile: TileId) {
        let is_free = self.patches.get(&tile).is_some_and(|used| used.children == 0);
        let Some(parent) = tile.parent().filter(|_| is_free) else { return };
        self.patches.remove(&tile);
        if let Some(above) = self.patches.get_mut(&parent) {
            above.children -= 1;
        }
        let halves = self.cut_to(tile);
        self.take_ground_of(&halves, parent.level);
        for half in self.cut_to(parent) {
            self.judge(half);
            let children = self.bisection.get(half).children;
            if children != NONE {
                self.judge(children);
                self.judge(children + 1);
            }
        }
    }

    /// The patch that holds a triangle.
    pub(super) fn patch_of(&self, id: u32) -> &HeightPatch {
        let tile = tile_holding(self.shape(id).inner_point(), self.patch_levels[id as usize]);
        &self.patches[&tile].patch
    }

    /// How far in metres the ground lies from a triangle, without exaggeration; infinite where it must
    /// be cut, since finer tiles in it are in use.
    pub(super) fn error_m(&self, id: u32, shape: &RightTriangle) -> f32 {
        let Some(middle) = shape.middle().filter(|_| !self.is_beside_data(shape)) else {
            return 0.0;
        };
        let triangle = self.bisection.get(id);
        let level = self.patch_levels[id as usize];
        let used = &self.patches[&tile_holding(shape.inner_point(), level)];
        let depth = triangle.depth - 2 * level;
        if depth < 2 && used.children > 0 {
            return f32::INFINITY;
        }
        let half = (triangle.halves >> level) & 1;
        let [_, left, right] = triangle.corners;
        let ends_m = [left, right].map(|end| self.vertices.get(end).height_m);
        used.patch.error_m((half, depth, triangle.path), ends_m, middle)
    }

    /// The two triangles that are the halves of a tile, after cutting all that reaches across it. Of the
    /// triangles on the way, those in the tile above it are judged anew.
    fn cut_to(&mut self, tile: TileId) -> [u32; 2] {
        let size = FIXED_UNITS_PER_ROOT >> tile.level;
        let corner = IVec2::new(tile.column as i32, tile.row as i32) * size;
        let position = (tile.row, tile.column);
        RightTriangle::halves(corner, size, position).map(|half| {
            let aim = half.inner_point();
            let mut id = u32::from(!is_within(&self.shape(0), aim));
            while self.bisection.get(id).depth < 2 * tile.level {
                if self.bisection.get(id).depth + 2 >= 2 * tile.level {
                    self.judge(id);
                }
                if self.bisection.is_leaf(id) {
                    self.cut(id);
                }
                let first = self.bisection.get(id).children;
                id = first + u32::from(!is_within(&self.shape(first), aim));
            }
            id
        })
    }

    /// Takes heights and errors of all that lies in these triangles from the patches of the level.
    fn take_ground_of(&mut self, triangles: &[u32], level: u8) {
        let mut within = triangles.to_vec();
        let mut corners = Vec::new();
        let mut next = 0;
        while let Some(&id) = within.get(next) {
            self.patch_levels[id as usize] = level;
            let triangle = self.bisection.get(id);
            corners.extend(triangle.corners);
            if triangle.children != NONE {
                within.extend([triangle.children, triangle.children + 1]);
            }
            next += 1;
        }
        corners.sort_unstable();
        corners.dedup();
        for number in corners {
            let ground = self.finest_ground(self.vertices.get(number).position);
            self.vertices.set_ground(number, ground);
        }
        within.into_iter().for_each(|id| self.judge(id));
    }

    /// The ground at a vertex by the finest patch in use that it lies in or on the border of.
    fn finest_ground(&self, position: IVec2) -> GroundSample {
        let finest = (0..=self.frame.layout.finest_level()).rev();
        let touching = finest.flat_map(|level| tiles_touching(position, level));
        let used = touching.filter_map(|tile| self.patches.get(&tile)).next();
        // Level 0 touches every point of the root.
        let used = used.unwrap_or_else(|| &self.patches[&TileId::ROOT]);
        used.patch.sample(position)
    }
}

/// The tile of the level that holds the point; of a point on a border, the eastern and southern one.
fn tile_holding(point: IVec2, level: u8) -> TileId {
    let shift = 30 - u32::from(level);
    TileId::new(level, (point.y >> shift) as u32, (point.x >> shift) as u32)
}

/// The tiles of the level that the point lies in or on the border of.
fn tiles_touching(point: IVec2, level: u8) -> impl Iterator<Item = TileId> {
    let shift = 30 - u32::from(level);
    let span = move |place: i32| {
        let last = (place >> shift).min((1 << level) - 1);
        let first = ((place - 1).max(0) >> shift).min(last);
        first..=last
    };
    span(point.y).flat_map(move |row| {
        span(point.x).map(move |column| TileId::new(level, row as u32, column as u32))
    })
}

/// Whether the point lies in the triangle or on its border.
fn is_within(shape: &RightTriangle, point: IVec2) -> bool {
    let corners = [shape.apex, shape.left, shape.right].map(|corner| corner.as_i64vec2());
    let point = point.as_i64vec2();
    // Counter-clockwise from above is clockwise where y runs south.
    (0..3).all(|index| {
        let (from, to) = (corners[index], corners[(index + 1) % 3]);
        let (along, across) = (to - from, point - from);
        along.x * across.y - along.y * across.x <= 0
    })
}
