use serde::Serialize;

use super::{DepthRow, FloatFindings, NativeRow, Study, TwinRow};
use crate::precision::depth::DepthKind;
use crate::precision::encodings::{Contract, Verdict};
use crate::precision::span::STUDIED_HALF_PIXELS_RAD;

/// What the study comes to: small enough to be kept as a record.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// The adapter's name.
    pub adapter: Option<String>,
    /// Bits of a span's dot products, an entry an angle of pixel.
    pub spans: Vec<SpanSummary>,
    /// The device's floats, an entry a format and angle of pixel.
    pub natives: Vec<NativeSummary>,
    /// What the device does with single operations.
    pub floats: Option<FloatFindings>,
    /// The bounds that encodings are held to.
    pub contract: Contract,
    /// Points compared in both sweeps.
    pub points: usize,
    /// Encodings in the CPU's f32.
    pub cpu_verdicts: Vec<Verdict>,
    /// Encodings on the device.
    pub gpu_verdicts: Option<Vec<Verdict>>,
    /// How far CPU and device agree.
    pub twins: Vec<TwinRow>,
    /// Points whose fixed-point position differed between them.
    pub positions_apart: usize,
    /// Depth at about each power of ten of a metre.
    pub depth: Vec<DepthRow>,
}

/// Derived against tried bits for one angle of pixel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SpanSummary {
    /// Half the angle of a pixel, radians.
    pub half_pixel_rad: f64,
    /// Ranges tried.
    pub ranges: usize,
    /// Farthest that tried bits of `N.V` lie from the derived, on either side and in any float.
    pub normal_dot_apart: f64,
    /// Likewise for the texture coordinate.
    pub texture_apart: f64,
    /// Most bits that rounded components need beyond the derived.
    pub components_beyond: f64,
    /// Farthest that the literal reading of the paper lies above and below the bits needed.
    pub directions_beyond: [f64; 2],
}

/// Derived against measured errors of a float format for one angle of pixel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct NativeSummary {
    /// Significant bits of the format.
    pub significant_bits: u32,
    /// Half the angle of a pixel, radians.
    pub half_pixel_rad: f64,
    /// Least and most bits that the quotient had, where it had an error and the format did not overflow.
    pub effective_bits: [f64; 2],
    /// Largest range at which no quotient had any error.
    pub exact_to: Option<f64>,
    /// Smallest range at which the format overflows.
    pub overflows_from: Option<f64>,
    /// Smallest and largest range at which the error exceeds a sixteenth of a texel without overflow.
    pub fails_within: Option<[f64; 2]>,
}

impl Study {
    /// What it comes to.
    pub fn summary(&self) -> Summary {
        Summary {
            adapter: self.adapter.clone(),
            spans: STUDIED_HALF_PIXELS_RAD.map(|angle| self.span_summary(angle)).into(),
            natives: self.native_summaries(),
            floats: self.floats,
            contract: self.encodings.contract,
            points: self.encodings.cpu.points,
            cpu_verdicts: self.encodings.cpu_verdicts.clone(),
            gpu_verdicts: self.encodings.gpu_verdicts.clone(),
            twins: self.encodings.twins.clone(),
            positions_apart: self.encodings.positions_apart,
            depth: self.depth_by_decades(),
        }
    }

    fn span_summary(&self, half_pixel_rad: f64) -> SpanSummary {
        let rows = || self.spans.iter().filter(move |row| row.half_pixel_rad == half_pixel_rad);
        let (mut normal_dot_apart, mut texture_apart) = (0.0_f64, 0.0_f64);
        for row in rows() {
            for tried in [Some(row.cpu), row.gpu_f32, row.gpu_f64].into_iter().flatten() {
                let apart = |bits: u32, derived: f64| (f64::from(bits) - derived).abs();
                let normal = apart(tried.normal_dot, row.normal_dot_bits);
                normal_dot_apart = normal_dot_apart.max(normal);
                texture_apart = texture_apart.max(apart(tried.texture, row.texture_bits));
            }
        }
        let components = rows().map(|row| f64::from(row.component_bits) - row.normal_dot_bits);
        let directions = || rows().map(|row| row.direction_bits - row.normal_dot_bits);
        SpanSummary {
            half_pixel_rad,
            ranges: rows().count(),
            normal_dot_apart,
            texture_apart,
            components_beyond: components.fold(f64::MIN, f64::max),
            directions_beyond: [
                directions().fold(f64::MIN, f64::max),
                directions().fold(f64::MAX, f64::min),
            ],
        }
    }

    fn native_summaries(&self) -> Vec<NativeSummary> {
        let mut summaries = Vec::new();
        for half_pixel_rad in STUDIED_HALF_PIXELS_RAD {
            for significant_bits in [11, 24, 53] {
                let rows = || {
                    self.natives.iter().filter(move |row| {
                        row.half_pixel_rad == half_pixel_rad
                            && row.significant_bits == significant_bits
                    })
                };
                if rows().next().is_none() {
                    continue;
                }
                let finite = || rows().filter(|row| row.measured_texels.is_finite());
                let is_exact = |row: &&NativeRow| row.measured_texels == 0.0;
                let bits = || finite().filter(|row| !is_exact(row)).map(|row| row.effective_bits);
                let exact = finite().filter(is_exact);
                let failing = || finite().filter(|row| !row.holds).map(|row| row.range);
                let overflowing = rows().filter(|row| !row.measured_texels.is_finite());
                summaries.push(NativeSummary {
                    significant_bits,
                    half_pixel_rad,
                    effective_bits: [
                        bits().fold(f64::MAX, f64::min),
                        bits().fold(f64::MIN, f64::max),
                    ],
                    exact_to: exact.map(|row| row.range).reduce(f64::max),
                    overflows_from: overflowing.map(|row| row.range).reduce(f64::min),
                    fails_within: failing()
                        .reduce(f64::min)
                        .zip(failing().reduce(f64::max))
                        .map(|(least, most)| [least, most]),
                });
            }
        }
        summaries
    }

    /// The row nearest to each power of ten, a kind after the other.
    fn depth_by_decades(&self) -> Vec<DepthRow> {
        let mut picked = Vec::new();
        for kind in DepthKind::ALL {
            for decade in 0..8 {
                let off = |row: &DepthRow| (row.distance_m.log10() - f64::from(decade)).abs();
                let rows = self.depth.iter().filter(|row| row.kind == kind);
                picked.extend(rows.min_by(|a, b| off(a).total_cmp(&off(b))));
            }
        }
        picked
    }
}
