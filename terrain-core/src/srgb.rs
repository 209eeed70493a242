//! The sRGB encoding of light (IEC 61966-2-1): values and linear light both in 0..=1.

use std::sync::LazyLock;

/// Linear light of each 8-bit code.
pub static LINEAR_FROM_CODE: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|code| linear_from_srgb(code as f64 / 255.0) as f32));

/// The 8-bit code nearest to linear light, which is given in 65535ths.
pub static CODE_FROM_LINEAR: LazyLock<[u8; 65536]> = LazyLock::new(|| {
    std::array::from_fn(|linear| (255.0 * srgb_from_linear(linear as f64 / 65535.0)).round() as u8)
});

/// Linear light of an encoded value.
pub fn linear_from_srgb(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// The inverse of [`linear_from_srgb`].
pub fn srgb_from_linear(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_encoding_and_its_inverse_undo_each_other() {
        for (code, &linear) in LINEAR_FROM_CODE.iter().enumerate() {
            let encoded = code as f64 / 255.0;
            assert!((srgb_from_linear(linear_from_srgb(encoded)) - encoded).abs() < 1e-6);
            assert!((srgb_from_linear(f64::from(linear)) - encoded).abs() < 1e-6);
        }
    }

    #[test]
    fn half_the_codes_are_a_fifth_of_the_light() {
        // Published values: 0.5 is 0.2140 in linear light, light of 18 % is code 117.6.
        assert!((linear_from_srgb(0.5) - 0.2140).abs() < 5e-5);
        assert!((255.0 * srgb_from_linear(0.18) - 117.6).abs() < 0.2);
    }
}
