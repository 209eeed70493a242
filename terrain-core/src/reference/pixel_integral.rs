//! The mean colour of a pixel's square, taken from as many rays as it needs.

use glam::Vec3;

use crate::srgb::srgb_from_linear;

/// When a pixel has had enough rays.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tolerance {
    /// The estimated error in 8-bit steps of the encoded colour that is good enough.
    pub steps: f64,
    /// Fewest rays of a pixel: a power of two, at least 4.
    pub fewest_rays: u32,
    /// Most rays of a pixel.
    pub most_rays: u32,
}

/// The mean of `colour` (linear light at a place in the unit square, of a ray that stands for a part
/// of it with this side) over the square.
///
/// The places are the first 2^k points of Sobol's sequence (I. M. Sobol', "On the distribution of
/// points in a cube and the approximate evaluation of integrals", 1967) moved by half their least
/// distance, so that every cut of the square into 2^k equal boxes has one in each and their mean is
/// the centre. The error of such points falls with the 3/4th power of their number where an edge runs
/// through. So it is estimated twice: by the spread of the colours, and by the difference from the
/// mean of fewer rays, each divided by that power of its numbers. While one of the two is above the
/// tolerance, as many rays are taken as the spread asks for, at least twice as many as before.
pub(super) fn mean_colour(
    tolerance: Tolerance,
    mut colour: impl FnMut([f64; 2], f64) -> Vec3,
) -> Vec3 {
    let mut rays = tolerance.fewest_rays;
    let mut before: Option<(Vec3, u32)> = None;
    loop {
        let (mean, spread) = mean_and_spread(rays, &mut colour);
        let by_spread = spread * (rays as f32).powf(-0.75);
        let error = before.map_or(by_spread, |(coarse, fewer)| {
            by_spread.max((mean - coarse).abs() * (fewer as f32 / rays as f32).powf(0.75))
        });
        let excess = steps_of(error, mean) / tolerance.steps;
        if excess <= 1.0 || rays * 2 > tolerance.most_rays {
            return mean;
        }
        before = Some((mean, rays));
        let wanted =
            f64::from(rays) * (steps_of(by_spread, mean) / tolerance.steps).powf(4.0 / 3.0);
        while rays * 2 <= tolerance.most_rays {
            rays *= 2;
            if f64::from(rays) >= wanted {
                break;
            }
        }
    }
}

/// The mean of so many rays, and the standard deviation of their colours.
fn mean_and_spread(rays: u32, colour: &mut impl FnMut([f64; 2], f64) -> Vec3) -> (Vec3, Vec3) {
    let side = 1.0 / f64::from(rays).sqrt();
    let (mut sum, mut squares) = (Vec3::ZERO, Vec3::ZERO);
    for index in 0..rays {
        let seen = colour(place(index, rays), side);
        sum += seen;
        squares += seen * seen;
    }
    let mean = sum / rays as f32;
    let variance = (squares / rays as f32 - mean * mean).max(Vec3::ZERO);
    (mean, variance.map(f32::sqrt))
}

/// Point `index` of `count` (a power of two): see [`mean_colour`].
fn place(index: u32, count: u32) -> [f64; 2] {
    // The first two of Sobol's dimensions: van der Corput's, and Pascal's triangle modulo 2.
    let mut second = 0_u32;
    let mut column = 1_u32 << 31;
    let mut bits = index;
    while bits != 0 {
        if bits & 1 != 0 {
            second ^= column;
        }
        bits >>= 1;
        column ^= column >> 1;
    }
    let unit = 1.0 / f64::from(1_u32 << 16).powi(2);
    let half = 0.5 / f64::from(count);
    [index.reverse_bits(), second].map(|bits| f64::from(bits) * unit + half)
}

/// The largest of three small differences of linear light around `mean` in 8-bit steps of sRGB.
fn steps_of(difference: Vec3, mean: Vec3) -> f64 {
    let steps = |difference: f32, mean: f32| {
        let [low, high] = [mean - 0.5 * difference, mean + 0.5 * difference]
            .map(|light| srgb_from_linear(f64::from(light).clamp(0.0, 1.0)));
        255.0 * (high - low)
    };
    steps(difference.x, mean.x).max(steps(difference.y, mean.y)).max(steps(difference.z, mean.z))
}

/// The 8-bit sRGB codes of linear light.
pub(super) fn srgb_code(colour: Vec3) -> [u8; 3] {
    colour
        .to_array()
        .map(|light| (255.0 * srgb_from_linear(f64::from(light).clamp(0.0, 1.0))).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_box_of_every_cut_holds_one_place() {
        for power in [2_u32, 3, 5, 8] {
            let count = 1 << power;
            let places: Vec<_> = (0..count).map(|index| place(index, count)).collect();
            for columns_power in 0..=power {
                let (columns, rows) = (1_u32 << columns_power, 1_u32 << (power - columns_power));
                let mut boxes: Vec<u32> = places
                    .iter()
                    .map(|[x, y]| {
                        let row = (y * f64::from(rows)) as u32;
                        row * columns + (x * f64::from(columns)) as u32
                    })
                    .collect();
                boxes.sort_unstable();
                assert_eq!(boxes, (0..count).collect::<Vec<_>>(), "{columns} x {rows}");
            }
            let mean: f64 = places.iter().map(|[x, _]| x).sum::<f64>() / f64::from(count);
            assert!((mean - 0.5).abs() < 1e-12, "{count}: {mean}");
        }
    }

    #[test]
    fn one_colour_takes_the_fewest_rays_and_an_edge_gets_its_share() {
        let tolerance = Tolerance { steps: 0.5, fewest_rays: 4, most_rays: 4096 };
        let mut rays = 0;
        let grey = mean_colour(tolerance, |_, _| {
            rays += 1;
            Vec3::splat(0.25)
        });
        assert_eq!((grey, rays), (Vec3::splat(0.25), 4));
        // An edge at a slant: the share to its left is known. Few rays might all miss a small one.
        let tolerance = Tolerance { fewest_rays: 32, ..tolerance };
        for (offset, share) in [(0.37, 0.37), (0.05, 0.05), (0.9, 0.9)] {
            let found = mean_colour(tolerance, |[x, y], _| {
                Vec3::splat(if x + 0.1 * (y - 0.5) < offset { 1.0 } else { 0.0 })
            });
            let difference = (srgb_from_linear(f64::from(found.x)) - srgb_from_linear(share)).abs();
            assert!(255.0 * difference < 1.0, "{offset}: {found}");
        }
    }
}
