//! The colour spaces of FLIP: sRGB, linear RGB, CIE XYZ, YCxCz and CIELAB, all with the white of D65.

use std::sync::LazyLock;

use glam::{DMat3, DVec3, Mat3, Vec3, dvec3, vec3};

use crate::srgb::LINEAR_FROM_CODE;

/// XYZ of linear RGB with the primaries and the white of sRGB, as the ratios of whole numbers that
/// the paper's own program uses.
const XYZ_FROM_LINEAR: DMat3 = DMat3::from_cols(
    dvec3(10_135_552.0 / 24_577_794.0, 2_613_072.0 / 12_288_897.0, 1_425_312.0 / 73_733_382.0),
    dvec3(8_788_810.0 / 24_577_794.0, 8_788_810.0 / 12_288_897.0, 8_788_810.0 / 73_733_382.0),
    dvec3(4_435_075.0 / 24_577_794.0, 887_015.0 / 12_288_897.0, 70_074_185.0 / 73_733_382.0),
);

/// What all conversions need, worked out once in f64.
struct Conversions {
    /// XYZ over that of white, from linear RGB.
    white_parts_from_linear: Mat3,
    linear_from_white_parts: Mat3,
}

static CONVERSIONS: LazyLock<Conversions> = LazyLock::new(|| {
    let white = XYZ_FROM_LINEAR * DVec3::ONE;
    let white_parts_from_linear = DMat3::from_diagonal(white.recip()) * XYZ_FROM_LINEAR;
    Conversions {
        white_parts_from_linear: white_parts_from_linear.as_mat3(),
        linear_from_white_parts: white_parts_from_linear.inverse().as_mat3(),
    }
});

/// YCxCz, the linearised CIELAB in which the filter works: luminance 0..=100, red-green, blue-yellow.
pub(super) fn opponent_from_srgb(srgb: [u8; 3]) -> Vec3 {
    let linear = srgb.map(|step| LINEAR_FROM_CODE[usize::from(step)]);
    let parts = CONVERSIONS.white_parts_from_linear * Vec3::from(linear);
    vec3(116.0 * parts.y - 16.0, 500.0 * (parts.x - parts.y), 200.0 * (parts.y - parts.z))
}

/// Luminance from 0 to 1.
pub(super) fn grey_from_opponent(opponent: Vec3) -> f32 {
    (opponent.x + 16.0) / 116.0
}

/// Linear RGB, limited to what a screen can show.
pub(super) fn screen_colour_from_opponent(opponent: Vec3) -> Vec3 {
    let y = grey_from_opponent(opponent);
    let parts = vec3(y + opponent.y / 500.0, y, y - opponent.z / 200.0);
    (CONVERSIONS.linear_from_white_parts * parts).clamp(Vec3::ZERO, Vec3::ONE)
}

/// CIELAB with the Hunt effect: chroma counts in proportion to lightness.
pub(super) fn hunt_lab_from_linear(linear: Vec3) -> Vec3 {
    const DELTA: f32 = 6.0 / 29.0;
    let root = |part: f32| {
        if part > DELTA.powi(3) { part.cbrt() } else { part / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
    };
    let parts = CONVERSIONS.white_parts_from_linear * linear;
    let [x, y, z] = parts.to_array().map(root);
    let lightness = 116.0 * y - 16.0;
    let hunt = 0.01 * lightness;
    vec3(lightness, hunt * 500.0 * (x - y), hunt * 200.0 * (y - z))
}

/// HyAB, the distance for large differences of colour (Abasi, Amani Tehran and Fairchild, 2020):
/// lightness by itself plus the straight distance of chroma.
pub(super) fn hyab(a: Vec3, b: Vec3) -> f32 {
    let difference = a - b;
    difference.x.abs() + difference.y.hypot(difference.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_and_black_are_where_they_must_be() {
        let white = opponent_from_srgb([255; 3]);
        assert!((white - vec3(100.0, 0.0, 0.0)).length() < 1.0e-4, "{white}");
        assert_eq!(opponent_from_srgb([0; 3]), vec3(-16.0, 0.0, 0.0));
        let lab = hunt_lab_from_linear(Vec3::ONE);
        assert!((lab - vec3(100.0, 0.0, 0.0)).length() < 1.0e-3, "{lab}");
    }

    #[test]
    fn a_colour_survives_the_way_there_and_back() {
        for srgb in [[255, 0, 0], [0, 255, 0], [0, 0, 255], [12, 200, 77], [128; 3]] {
            let linear = srgb.map(|step| LINEAR_FROM_CODE[usize::from(step)]);
            let back = screen_colour_from_opponent(opponent_from_srgb(srgb));
            assert!((back - Vec3::from(linear)).abs().max_element() < 2.0e-6, "{srgb:?}: {back}");
        }
    }

    #[test]
    fn lab_of_red_is_the_published_value() {
        // CIELAB of the sRGB red under D65: L 53.24, a 80.09, b 67.20.
        let lab = hunt_lab_from_linear(vec3(1.0, 0.0, 0.0));
        let hunt = 0.01 * lab.x;
        let published = vec3(53.24, 80.09, 67.20);
        let plain = vec3(lab.x, lab.y / hunt, lab.z / hunt);
        assert!((plain - published).abs().max_element() < 0.02, "{plain}");
    }
}
