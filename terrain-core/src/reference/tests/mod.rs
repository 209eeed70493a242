//! The ray caster against arithmetic that knows nothing of tiles, bounds or quadratics.

mod independence;
mod pictures;
mod raster_source;
mod rays;

use std::sync::Arc;

use glam::{DVec2, DVec3, dvec2};

use super::ReferenceScene;
use raster_source::RasterSource;

/// North-west corner and texel size of the rasters.
const ORIGIN: DVec2 = DVec2::new(432_000.0, 6_850_000.0);
const TEXEL_M: f64 = 10.0;

/// A raster of heights and the scene over it.
struct Case {
    width: usize,
    heights_m: Vec<f64>,
    scene: ReferenceScene,
}

impl Case {
    fn new(width: usize, height: usize, height_m: impl Fn(usize, usize) -> f64) -> Self {
        Self::of_source(width, height, height_m, |_| {})
    }

    fn of_source(
        width: usize,
        height: usize,
        height_m: impl Fn(usize, usize) -> f64,
        change: impl Fn(&mut RasterSource),
    ) -> Self {
        // As the source hands them out.
        let heights_m: Vec<f64> = (0..width * height)
            .map(|index| f64::from(height_m(index / width, index % width) as f32))
            .collect();
        let mut source = RasterSource::new(width, heights_m.clone(), ORIGIN, TEXEL_M);
        change(&mut source);
        let scene = ReferenceScene::open(Arc::new(source)).unwrap();
        Self { width, heights_m, scene }
    }

    /// Bumpy ground of 0 to `relief_m` metres from a seed, some samples without data.
    fn bumpy(width: usize, height: usize, seed: u32, relief_m: f64, voids: bool) -> Self {
        Self::new(width, height, |row, column| bumpy_m(seed, relief_m, voids, row, column))
    }

    fn height(&self) -> usize {
        self.heights_m.len() / self.width
    }

    /// The world point of a place in texels east and south of the raster's corner.
    fn world(&self, place: DVec2) -> DVec2 {
        ORIGIN + dvec2(place.x, -place.y) * TEXEL_M
    }

    /// Height at a world point: straight from the raster, of the samples that hold data.
    fn height_m(&self, point: DVec2) -> Option<f64> {
        let (sum, share) = self.sum_and_share(point);
        let least = if self.heights_m.iter().any(|height| height.is_nan()) { 0.5 } else { 1e-6 };
        (share >= least).then(|| sum / share)
    }

    /// The heights around a point and their bilinear weights, of the samples that hold data: the sum
    /// of the products, and of the weights.
    fn sum_and_share(&self, point: DVec2) -> (f64, f64) {
        let place = dvec2(point.x - ORIGIN.x, ORIGIN.y - point.y) / TEXEL_M - 0.5;
        let low = place.floor();
        let part = place - low;
        let (mut sum, mut weight) = (0.0, 0.0);
        for (down, right) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let (row, column) = (low.y as i64 + down, low.x as i64 + right);
            let share = (if down == 1 { part.y } else { 1.0 - part.y })
                * (if right == 1 { part.x } else { 1.0 - part.x });
            let rows = 0..self.height() as i64;
            if !rows.contains(&row) || !(0..self.width as i64).contains(&column) {
                continue;
            }
            let height_m = self.heights_m[row as usize * self.width + column as usize];
            if !height_m.is_nan() {
                sum += share * height_m;
                weight += share;
            }
        }
        (sum, weight)
    }
}

fn bumpy_m(seed: u32, relief_m: f64, voids: bool, row: usize, column: usize) -> f64 {
    let word = |seed: u32| {
        let mixed =
            (row as u32).wrapping_mul(0x9E37_79B1) ^ (column as u32).wrapping_mul(0x85EB_CA77);
        let mixed = (mixed ^ seed.wrapping_mul(0xC2B2_AE3D)).wrapping_mul(0x27D4_EB2F);
        (mixed ^ (mixed >> 15)).wrapping_mul(0x2C1B_3C6D) >> 8
    };
    if voids && word(seed ^ 77).is_multiple_of(9) {
        return f64::NAN;
    }
    relief_m * f64::from(word(seed)) / f64::from(1 << 24)
}

/// A number in 0..1 from a seed.
fn unit(seed: u32) -> f64 {
    bumpy_m(seed, 1.0, false, 1, 2)
}

fn down() -> DVec3 {
    -DVec3::Z
}
