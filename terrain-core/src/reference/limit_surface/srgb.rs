//! sRGB codes and linear light (IEC 61966-2-1), by tables: preparing looks up billions.

use std::sync::LazyLock;

use glam::Vec3;

/// Linear light of a code; 0..=1.
pub fn linear_from_code(code: u8) -> f32 {
    LINEAR[usize::from(code)]
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

static LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|code| {
        let encoded = code as f64 / 255.0;
        let linear = if encoded <= 0.04045 {
            encoded / 12.92
        } else {
            ((encoded + 0.055) / 1.055).powf(2.4)
        };
        linear as f32
    })
});

static CODES: LazyLock<Vec<f32>> = LazyLock::new(|| {
    let code = |index: usize| (255.0 * encoded(index as f64 / INTERVALS as f64)) as f32;
    (0..=INTERVALS).map(code).collect()
});

fn encoded(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

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
            let error = f64::from(code_from_linear(linear as f32)) - 255.0 * encoded(linear);
            assert!(error.abs() < 0.005, "{linear}: {error}");
        }
    }
}
