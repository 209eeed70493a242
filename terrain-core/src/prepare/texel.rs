//! The two kinds of texels a pyramid is made of, each averaged in its own right way.

use std::sync::LazyLock;

use crate::srgb::{CODE_FROM_LINEAR, linear_from_srgb};

/// A texel that can be averaged with its neighbours.
pub trait Texel: Copy + Send + Sync + 'static {
    /// A texel of nothing.
    const EMPTY: Self;

    /// Whether there is anything here.
    fn holds_data(&self) -> bool;

    /// The average of four texels of the finer level.
    fn average(parts: [Self; 4]) -> Self;
}

/// A height in metres; NaN where there is none. Averages leave out what is missing.
impl Texel for f32 {
    const EMPTY: Self = Self::NAN;

    fn holds_data(&self) -> bool {
        !self.is_nan()
    }

    fn average(parts: [Self; 4]) -> Self {
        let mut sum = 0.0_f64;
        let mut count = 0.0_f64;
        for part in parts {
            if !part.is_nan() {
                sum += f64::from(part);
                count += 1.0;
            }
        }
        // Nothing over nothing is NaN, which is what "no data" is.
        (sum / count) as Self
    }
}

/// A colour in linear light, multiplied by its coverage (the last part), all in 0..=65535.
///
/// 16 bits keep every sRGB code apart, the darkest by twenty steps, so that the finest level comes
/// out as it went in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct LinearColour(pub [u16; 4]);

/// Full light, full coverage.
pub const FULL: f32 = 65535.0;

impl Texel for LinearColour {
    const EMPTY: Self = Self([0; 4]);

    fn holds_data(&self) -> bool {
        self.0[3] > 0
    }

    fn average(parts: [Self; 4]) -> Self {
        Self(std::array::from_fn(|channel| {
            let sum: u32 = parts.iter().map(|part| u32::from(part.0[channel])).sum();
            ((sum + 2) / 4) as u16
        }))
    }
}

impl LinearColour {
    /// Of an sRGB colour (not multiplied) and its coverage.
    pub fn of_srgb([r, g, b, a]: [u8; 4]) -> Self {
        if a == u8::MAX {
            let table = &*WHOLE_LINEAR_FROM_SRGB;
            let part = |code: u8| table[usize::from(code)];
            return Self([part(r), part(g), part(b), u16::MAX]);
        }
        let table = &*LINEAR_FROM_SRGB;
        let coverage = f32::from(a) / 255.0;
        let part = |code: u8| (coverage * table[usize::from(code)] + 0.5) as u16;
        Self([part(r), part(g), part(b), u16::from(a) * 257])
    }

    /// The sRGB colour (not multiplied) and the coverage, 8 bits each.
    pub fn to_srgb(self) -> [u8; 4] {
        let [r, g, b, coverage] = self.0;
        let table: &[u8; 65536] = &CODE_FROM_LINEAR;
        if coverage == u16::MAX {
            let byte = |value: u16| table[usize::from(value)];
            return [byte(r), byte(g), byte(b), u8::MAX];
        }
        if coverage == 0 {
            return [0; 4];
        }
        let byte = |value: u16| {
            let full = u32::from(value) * 65535 / u32::from(coverage);
            table[full.min(65535) as usize]
        };
        [byte(r), byte(g), byte(b), ((u32::from(coverage) + 128) / 257) as u8]
    }
}

/// Linear light in 0..=65535 of each sRGB code.
pub static LINEAR_FROM_SRGB: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|code| (FULL as f64 * linear_from_srgb(code as f64 / 255.0)) as f32)
});

static WHOLE_LINEAR_FROM_SRGB: LazyLock<[u16; 256]> =
    LazyLock::new(|| LINEAR_FROM_SRGB.map(|linear| (linear + 0.5) as u16));

#[cfg(test)]
mod tests {
    use super::*;

    fn of_srgb(code: u8, coverage: u16) -> LinearColour {
        let part = LINEAR_FROM_SRGB[usize::from(code)] * f32::from(coverage) / FULL;
        LinearColour([part.round() as u16, part.round() as u16, part.round() as u16, coverage])
    }

    #[test]
    fn every_srgb_code_survives() {
        for code in 0..=255 {
            assert_eq!(of_srgb(code, 65535).to_srgb(), [code, code, code, 255]);
            for coverage in [1, 90, 254, 255] {
                let grey = [code, code, code, coverage];
                let back = LinearColour::of_srgb(grey).to_srgb();
                // Little coverage leaves few bits for the colour below it.
                let slack = if coverage < 50 { 9 } else { 1 };
                assert!(
                    back[0].abs_diff(code) <= slack && back[3] == coverage,
                    "{grey:?} {back:?}"
                );
                assert!(coverage < 255 || back == grey);
            }
        }
    }

    #[test]
    fn light_is_averaged_not_codes() {
        let (black, white) = (of_srgb(0, 65535), of_srgb(255, 65535));
        let grey = LinearColour::average([black, white, white, black]);
        assert_eq!(grey.to_srgb(), [188, 188, 188, 255]);
    }

    #[test]
    fn uncovered_parts_lend_coverage_but_no_colour() {
        let white = of_srgb(255, 65535);
        let half = LinearColour::average([white, white, LinearColour::EMPTY, LinearColour::EMPTY]);
        assert_eq!(half.to_srgb(), [255, 255, 255, 128]);
    }

    #[test]
    fn missing_heights_are_left_out() {
        assert_eq!(f32::average([1.0, f32::NAN, 4.0, f32::NAN]), 2.5);
        assert!(f32::average([f32::NAN; 4]).is_nan());
    }
}
