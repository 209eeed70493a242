//! How many bits the dot products behind a texture coordinate need, against distance.
//!
//! Level ground at height 1 below the eye; a ray meets it at an angle `theta` from the vertical. Its
//! direction `V` gives `N.V = cos(theta)` with the ground's normal and `U.V = sin(theta)` with the
//! direction of a texture axis; the coordinate under the pixel is their quotient. The derivation is
//! written out in `docs/precision.md`. After the paper on texturing in tiled rendering, "The special
//! features of texturing in tile visualization technology", whose formulas (7) and (15) keep their
//! numbers here.
//!
//! Bits are those of a fixed-point number with one bit before its point (for the sign, or for the
//! value 1): `b` bits have a step of `2^(1 - b)` and an error of at most `2^-b`.

mod brute_force;
mod native_formats;

pub use brute_force::{MeasuredBits, PHASES, measured_bits, measured_component_bits, quantised};
pub use native_formats::{NativeError, predicted_native_error, worst_native_error};

use serde::Serialize;

/// Half the angle of a pixel in radians, for which the three figures are drawn: 2^-2, 2^-5, 2^-11.
pub const STUDIED_HALF_PIXELS_RAD: [f64; 3] = [0.25, 1.0 / 32.0, 1.0 / 2048.0];

/// Part of a texel that a texture coordinate may be off.
pub const TEXEL_PART: f64 = 1.0 / 16.0;

/// Levels of detail that the level under a pixel may be off: the width of the bounds (7).
pub const LOD_TOLERANCE: f64 = 0.5;

/// A pixel and the level ground under it. Lengths are in heights of the eye above the ground.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SpanView {
    /// Normalised horizontal range: ground distance over height, the tangent of the angle between
    /// the ray and the vertical. Not negative.
    pub range: f64,
    /// Half the angle of a pixel in radians; positive.
    pub half_pixel_rad: f64,
}

impl SpanView {
    /// `N.V`: the cosine of the angle between the ray and the vertical.
    pub fn normal_dot(&self) -> f64 {
        1.0 / self.slant()
    }

    /// `U.V`: the sine of that angle.
    pub fn axis_dot(&self) -> f64 {
        self.range / self.slant()
    }

    /// Distance to the ground along the ray.
    fn slant(&self) -> f64 {
        (1.0 + self.range * self.range).sqrt()
    }

    /// The pixel's footprint across the direction of view, its smaller extreme: `2 phi / cos(theta)`.
    #[cfg(test)]
    pub fn footprint_across(&self) -> f64 {
        2.0 * self.half_pixel_rad * self.slant()
    }

    /// The footprint along the direction of view, its larger extreme: `2 phi / cos^2(theta)`.
    pub fn footprint_along(&self) -> f64 {
        2.0 * self.half_pixel_rad * (1.0 + self.range * self.range)
    }

    /// Bounds of the level of detail where a texel of level 0 is `texel` heights wide: formula (7).
    /// The lower bound is that of a pixel whose sides lie along the direction of view, the upper that
    /// of one turned by 45 degrees.
    #[cfg(test)]
    pub fn lod_bounds(&self, texel: f64) -> [f64; 2] {
        let level = (self.footprint_along() / texel).log2();
        [level, level + LOD_TOLERANCE]
    }

    /// Leading bits of `N.V` that say nothing, the one before the point counted: formula (15).
    pub fn leading_zeros(&self) -> f64 {
        1.0 + 0.5 * (1.0 + self.range * self.range).log2()
    }

    /// Bits after the leading zeros that keep the ground under the ray within half a footprint and
    /// the level of detail within [`LOD_TOLERANCE`].
    pub fn significant_bits(&self) -> f64 {
        let (c, s, phi) = (self.normal_dot(), self.axis_dot(), self.half_pixel_rad);
        let place = (1.0 + s * c / phi).log2() - 1.0;
        place.max(lod_bits())
    }

    /// Bits that `N.V` needs in all: leading zeros and significant bits.
    pub fn normal_dot_bits(&self) -> f64 {
        self.leading_zeros() + self.significant_bits()
    }

    /// Bits that both dot products need so that the texture coordinate, in texels as wide as the
    /// footprint is long, is within `texel_part` of a texel.
    pub fn texture_bits(&self, texel_part: f64) -> f64 {
        let (c, s) = (self.normal_dot(), self.axis_dot());
        ((s + c) / (2.0 * texel_part * self.half_pixel_rad) + 1.0 / c).log2()
    }

    /// Bits with which `N.V` alone tells apart two rays half a pixel (`phi`) apart in height: the
    /// literal reading of the paper. No rendering needs them; see the derivation.
    pub fn direction_bits(&self) -> f64 {
        let theta = self.range.atan();
        let half = 0.5 * self.half_pixel_rad;
        // cos(theta) - cos(theta + phi), without its cancellation.
        1.0 - (2.0 * (theta + half).sin() * half.sin()).log2()
    }
}

