use glam::{DVec2, DVec3, Vec3, Vec4};

use super::colour_codes::linear_from_code;
use super::footprint::SurfaceTexture;
use crate::prepare::{LinearColour, Texel};

/// A picture draped over the ground from above, with its mip levels: the texture that colours are
/// integrated from, and what the usual filters read at run time.
///
/// Texels are areas, sRGB with coverage; coarser levels are averaged in linear light. Beyond the
/// picture its border continues.
#[derive(Clone, Debug, PartialEq)]
pub struct MipTexture {
    origin: DVec2,
    texel_m: f64,
    levels: Vec<MipLevel>,
}

#[derive(Clone, Debug, PartialEq)]
struct MipLevel {
    size: [usize; 2],
    texels: Vec<[u8; 4]>,
}

/// A filtered colour and what it took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filtered {
    /// Linear light multiplied by coverage, and the coverage.
    pub premultiplied: Vec4,
    /// Texels read.
    pub texels: u32,
    /// Separate places in memory: pairs of neighbouring texels of a row.
    pub places: u32,
}

impl Filtered {
    /// Linear light; `bare` where there is no coverage.
    pub fn over(&self, bare: Vec3) -> Vec3 {
        let coverage = self.premultiplied.w;
        if coverage > 0.0 { self.premultiplied.truncate() / coverage } else { bare }
    }
}

impl MipTexture {
    /// Of a picture's texels, row by row from the north-western corner at `origin`: sRGB and coverage,
    /// `size` columns and rows, at least one of each and as many texels.
    pub fn new(origin: DVec2, texel_m: f64, size: [usize; 2], texels: Vec<[u8; 4]>) -> Self {
        let mut linear: Vec<LinearColour> =
            texels.iter().map(|&texel| LinearColour::of_srgb(texel)).collect();
        let mut levels = vec![MipLevel { size, texels }];
        let [mut width, mut height] = size;
        while width > 1 || height > 1 {
            linear = halved(&linear, [width, height]);
            (width, height) = (width.div_ceil(2), height.div_ceil(2));
            let texels = linear.iter().map(|texel| texel.to_srgb()).collect();
            levels.push(MipLevel { size: [width, height], texels });
        }
        Self { origin, texel_m, levels }
    }

    /// North-western corner, metres.
    pub fn origin(&self) -> DVec2 {
        self.origin
    }

    /// Side of a texel of the finest level, metres.
    pub fn texel_m(&self) -> f64 {
        self.texel_m
    }

    /// How many levels there are.
    pub fn level_count(&self) -> usize {
        self.levels.len()
    }

    /// Columns and rows of a level, and its texels (sRGB and coverage) row by row.
    pub fn level(&self, level: usize) -> ([usize; 2], &[[u8; 4]]) {
        let level = &self.levels[level.min(self.levels.len() - 1)];
        (level.size, &level.texels)
    }

    /// Bytes in memory.
    pub fn byte_len(&self) -> u64 {
        self.levels.iter().map(|level| 4 * level.texels.len() as u64).sum()
    }

    /// Bilinear between the four texels of a level around a point; premultiplied linear light.
    pub fn bilinear(&self, level: usize, point: DVec2) -> Vec4 {
        let found = &self.levels[level];
        let texel_m = self.texel_m * (level as f64).exp2();
        let place = DVec2::new(point.x - self.origin.x, self.origin.y - point.y) / texel_m - 0.5;
        let low = place.floor();
        let part = (place - low).as_vec2();
        let at = |right: i64, down: i64| found.texel(low.x as i64 + right, low.y as i64 + down);
        let north = at(0, 0).lerp(at(1, 0), part.x);
        let south = at(0, 1).lerp(at(1, 1), part.x);
        north.lerp(south, part.y)
    }

    /// The classic filter: bilinear in the two levels whose texels are next to the footprint's larger
    /// side in metres, and linear between them (Williams, "Pyramidal Parametrics", 1983).
    pub fn trilinear(&self, point: DVec2, footprint_m: f64) -> Filtered {
        let top = (self.levels.len() - 1) as f64;
        let lod = (footprint_m / self.texel_m).log2().clamp(0.0, top);
        let level = lod as usize;
        let part = (lod - level as f64) as f32;
        let near = self.bilinear(level, point);
        if part == 0.0 {
            return Filtered { premultiplied: near, texels: 4, places: 2 };
        }
        let far = self.bilinear(level + 1, point);
        Filtered { premultiplied: near.lerp(far, part), texels: 8, places: 4 }
    }

