//! What floats of `p` significant bits make of the same quotient.

use serde::Serialize;

use super::SpanView;

/// The texture coordinate computed in a float format, from the components of an unnormalised ray.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct NativeError {
    /// Worst error of the coordinate in texels as wide as the footprint is long; infinite where the
    /// format overflows.
    pub texels: f64,
    /// Significant bits that the quotient had: what a format must have by the prediction for this error.
    pub effective_bits: f64,
}

/// Roundings between exact components and the quotient: one each of the normalised dot products, which
/// share the error of the ray's length, and one of the division.
const ROUNDINGS: f64 = 3.0;

/// Half a step of a float of `p` bits as a part of its value is `2^-p / m` for a mantissa `m` of 1 to 2:
/// the mean over mantissas spread evenly by their logarithm, `1 / (2 ln 2)`.
const MEAN_ROUNDING: f64 = 0.5 * std::f64::consts::LOG2_E;

/// Error to expect of a format with `significant_bits`, in texels as wide as the footprint is long.
pub fn predicted_native_error(view: &SpanView, significant_bits: u32) -> f64 {
    let relative = ROUNDINGS * MEAN_ROUNDING * (-f64::from(significant_bits)).exp2();
    relative * view.range / view.footprint_along()
}

/// The worst of quotients computed for rays about the view's, each with the true one.
pub fn worst_native_error(view: &SpanView, quotients: &[[f64; 2]]) -> NativeError {
    let relative = quotients.iter().map(|[computed, exact]| {
        let error = (computed - exact).abs() / exact;
        if error.is_nan() { f64::INFINITY } else { error }
    });
    let worst = relative.fold(0.0, f64::max);
    NativeError {
        texels: worst * view.range / view.footprint_along(),
        effective_bits: -(worst / (ROUNDINGS * MEAN_ROUNDING)).log2(),
    }
}
