//! sRGB codes of linear light and back, by tables: preparing looks up billions.

use std::sync::LazyLock;

use glam::Vec3;

use crate::srgb::{self, LINEAR_FROM_CODE};

/// Linear light of a code; 0..=1.
pub fn linear_from_code(code: u8) -> f32 {
    LINEAR_FROM_CODE[usize::from(code)]
}

/// Linear light of an sRGB colour.
pub fn linear_from_srgb(srgb: [u8; 3]) -> Vec3 {
    Vec3::from_array(srgb.map(linear_from_code))
}

/// The nearest sRGB colour.
pub fn srgb_from_linear(linear: Vec3) -> [u8; 3] {
    linear.to_array().map(|part| code_from_linear(part).round() as u8)
}

/// The code of a linear light, its fraction kept: 0..=255, within 0.005 of the formula.
pub fn code_from_linear(linear: f32) -> f32 {
    let place = linear.clamp(0.0, 1.0) * INTERVALS as f32;
    let index = (place as usize).min(INTERVALS - 1);
    let table = &*CODES;
    table[index] + (table[index + 1] - table[index]) * (place - index as f32)
}

const INTERVALS: usize = 4096;

static CODES: LazyLock<Vec<f32>> = LazyLock::new(|| {
    let code =
        |index: usize| (255.0 * srgb::srgb_from_linear(index as f64 / INTERVALS as f64)) as f32;
    (0..=INTERVALS).map(code).collect()
});

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_come_back_and_the_table_follows_the_formula() {
        for code in 0..=255 {
            assert_eq!(srgb_from_linear(Vec3::splat(linear_from_code(code))), [code; 3]);
        }
        for index in 0..100_000 {
            let linear = f64::from(index) / 99_999.0;
            let error =
                f64::from(code_from_linear(linear as f32)) - 255.0 * srgb::srgb_from_linear(linear);
            assert!(error.abs() < 0.005, "{linear}: {error}");
        }
    }
}