    /// Anisotropic filter: the footprint, a parallelogram given by its two sides in metres, is cut
    /// into at most `most_taps` equal parts, two across its shorter side and as many along the longer
    /// as keep them square, each sampled bilinearly from the level whose texels are no larger than the
    /// part.
    pub fn anisotropic(&self, point: DVec2, sides: [DVec2; 2], most_taps: u32) -> Filtered {
        let [long, short] = match sides[0].length() >= sides[1].length() {
            true => sides,
            false => [sides[1], sides[0]],
        };
        let across = most_taps.clamp(1, 2);
        let ratio = long.length() / short.length().max(f64::MIN_POSITIVE);
        let wanted = (f64::from(across) * ratio).ceil();
        let along = wanted.clamp(1.0, f64::from((most_taps / across).max(1))) as u32;
        let part_m = (long.length() / f64::from(along)).max(short.length() / f64::from(across));
        let top = (self.levels.len() - 1) as f64;
        let level = (part_m / self.texel_m).log2().floor().clamp(0.0, top) as usize;
        let middle = |index: u32, count: u32| (f64::from(index) + 0.5) / f64::from(count) - 0.5;
        let mut sum = Vec4::ZERO;
        for (i, j) in (0..along).flat_map(|i| (0..across).map(move |j| (i, j))) {
            sum +=
                self.bilinear(level, point + long * middle(i, along) + short * middle(j, across));
        }
        let taps = along * across;
        Filtered { premultiplied: sum / taps as f32, texels: 4 * taps, places: 2 * taps }
    }
}

impl MipLevel {
    /// A texel in premultiplied linear light; the border continues.
    fn texel(&self, column: i64, row: i64) -> Vec4 {
        let column = column.clamp(0, self.size[0] as i64 - 1) as usize;
        let row = row.clamp(0, self.size[1] as i64 - 1) as usize;
        let [red, green, blue, coverage] = self.texels[row * self.size[0] + column];
        let linear = Vec3::from_array([red, green, blue].map(linear_from_code));
        let coverage = f32::from(coverage) / 255.0;
        (linear * coverage).extend(coverage)
    }
}

/// The texture draped over the surface by vertical projection. Samples come from the level whose
/// texels are no larger than what a sample stands for, so that none is passed over.
impl SurfaceTexture for &MipTexture {
    fn colour(&self, point: DVec3, sample_size_m: f64) -> Vec4 {
        let top = (self.levels.len() - 1) as f64;
        let level = (sample_size_m / self.texel_m).log2().floor().clamp(0.0, top);
        self.bilinear(level as usize, point.truncate())
    }
}

/// The next coarser level; an odd last row or column is averaged with itself.
fn halved(texels: &[LinearColour], [width, height]: [usize; 2]) -> Vec<LinearColour> {
    let at =
        |column: usize, row: usize| texels[row.min(height - 1) * width + column.min(width - 1)];
    let (columns, rows) = (width.div_ceil(2), height.div_ceil(2));
    let average = |index: usize| {
        let (column, row) = (2 * (index % columns), 2 * (index / columns));
        LinearColour::average([
            at(column, row),
            at(column + 1, row),
            at(column, row + 1),
            at(column + 1, row + 1),
        ])
    };
    (0..columns * rows).map(average).collect()
}

#[cfg(test)]
mod tests {
    use glam::dvec2;

    use super::super::footprint::{ConvergedQuadrature, FlatRelief, Footprint, FootprintIntegral};
    use super::*;

    fn noise(size: usize) -> MipTexture {
        let texel = |index: usize| {
            let word = (index as u32).wrapping_mul(2_654_435_761) >> 8;
            [word as u8, (word >> 8) as u8, (word >> 16) as u8 / 4, 255]
        };
        MipTexture::new(
            dvec2(100.0, 900.0),
            2.0,
            [size, size],
            (0..size * size).map(texel).collect(),
        )
    }

