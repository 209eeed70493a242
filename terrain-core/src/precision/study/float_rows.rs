use half::f16;
use serde::Serialize;

use crate::gpu::{
    GpuContext, GpuError, NativeFloat, Operands, Results, probe_floats, probe_native,
};
use crate::precision::encodings::spread;
use crate::precision::span::{
    NativeError, STUDIED_HALF_PIXELS_RAD, SpanView, TEXEL_PART, predicted_native_error,
    studied_ranges, worst_native_error,
};

/// The texture coordinate in a float of the device at one range.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct NativeRow {
    /// Significant bits of the format.
    pub significant_bits: u32,
    /// Half the angle of a pixel, radians.
    pub half_pixel_rad: f64,
    /// Ground distance over height.
    pub range: f64,
    /// Error to expect, texels.
    pub predicted_texels: f64,
    /// Error found, texels; infinite where the format overflows.
    pub measured_texels: f64,
    /// Significant bits that the quotient turned out to have.
    pub effective_bits: f64,
    /// Whether the error is within [`TEXEL_PART`].
    pub holds: bool,
}

/// Rays about each range.
const RAYS: usize = 1024;

pub(super) fn measure_natives(
    gpu: Option<&GpuContext>,
    ranges_per_octave: u32,
) -> Result<Vec<NativeRow>, GpuError> {
    let Some(gpu) = gpu else { return Ok(Vec::new()) };
    let mut rows = Vec::new();
    for half_pixel_rad in STUDIED_HALF_PIXELS_RAD {
        let ranges = studied_ranges(half_pixel_rad, ranges_per_octave);
        let rays = ranges.iter().flat_map(|range| rays_about(*range)).collect::<Vec<_>>();
        for float in [NativeFloat::F16, NativeFloat::F32, NativeFloat::F64] {
            let Some(quotients) = probe_native(gpu, float, &rays)? else { continue };
            let pairs = rays.iter().zip(quotients).map(|(ray, [high, low])| {
                // The ray points 1 down, so that its quotient is its component along.
                [f64::from(high) + f64::from(low), f64::from(ray[0])]
            });
            let pairs = pairs.collect::<Vec<_>>();
            rows.extend(ranges.iter().zip(pairs.chunks(RAYS)).map(|(range, pairs)| {
                let view = SpanView { range: *range, half_pixel_rad };
                native_row(float, view, worst_native_error(&view, pairs))
            }));
        }
    }
    Ok(rows)
}

fn native_row(float: NativeFloat, view: SpanView, found: NativeError) -> NativeRow {
    NativeRow {
        significant_bits: float.significant_bits(),
        half_pixel_rad: view.half_pixel_rad,
        range: view.range,
        predicted_texels: predicted_native_error(&view, float.significant_bits()),
        measured_texels: found.texels,
        effective_bits: found.effective_bits,
        holds: found.texels <= TEXEL_PART,
    }
}

/// Rays that every format can hold, within a tenth of the range and up to 45 degrees off the axis.
fn rays_about(range: f64) -> impl Iterator<Item = [f32; 2]> {
    (0..RAYS).map(move |index| {
        let along = range * (0.9 + 0.2 * spread(index, 0.618_034));
        let across = along * spread(index, 0.414_214);
        [along, across].map(|part| f16::from_f64(part).to_f32())
    })
}

/// How often the device's operations were not those of IEEE 754 rounded one by one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct FloatFindings {
    /// Operands tried.
    pub tried: usize,
    /// Of these, such that `a * b + c` tells one rounding from two.
    pub telling: usize,
    /// Of those, `a * b + c` rounded once: contracted.
    pub contracted: usize,
    /// `fma(a, b, c)` not the exact value rounded once.
    pub fma_unfused: usize,
    /// `a / b` not the exact value rounded.
    pub quotients_off: usize,
    /// Knuth's error of a sum not exact.
    pub sum_errors_off: usize,
    /// Dekker's error of a product not exact.
    pub product_errors_off: usize,
}

/// Operands tried on the device.
const OPERANDS: usize = 4096;

pub(super) fn measure_floats(gpu: &GpuContext) -> Result<FloatFindings, GpuError> {
    let number = |index: usize, rate: f64| {
        let exponent = (spread(index, rate * 0.37) * 24.0 - 12.0).floor();
        ((1.0 + spread(index, rate)) * exponent.exp2()) as f32
    };
    let operands = (0..OPERANDS).map(|index| Operands {
        a: number(index, 0.618_034),
        b: -number(index, 0.414_214),
        c: number(index, 0.732_051),
    });
    let operands = operands.collect::<Vec<_>>();
    let results = probe_floats(gpu, &operands)?;
    let mut findings = FloatFindings { tried: operands.len(), ..FloatFindings::default() };
    for (operands, results) in operands.iter().zip(results) {
        findings.count(operands, &results);
    }
    Ok(findings)
}

impl FloatFindings {
    fn count(&mut self, &Operands { a, b, c }: &Operands, results: &Results) {
        let (twice, once) = (a * b + c, a.mul_add(b, c));
        let differs = |found: f32, wanted: f32| usize::from(found.to_bits() != wanted.to_bits());
        if twice.to_bits() != once.to_bits() {
            self.telling += 1;
            self.contracted += usize::from(results.plain.to_bits() == once.to_bits());
        }
        self.fma_unfused += differs(results.fused, once);
        self.quotients_off += differs(results.quotient, a / b);
        // Both are exact in f64: the sum spans fewer than 53 bits, the product has 48.
        let exact_error = |exact: f64, rounded: f32| (exact - f64::from(rounded)) as f32;
        let sum_error = exact_error(f64::from(a) + f64::from(b), a + b);
        let product_error = exact_error(f64::from(a) * f64::from(b), a * b);
        self.sum_errors_off += usize::from(results.sum_error != sum_error);
        self.product_errors_off += usize::from(results.product_error != product_error);
    }
}
