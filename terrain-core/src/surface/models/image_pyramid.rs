use rayon::prelude::*;

use super::model::{ModelImage, WrapMode};
use crate::srgb::{LINEAR_FROM_CODE, srgb_from_linear};

/// An image and its halvings down to one texel, each texel the mean light of the four it stands for, weighed by what
/// they cover.
#[derive(Clone, Debug)]
pub(super) struct ImagePyramid {
    /// The image first; each further level half as large, rounded up.
    levels: Vec<ModelImage>,
}

impl ImagePyramid {
    pub fn new(image: ModelImage) -> Self {
        let mut levels = vec![image];
        while let Some(last) = levels.last().filter(|last| last.size_texels != [1, 1]) {
            let next = halved(last);
            levels.push(next);
        }
        Self { levels }
    }

    /// The image itself.
    pub fn image(&self) -> &ModelImage {
        &self.levels[0]
    }

    /// The texel of a level at a place that may lie beyond the image's borders. Levels beyond the last are like it.
    pub fn texel(&self, level: usize, place: [i64; 2], wrap: [WrapMode; 2]) -> [u8; 4] {
        let image = &self.levels[level.min(self.levels.len() - 1)];
        let [width, height] = image.size_texels;
        let (x, y) = (wrap[0].texel(place[0], width), wrap[1].texel(place[1], height));
        texel(image, x, y)
    }

    /// The mean light of the whole image, linear, and its mean coverage.
    pub fn mean(&self) -> [f32; 4] {
        let [red, green, blue, alpha] = texel(&self.levels[self.levels.len() - 1], 0, 0);
        let linear = |code: u8| LINEAR_FROM_CODE[usize::from(code)];
        [linear(red), linear(green), linear(blue), f32::from(alpha) / 255.0]
    }
}

fn texel(image: &ModelImage, x: u32, y: u32) -> [u8; 4] {
    let index = 4 * (y as usize * image.size_texels[0] as usize + x as usize);
    image.rgba[index..].first_chunk().copied().unwrap_or_default()
}

fn halved(image: &ModelImage) -> ModelImage {
    let [width, height] = image.size_texels;
    let size_texels = [width.div_ceil(2), height.div_ceil(2)];
    let mut rgba = vec![0; 4 * size_texels[0] as usize * size_texels[1] as usize];
    let rows = rgba.par_chunks_exact_mut(4 * size_texels[0] as usize);
    rows.enumerate().for_each(|(row, out)| {
        for (column, out) in out.as_chunks_mut::<4>().0.iter_mut().enumerate() {
            let [x, y] = [2 * column as u32, 2 * row as u32];
            let [right, below] = [(x + 1).min(width - 1), (y + 1).min(height - 1)];
            *out = mean(
                [(x, y), (right, y), (x, below), (right, below)].map(|(x, y)| texel(image, x, y)),
            );
        }
    });
    ModelImage { size_texels, rgba: rgba.into() }
}

/// The mean of four texels: light weighed by coverage, so that what is not covered gives no colour.
fn mean(texels: [[u8; 4]; 4]) -> [u8; 4] {
    if texels.iter().all(|texel| *texel == texels[0]) {
        return texels[0];
    }
    let coverage: f32 = texels.iter().map(|texel| f32::from(texel[3])).sum();
    let weight = |texel: &[u8; 4]| match coverage > 0.0 {
        true => f32::from(texel[3]) / coverage,
        false => 0.25,
    };
    let light = |channel: usize| {
        let linear = |texel: &[u8; 4]| LINEAR_FROM_CODE[usize::from(texel[channel])];
        let sum: f32 = texels.iter().map(|texel| linear(texel) * weight(texel)).sum();
        (255.0 * srgb_from_linear(f64::from(sum))).round() as u8
    };
    [light(0), light(1), light(2), (0.25 * coverage).round() as u8]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halving_keeps_light_and_counts_only_what_is_covered() {
        let black_and_white = [[0, 0, 0, 255], [255; 4], [0, 0, 0, 255], [255; 4]];
        // Half the light is code 188, not 128.
        assert_eq!(mean(black_and_white), [188, 188, 188, 255]);
        let leaf = [[10, 200, 30, 255], [255, 0, 255, 0], [10, 200, 30, 255], [255, 0, 255, 0]];
        assert_eq!(mean(leaf), [10, 200, 30, 128]);
    }

    #[test]
    fn places_beyond_the_borders_are_wrapped_at_every_level() {
        let rgba = (0..5 * 3_u8).flat_map(|index| [index, index, index, 255]).collect();
        let pyramid = ImagePyramid::new(ModelImage { size_texels: [5, 3], rgba });
        let sizes = pyramid.levels.iter().map(|level| level.size_texels);
        assert_eq!(sizes.collect::<Vec<_>>(), [[5, 3], [3, 2], [2, 1], [1, 1]]);
        let at = |x, y, mode| pyramid.texel(0, [x, y], [mode; 2])[0];
        assert_eq!(at(-1, 4, WrapMode::Repeat), 5 + 4);
        assert_eq!(at(-1, 4, WrapMode::Clamp), 10);
        assert_eq!(at(-1, 4, WrapMode::Mirror), 5);
        assert_eq!(at(6, 0, WrapMode::Mirror), 3);
        assert_eq!(
            pyramid.texel(9, [7, -7], [WrapMode::Mirror; 2]),
            pyramid.texel(3, [0, 0], [WrapMode::Clamp; 2])
        );
    }
}
