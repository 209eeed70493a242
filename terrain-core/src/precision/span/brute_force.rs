//! The same bits found by trying: quantise, recompute, compare with f64.

use serde::Serialize;

use super::{LOD_TOLERANCE, SpanView};

/// Grid phases tried for each number of bits. Within a span `N.V` is a corner's value plus whole
/// steps, so its grid may lie anywhere against the true value.
pub const PHASES: u32 = 16;

/// No number of bits beyond this is tried.
const MOST_BITS: u32 = 48;

/// Fewest bits that hold every bound at every phase.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct MeasuredBits {
    /// Bits of `N.V`; see [`SpanView::normal_dot_bits`].
    pub normal_dot: u32,
    /// Bits of both dot products; see [`SpanView::texture_bits`].
    pub texture: u32,
}

/// A value rounded to fixed point of `bits` bits, its grid shifted by `phase` of a step.
pub fn quantised(value: f64, bits: u32, phase: f64) -> f64 {
    let step = (1.0 - f64::from(bits)).exp2();
    ((value / step + phase).round() - phase) * step
}

/// Finds the bits by trying all of them, from one upward.
pub fn measured_bits(view: &SpanView, texel_part: f64) -> MeasuredBits {
    MeasuredBits {
        normal_dot: fewest(|bits| phases().all(|phase| holds_normal(view, bits, phase))),
        texture: fewest(|bits| {
            let pairs = phases().flat_map(|first| phases().map(move |second| (first, second)));
            pairs.into_iter().all(|pair| holds_texture(view, bits, pair, texel_part))
        }),
    }
}

fn fewest(holds: impl Fn(u32) -> bool) -> u32 {
    (1..MOST_BITS).find(|bits| holds(*bits)).unwrap_or(MOST_BITS)
}

fn phases() -> impl Iterator<Item = f64> {
    (0..PHASES).map(|phase| f64::from(phase) / f64::from(PHASES))
}

/// Whether the rounded `N.V` keeps the ground's place within half a footprint and the level.
fn holds_normal(view: &SpanView, bits: u32, phase: f64) -> bool {
    let rounded = quantised(view.normal_dot(), bits, phase);
    rounded > 0.0 && holds_rounded_normal(view, rounded)
}

fn holds_rounded_normal(view: &SpanView, rounded: f64) -> bool {
    let moved = (view.axis_dot() / rounded - view.range).abs();
    let level = 2.0 * (view.normal_dot() / rounded).log2().abs();
    moved <= 0.5 * view.footprint_along() && level <= LOD_TOLERANCE
}

/// Whether both rounded dot products keep the coordinate within its part of a texel.
fn holds_texture(view: &SpanView, bits: u32, phases: (f64, f64), texel_part: f64) -> bool {
    let normal = quantised(view.normal_dot(), bits, phases.0);
    let axis = quantised(view.axis_dot(), bits, phases.1);
    normal > 0.0 && (axis / normal - view.range).abs() <= texel_part * view.footprint_along()
}

/// Bits of `N.V` where not the dot product is rounded but each component of `N` and `V`, the plane and
/// the ray turned every way: what a span renderer that rounds its vectors first needs.
pub fn measured_component_bits(view: &SpanView) -> u32 {
    fewest(|bits| (0..256).all(|turn| holds_components(view, bits, turn)))
}

fn holds_components(view: &SpanView, bits: u32, turn: u32) -> bool {
    let turned = rotation(turn);
    let round = |v: glam::DVec3| glam::DVec3::from(v.to_array().map(|c| quantised(c, bits, 0.0)));
    let normal = round(turned * glam::DVec3::Z);
    let ray = round(turned * glam::dvec3(view.axis_dot(), 0.0, view.normal_dot()));
    let rounded = normal.dot(ray);
    rounded > 0.0 && holds_rounded_normal(view, rounded)
}

/// One of a sequence of rotations that leave no direction out: golden-ratio steps of three angles.
fn rotation(turn: u32) -> glam::DMat3 {
    let angle = |rate: f64| (f64::from(turn) * rate).fract() * std::f64::consts::TAU;
    let (first, second, third) = (angle(0.618_034), angle(0.754_878), angle(0.569_840));
    glam::DMat3::from_rotation_z(first)
        * glam::DMat3::from_rotation_x(second)
        * glam::DMat3::from_rotation_y(third)
}

#[cfg(test)]
mod tests {
    use super::super::{STUDIED_HALF_PIXELS_RAD, TEXEL_PART, studied_ranges};
    use super::*;

    #[test]
    fn rounding_is_to_the_nearest_of_the_shifted_grid() {
        assert_eq!(quantised(0.30, 3, 0.0), 0.25);
        assert_eq!(quantised(0.30, 3, 0.5), 0.375);
        assert_eq!(quantised(0.9999, 1, 0.0), 1.0);
    }

    #[test]
    fn predicted_and_tried_bits_are_within_one_of_each_other_from_below_the_eye_to_the_horizon() {
        for half_pixel_rad in STUDIED_HALF_PIXELS_RAD {
            for range in studied_ranges(half_pixel_rad, 4) {
                let view = SpanView { range, half_pixel_rad };
                let tried = measured_bits(&view, TEXEL_PART);
                let apart = [
                    f64::from(tried.normal_dot) - view.normal_dot_bits(),
                    f64::from(tried.texture) - view.texture_bits(TEXEL_PART),
                ];
                assert!(apart.iter().all(|bits| bits.abs() <= 1.0), "{view:?}: {apart:?}");
            }
        }
    }

    #[test]
    fn rounding_the_components_costs_one_to_two_bits_more() {
        let half_pixel_rad = 1.0 / 2048.0;
        let mut more = 0.0_f64;
        for range in studied_ranges(half_pixel_rad, 1) {
            let view = SpanView { range, half_pixel_rad };
            let extra = f64::from(measured_component_bits(&view)) - view.normal_dot_bits();
            assert!((-1.0..3.0).contains(&extra), "{range}: {extra}");
            more = more.max(extra);
        }
        assert!(more > 1.0, "the components' rounding adds up: {more}");
    }
}
