use glam::DVec3;

use super::TileTree;
use crate::dataset::HeightRange;
use crate::tiling::{FIXED_UNITS_PER_ROOT, MAX_LEVEL, TileId};

/// The eye among the tiles in whole units, so that how far a tile is comes out the same on the CPU
/// and on the GPU, bit for bit.
///
/// A unit is 2^-30 of the root's side ([`FIXED_UNITS_PER_ROOT`]), doubled as often as it takes for
/// eye and heights to lie within [`Self::REACH`] units: above the data a unit is some micrometres to
/// centimetres, seen from afar it grows with the distance. Boxes are rounded outward, the eye to the
/// nearest unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EyeUnits {
    /// East and south of the root's north-west corner, and up.
    pub eye: [i32; 3],
    /// How often the unit was doubled.
    pub doublings: u32,
    units_per_m: f64,
    vertical_exaggeration: f64,
}

/// The heights of a tile as drawn in units: the lowest and the highest.
pub(crate) type HeightUnits = [i32; 2];

impl EyeUnits {
    /// No coordinate of eye, tile or height lies farther from zero.
    pub const REACH: i32 = FIXED_UNITS_PER_ROOT;
    const MOST_DOUBLINGS: u32 = 30;
    /// A tile whose heights are not known counts as no farther above or below than it is beside.
    pub const EVERY_HEIGHT: HeightUnits = [-Self::REACH, Self::REACH];

    pub fn new(tree: &TileTree, eye: DVec3, vertical_exaggeration: f64) -> Self {
        let units_per_m = f64::from(FIXED_UNITS_PER_ROOT) / tree.scheme.root_size_m;
        let origin = tree.scheme.origin;
        let place = DVec3::new(eye.x - origin.x, origin.y - eye.y, eye.z) * units_per_m;
        let heights = tree.height_ranges.range(TileId::ROOT).map_or([0.0; 2], |range| {
            [range.min_m, range.max_m].map(|h| f64::from(h) * vertical_exaggeration * units_per_m)
        });
        // `f64::max` passes over NaN, and a cast takes it to 0.
        let farthest =
            place.to_array().into_iter().chain(heights).map(f64::abs).fold(0.0, f64::max);
        let reach = |doublings: u32| f64::from(Self::REACH) * f64::from(1_u32 << doublings);
        let doublings = (0..Self::MOST_DOUBLINGS)
            .find(|&doublings| farthest <= reach(doublings))
            .unwrap_or(Self::MOST_DOUBLINGS);
        let part = 1.0 / f64::from(1_u32 << doublings);
        let eye = (place * part).to_array().map(|units| in_reach(units.round()));
        Self { eye, doublings, units_per_m: units_per_m * part, vertical_exaggeration }
    }

    /// The heights of a range as drawn.
    pub fn heights(&self, range: Option<HeightRange>) -> HeightUnits {
        range.map_or(Self::EVERY_HEIGHT, |range| {
            let factor = self.vertical_exaggeration * self.units_per_m;
            let ends = [range.min_m, range.max_m].map(|height_m| f64::from(height_m) * factor);
            let (low, high) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
            [in_reach(low.floor()), in_reach(high.ceil())]
        })
    }

    /// The square of the distance from the eye to the nearest point the tile's ground may have: the
    /// box of its extent and of `heights`. Twin of `squared_distance` in `common/tile_distance.wgsl`.
    ///
    /// Nothing overflows: each gap is between two numbers within [`Self::REACH`] = 2^30, so at most
    /// 2^31, its square at most 2^62, and three of these are less than 2^64.
    pub fn squared_distance(&self, tile: TileId, heights: HeightUnits) -> u64 {
        let [east, south, up] = self.eye;
        let side = 30 - u32::from(tile.level);
        // At most 2^30 + 2^30 - 1 before the division.
        let round_up = (1_u32 << self.doublings) - 1;
        let gap_beside = |eye: i32, index: u32| {
            let low = (index << side) >> self.doublings;
            let high = (((index + 1) << side) + round_up) >> self.doublings;
            squared_gap(eye, low as i32, high as i32)
        };
        gap_beside(east, tile.column)
            + gap_beside(south, tile.row)
            + squared_gap(up, heights[0], heights[1])
    }

    /// For each level the squared distance below which a texel of it appears larger than
    /// `split_factor`, the threshold in radians: a tile is split while its squared distance is less.
    /// The finest level is never split.
    pub fn split_below(&self, tree: &TileTree, split_factor: f64) -> SplitDistances {
        let mut below = [0; MAX_LEVEL as usize + 1];
        for level in 0..tree.finest_level() {
            let reach = tree.texel_size_m(level) * self.units_per_m / split_factor;
            // A whole number is less than the square of `reach` where it is less than the square
            // rounded up. What is too large saturates above every distance.
            below[usize::from(level)] =
                if split_factor <= 0.0 { u64::MAX } else { (reach * reach).ceil() as u64 };
        }
        below
    }
}

/// See [`EyeUnits::split_below`]; by level.
pub(crate) type SplitDistances = [u64; MAX_LEVEL as usize + 1];

fn in_reach(units: f64) -> i32 {
    (units as i32).clamp(-EyeUnits::REACH, EyeUnits::REACH)
}

/// The square of the way from `eye` to the nearest number from `low` to `high`.
fn squared_gap(eye: i32, low: i32, high: i32) -> u64 {
    let (eye, low, high) = (i64::from(eye), i64::from(low), i64::from(high));
    let gap = (low - eye).max(eye - high).max(0) as u64;
    gap * gap
}