/// Significant bits of `N.V` that the level of detail asks for by itself. It goes with `-2 log2(N.V)`.
fn lod_bits() -> f64 {
    let least_ratio = (-0.5 * LOD_TOLERANCE).exp2();
    -(1.0 - least_ratio).log2() - 1.0
}

/// The range of the last whole pixel below the horizon.
pub fn horizon_range(half_pixel_rad: f64) -> f64 {
    1.0 / half_pixel_rad.tan()
}

/// Ranges from 1/64 to the horizon, `per_octave` to each doubling, ends included.
pub fn studied_ranges(half_pixel_rad: f64, per_octave: u32) -> Vec<f64> {
    let (low, high) = (1.0_f64 / 64.0, horizon_range(half_pixel_rad));
    let octaves = (high / low).log2();
    let steps = (octaves * f64::from(per_octave)).ceil() as u32;
    let part = |step: u32| f64::from(step) / f64::from(steps);
    (0..=steps).map(|step| low * (octaves * part(step)).exp2()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The ground hit by a ray `theta` from the vertical and `across` to the side of the plane of view.
    fn ground(theta: f64, across: f64) -> [f64; 2] {
        let slant = 1.0 / theta.cos();
        [theta.tan(), slant * across.tan()]
    }

    #[test]
    fn footprints_are_what_rays_through_the_pixels_sides_span() {
        for range in [0.0, 0.3, 1.0, 7.0, 60.0] {
            let view = SpanView { range, half_pixel_rad: 1.0e-6 };
            let theta = range.atan();
            let phi = view.half_pixel_rad;
            let along = ground(theta + phi, 0.0)[0] - ground(theta - phi, 0.0)[0];
            let across = ground(theta, phi)[1] - ground(theta, -phi)[1];
            assert!((along / view.footprint_along() - 1.0).abs() < 1e-4, "{range} {along}");
            assert!((across / view.footprint_across() - 1.0).abs() < 1e-4, "{range} {across}");
        }
    }

    #[test]
    fn a_turned_pixel_stays_within_the_bounds_of_the_level() {
        let phi = 1.0e-6;
        for range in [0.0, 0.5, 3.0, 40.0] {
            let view = SpanView { range, half_pixel_rad: phi };
            let [low, high] = view.lod_bounds(1.0);
            let levels = (0..=16).map(|step| {
                let turn = f64::from(step) * std::f64::consts::FRAC_PI_2 / 16.0;
                let corners = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)].map(|(a, b)| {
                    let up = phi * (a * turn.cos() - b * turn.sin());
                    ground(range.atan() + up, 0.0)[0]
                });
                let length = corners.iter().fold(f64::MIN, |m, c| m.max(*c))
                    - corners.iter().fold(f64::MAX, |m, c| m.min(*c));
                length.log2()
            });
            let levels = levels.collect::<Vec<_>>();
            let inside = |level: &f64| (low - 1e-4..high + 1e-4).contains(level);
            assert!(levels.iter().all(inside), "{range}: {levels:?} in {low}..{high}");
            let largest = levels.iter().fold(f64::MIN, |m, l| m.max(*l));
            assert!((largest - high).abs() < 1e-3, "the upper bound is reached: {largest} {high}");
        }
    }

    #[test]
    fn the_leading_zeros_are_those_of_the_number_written_out() {
        for range in [0.1, 0.9, 2.0, 11.0, 500.0] {
            let view = SpanView { range, half_pixel_rad: 0.01 };
            // 40 bits after the point: leading zeros of the integer less those of 41 bits' width.
            let written = (view.normal_dot() * 40.0_f64.exp2()).floor() as u64;
            let zeros = written.leading_zeros() - (u64::BITS - 41);
            assert_eq!(
                f64::from(zeros),
                view.leading_zeros().ceil() - 1.0 + whole(&view),
                "{range}"
            );
        }
    }

    /// 1 where N.V is just a power of two, else 0.
    fn whole(view: &SpanView) -> f64 {
        f64::from(u32::from(view.leading_zeros().fract() == 0.0))
    }

    #[test]
    fn far_away_only_the_level_of_detail_counts() {
        let far = SpanView { range: horizon_range(1.0 / 2048.0), half_pixel_rad: 1.0 / 2048.0 };
        assert_eq!(far.significant_bits(), lod_bits());
        let near = SpanView { range: 1.0, ..far };
        assert!(near.significant_bits() > lod_bits());
        assert!((near.normal_dot_bits() - 11.0).abs() < 1.0, "about as fine as the pixel");
    }

    #[test]
    fn ranges_reach_from_below_the_eye_to_the_horizon() {
        let ranges = studied_ranges(0.25, 4);
        assert_eq!(ranges[0], 1.0 / 64.0);
        let last = *ranges.last().unwrap();
        assert!((last - 0.25_f64.tan().recip()).abs() < 1e-12);
        assert!(ranges.windows(2).all(|pair| pair[1] / pair[0] <= 0.2501_f64.exp2()));
    }
}
