use glam::{DVec2, dvec2};

use crate::tiling::{FIXED_UNITS_PER_ROOT, FixedPosition, TileId, TilingScheme};

/// How places on the ground, told in floats from a point such as the eye, become fixed-point units of
/// the root. The twin of `ground_units` in `common/ground_units.wgsl`: the same operations in the same
/// order and precision, so that CPU and GPU agree bit for bit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GroundUnits {
    /// The root's point nearest to the one offsets count from.
    pub anchor: FixedPosition,
    /// Where it lies from there, metres east and north.
    pub anchor_from_origin_m: [f32; 2],
    pub units_per_m: f32,
}

impl GroundUnits {
    /// Ends of what is told apart either way of the anchor: the float next below 2^30, which added to
    /// an anchor in the root stays in the range of `i32`.
    const REACH: f32 = 1_073_741_760.0;

    /// For offsets that count from `origin`.
    pub fn new(scheme: &TilingScheme, origin: DVec2) -> Self {
        let root = scheme.root_extent();
        let anchor = scheme.fixed_from_world(origin.clamp(root.min, root.max));
        let unit_m = scheme.root_size_m / f64::from(FIXED_UNITS_PER_ROOT);
        // From the rounded position back, so that rounding does not shift the tiles.
        let place = scheme.origin + dvec2(f64::from(anchor.x), -f64::from(anchor.y)) * unit_m;
        let from_origin_m = (place - origin).as_vec2();
        Self {
            anchor,
            anchor_from_origin_m: from_origin_m.to_array(),
            units_per_m: (1.0 / unit_m) as f32,
        }
    }

    /// The unit that holds the point, taken to the root's border where it lies outside.
    pub fn unit_at(&self, offset_m: [f32; 2]) -> FixedPosition {
        let [x, y] = self.units(offset_m, f32::floor);
        let in_root = |unit: i32| unit.clamp(0, FIXED_UNITS_PER_ROOT - 1);
        FixedPosition { x: in_root(x), y: in_root(y) }
    }

    /// The box between two offsets, the smaller and the larger, rounded outward.
    pub fn box_between(&self, min_m: [f32; 2], max_m: [f32; 2]) -> FixedBox {
        // North is up in offsets and down in units.
        let min = self.units([min_m[0], max_m[1]], f32::floor);
        let max = self.units([max_m[0], min_m[1]], f32::ceil);
        FixedBox { min, max }
    }

    fn units(&self, offset_m: [f32; 2], round: fn(f32) -> f32) -> [i32; 2] {
        let from_anchor = [
            offset_m[0] - self.anchor_from_origin_m[0],
            -(offset_m[1] - self.anchor_from_origin_m[1]),
        ];
        let units = from_anchor.map(|metres| {
            round((metres * self.units_per_m).clamp(-Self::REACH, Self::REACH)) as i32
        });
        [self.anchor.x + units[0], self.anchor.y + units[1]]
    }
}

/// A rectangle of ground in fixed-point units, x to the east and y to the south, both ends part of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct FixedBox {
    pub min: [i32; 2],
    pub max: [i32; 2],
}

impl FixedBox {
    /// Whether the tile and the box share at least a point; touching borders count.
    pub fn touches(&self, tile: TileId) -> bool {
        let side = 30 - u32::from(tile.level);
        let touches = |axis: usize, index: u32| {
            (index << side) as i32 <= self.max[axis]
                && self.min[axis] <= ((index + 1) << side) as i32
        };
        touches(0, tile.column) && touches(1, tile.row)
    }
}
