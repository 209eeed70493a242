//! Ways to give a GPU that computes in f32 a place on Earth, under one interface.
//!
//! Each way encodes a point, the eye and the tile under the point in f64 arithmetic on the CPU
//! ([`EncodingScene::encode`]) and decodes them in f32 ([`EncodedPoint::decode`], and the same
//! operations in `precision_encodings.wgsl`) to where the point lies from the eye and in its tile.

mod contract;
mod measured;
mod points;
mod scene;
mod sweep;

pub use contract::{Contract, Verdict, Worst, verdicts};
pub use measured::{
    DecodedEvery, EARTH, EncodingErrors, GroundRow, PlaceRow, PositionRow, decode_on_cpu,
    measure_encodings,
};
pub use points::{EYE_FRACTIONS, spread};
pub use scene::{EncodedLayer, EncodingScene, PointError};
pub use sweep::{
    GroundCell, PlaceCell, PositionCell, SweepAxes, SweepPoint, VIEWPORT_HEIGHT_PX,
    finest_level_shown, ground_points, pixel_angle_rad, place_points, position_points,
};

use bytemuck::{Pod, Zeroable};
use serde::Serialize;

/// A way to hold a place in f32s or i32s.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Encoding {
    /// World coordinates narrowed to f32; the GPU takes the differences.
    AbsoluteFloat,
    /// Differences from the eye taken in f64, then narrowed.
    CameraRelative,
    /// Index of the tile and fraction of its side, for the point and for the eye.
    TileRelative,
    /// Each coordinate as the sum of two f32s, the second what the first could not hold. The GPU adds
    /// the differences of the halves (Deron Ohlarik, "Precisions, Precisions", 2008).
    SplitPair,
    /// 2^30 integer units to the root's side.
    FixedPoint,
    /// What the renderer does: fixed point for which tile holds the point, floats relative to the eye for
    /// where it is and where in the tile.
    Shipped,
}

impl Encoding {
    /// All of them, in the order of the tables.
    pub const ALL: [Self; 6] = [
        Self::AbsoluteFloat,
        Self::CameraRelative,
        Self::TileRelative,
        Self::SplitPair,
        Self::FixedPoint,
        Self::Shipped,
    ];

    /// Its name in tables and plots.
    pub fn name(self) -> &'static str {
        match self {
            Self::AbsoluteFloat => "absolute f32",
            Self::CameraRelative => "camera-relative f32",
            Self::TileRelative => "tile-relative",
            Self::SplitPair => "split pair",
            Self::FixedPoint => "fixed point",
            Self::Shipped => "shipped",
        }
    }
}

/// A point, the eye and the point's tile in every encoding: the twin of `EncodedPoint` in
/// `precision_encodings.wgsl`. Pairs are east and north, those of tiles and of fixed point east and
/// south.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[expect(missing_docs, reason = "explained in precision_encodings.wgsl")]
pub struct EncodedPoint {
    pub world: [f32; 2],
    pub world_low: [f32; 2],
    pub eye: [f32; 2],
    pub eye_low: [f32; 2],
    pub corner: [f32; 2],
    pub corner_low: [f32; 2],
    pub from_eye: [f32; 2],
    pub corner_from_eye: [f32; 2],
    pub shipped_corner_from_eye: [f32; 2],
    pub fraction: [f32; 2],
    pub eye_fraction: [f32; 2],
    pub tile: [i32; 2],
    pub eye_tile: [i32; 2],
    pub fixed: [i32; 2],
    pub eye_fixed: [i32; 2],
    pub corner_fixed: [i32; 2],
    pub tile_size_m: f32,
    pub texels_per_m: f32,
    pub tile_size_texels: f32,
    pub unit_m: f32,
    pub texels_per_unit: f32,
    pub padding: u32,
}

/// Where a point is once decoded: the twin of `Decoded` in `precision_encodings.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Decoded {
    /// Metres east and north of the eye.
    pub relative_m: [f32; 2],
    /// Texels east and south of the tile's north-west corner.
    pub place_texels: [f32; 2],
}

impl EncodedPoint {
    /// Decodes the point: the operations of `precision_encodings.wgsl`, in their order.
    pub fn decode(&self, encoding: Encoding) -> Decoded {
        let each = |axis: &dyn Fn(usize) -> f32| [axis(0), axis(1)];
        let (relative_m, place_texels) = match encoding {
            Encoding::AbsoluteFloat => (
                each(&|i| self.world[i] - self.eye[i]),
                each(&|i| south(i, self.world[i] - self.corner[i]) * self.texels_per_m),
            ),
            Encoding::CameraRelative => (self.from_eye, self.place_from(self.corner_from_eye)),
            Encoding::TileRelative => (
                each(&|i| {
                    let tiles = (self.tile[i] - self.eye_tile[i]) as f32;
                    south(i, (tiles + (self.fraction[i] - self.eye_fraction[i])) * self.tile_size_m)
                }),
                each(&|i| self.fraction[i] * self.tile_size_texels),
            ),
            Encoding::SplitPair => (
                each(&|i| (self.world[i] - self.eye[i]) + (self.world_low[i] - self.eye_low[i])),
                each(&|i| {
                    let high = self.world[i] - self.corner[i];
                    south(i, high + (self.world_low[i] - self.corner_low[i])) * self.texels_per_m
                }),
            ),
            Encoding::FixedPoint => (
                each(&|i| south(i, (self.fixed[i] - self.eye_fixed[i]) as f32 * self.unit_m)),
                each(&|i| (self.fixed[i] - self.corner_fixed[i]) as f32 * self.texels_per_unit),
            ),
            Encoding::Shipped => (self.from_eye, self.place_from(self.shipped_corner_from_eye)),
        };
        Decoded { relative_m, place_texels }
    }

    /// The twin of `texel_in_tile` in `common/tile_lookup.wgsl`.
    fn place_from(&self, corner_from_eye: [f32; 2]) -> [f32; 2] {
        let place = |i: usize| south(i, self.from_eye[i] - corner_from_eye[i]) * self.texels_per_m;
        [place(0), place(1)]
    }
}

/// North turned to south, or the reverse, on the second axis.
fn south(axis: usize, value: f32) -> f32 {
    if axis == 0 { value } else { -value }
}