    #[test]
    fn at_a_texels_middle_is_its_colour() {
        let texture = noise(16);
        let (size, texels) = texture.level(0);
        for (column, row) in [(0, 0), (3, 7), (15, 15)] {
            let point = dvec2(101.0 + 2.0 * column as f64, 899.0 - 2.0 * row as f64);
            let [red, green, blue, _] = texels[row * size[0] + column];
            let linear = [red, green, blue].map(linear_from_code);
            let found = texture.trilinear(point, 1.0);
            assert!((found.over(Vec3::ZERO) - Vec3::from_array(linear)).length() < 1e-6);
            assert_eq!(found.texels, 4);
        }
    }

    #[test]
    fn every_level_has_the_mean_of_the_picture() {
        let texture = noise(32);
        let mean = |level: usize| {
            let (_, texels) = texture.level(level);
            let sum: f32 = texels.iter().map(|texel| linear_from_code(texel[0])).sum();
            sum / texels.len() as f32
        };
        for level in 0..texture.level_count() {
            // The one texel of the last level is rounded to a code, up to 0.004 apart here.
            assert!((mean(level) - mean(0)).abs() < 4.0e-3, "{level}");
        }
        assert_eq!(texture.level_count(), 6);
    }

    #[test]
    fn taps_cover_the_longer_side_and_are_counted() {
        let texture = noise(64);
        let middle = dvec2(164.0, 836.0);
        let count = |sides, most| texture.anisotropic(middle, sides, most).texels / 4;
        assert_eq!(count([dvec2(4.0, 0.0), dvec2(0.0, 4.0)], 16), 4);
        assert_eq!(count([dvec2(0.0, 12.0), dvec2(4.0, 0.0)], 16), 12);
        assert_eq!(count([dvec2(40.0, 0.0), dvec2(0.0, 4.0)], 16), 16);
        assert_eq!(count([dvec2(40.0, 0.0), dvec2(0.0, 4.0)], 1), 1);
        assert_eq!(texture.trilinear(middle, 9.0).texels, 8);
    }

    /// Every texel by itself, none averaged: what prefiltering may not change much.
    struct Finest<'a>(&'a MipTexture);

    impl SurfaceTexture for Finest<'_> {
        fn colour(&self, point: DVec3, _: f64) -> Vec4 {
            self.0.bilinear(0, point.truncate())
        }
    }

    #[test]
    fn prefiltered_samples_integrate_as_unfiltered_ones_do() {
        let texture = noise(128);
        let mut worst = 0.0_f32;
        for index in 0..60 {
            let centre = dvec2(170.0 + f64::from(index), 830.0 - 0.7 * f64::from(index));
            let footprint = Footprint {
                centre: centre.extend(0.0),
                normal: DVec3::Z,
                distance_m: 100.0 * (1.0 + f64::from(index % 7)),
                apex_angle_rad: 0.03,
            };
            let tolerance = 0.002;
            let bare_colour = Vec3::ZERO;
            let quick = ConvergedQuadrature {
                texture: &texture,
                relief: FlatRelief,
                tolerance,
                bare_colour,
            };
            let exact = brute_force_mean(&Finest(&texture), &footprint);
            worst = worst.max((quick.mean_colour(&footprint) - exact).abs().max_element());
        }
        println!("prefiltered against unfiltered: {worst:.4}");
        assert!(worst < 0.03, "{worst}");
    }

    /// The mean over a square lattice of points within the circle.
    fn brute_force_mean(texture: &dyn SurfaceTexture, footprint: &Footprint) -> Vec3 {
        let side = 120;
        let at = |i: i32| (f64::from(i) + 0.5) / f64::from(side) * 2.0 - 1.0;
        let lattice = (0..side * side).map(|i| dvec2(at(i % side), at(i / side)));
        let places = lattice.filter(|place| place.length() < 1.0);
        let points = footprint.on_tangent_plane(places);
        let sum: Vec4 = points.map(|point| texture.colour(point, 0.0)).sum();
        sum.truncate() / sum.w
    }
}
