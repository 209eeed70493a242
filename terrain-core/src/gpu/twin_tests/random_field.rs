use crate::dataset::{HeightSamples, HeightTile};
use crate::tiling::{LayerLayout, TileId};

/// A reproducible stream of numbers: SplitMix64 (Steele, Lea and Flood, "Fast Splittable
/// Pseudorandom Number Generators", 2014).
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// Within 0..1.
    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Height in whole steps at a texel of an endless field: a hash, rough as no terrain is.
pub fn field_steps(level: u8, row: i64, column: i64) -> u16 {
    let key = (u64::from(level) << 56) ^ ((row as u64) << 28) ^ (column as u64 & 0xfff_ffff);
    (Random(key).next() & 0x3fff) as u16
}

/// Metres a step of the field.
pub const STEP_M: f32 = 1.0 / 16.0;
/// Height of step 0.
pub const BASE_STEPS: i32 = -4000;

/// The tile of the field: neighbours share their gutters' samples. As 16-bit steps, or as the same
/// heights in float32.
pub fn field_tile(layout: LayerLayout, tile: TileId, as_float: bool) -> HeightTile {
    let size = i64::from(layout.stored_size_texels());
    let gutter = i64::from(layout.gutter_texels);
    let tile_size = i64::from(layout.tile_size_texels);
    let first_row = i64::from(tile.row) * tile_size - gutter;
    let first_column = i64::from(tile.column) * tile_size - gutter;
    let words = (0..size * size)
        .map(|i| field_steps(tile.level, first_row + i / size, first_column + i % size))
        .collect::<Vec<_>>();
    let steps = HeightSamples::Steps { base_steps: BASE_STEPS, step_m: STEP_M, words };
    let samples = if as_float {
        let heights = (0..(size * size) as usize).map(|i| steps.height_m(i).unwrap_or(f32::NAN));
        HeightSamples::Metres(heights.collect())
    } else {
        steps
    };
    HeightTile { id: tile, stored_size_texels: size as u32, samples, range: None }
}
