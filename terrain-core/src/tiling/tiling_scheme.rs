use glam::{DVec2, dvec2};
use serde::{Deserialize, Serialize};

use super::{Extent, FixedPosition, TileId};

/// Where the root tile lies on the ground: the frame all tiles of a dataset share.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TilingScheme {
    /// North-west corner of the root tile, metres.
    pub origin: DVec2,
    /// Side of the root tile, metres; positive and finite.
    pub root_size_m: f64,
}

impl TilingScheme {
    /// Side in metres of a tile of the level. Formula (1) of the tile-scheduling paper, D(lod).
    pub fn tile_size_m(&self, level: u8) -> f64 {
        self.root_size_m / f64::from(1u32 << level)
    }

    /// North-west corner of the tile, metres.
    pub fn tile_origin(&self, tile: TileId) -> DVec2 {
        let size_m = self.tile_size_m(tile.level);
        self.origin + dvec2(f64::from(tile.column) * size_m, -f64::from(tile.row) * size_m)
    }

    /// The ground the tile covers.
    pub fn tile_extent(&self, tile: TileId) -> Extent {
        let corner = self.tile_origin(tile);
        let size_m = self.tile_size_m(tile.level);
        Extent::new(corner - dvec2(0.0, size_m), corner + dvec2(size_m, 0.0))
    }

    /// The ground the root covers.
    pub fn root_extent(&self) -> Extent {
        self.tile_extent(TileId::ROOT)
    }

    /// The tile of the level that holds the point, or `None` outside the root. A point on a border
    /// between tiles belongs to the eastern and southern one; the root's own far borders count as in.
    pub fn tile_at(&self, level: u8, point: DVec2) -> Option<TileId> {
        if !self.root_extent().contains(point) {
            return None;
        }
        let tiles = f64::from(1u32 << level);
        let from_corner = dvec2(point.x - self.origin.x, self.origin.y - point.y);
        let index = (from_corner / self.root_size_m * tiles).floor();
        let index = index.clamp(DVec2::ZERO, DVec2::splat(tiles - 1.0));
        Some(TileId::new(level, index.y as u32, index.x as u32))
    }

    /// The point in fixed-point units of the root (x to the east, y to the *south*), rounded to the
    /// nearest unit and saturated at the range of `i32` (two root sides from the corner).
    pub fn fixed_from_world(&self, point: DVec2) -> FixedPosition {
        FixedPosition::from_root_fraction(
            (point.x - self.origin.x) / self.root_size_m,
            (self.origin.y - point.y) / self.root_size_m,
        )
    }
}
