use serde::Serialize;

use crate::gpu::{GpuContext, GpuError, NativeFloat, Outcome, Trial, probe_span};
use crate::precision::span::{
    MeasuredBits, STUDIED_HALF_PIXELS_RAD, SpanView, TEXEL_PART, measured_bits,
    measured_component_bits, studied_ranges,
};

/// Predicted and tried bits at one range.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SpanRow {
    /// Half the angle of a pixel, radians.
    pub half_pixel_rad: f64,
    /// Ground distance over height.
    pub range: f64,
    /// Formula (15).
    pub leading_zeros: f64,
    /// Bits of `N.V` as derived.
    pub normal_dot_bits: f64,
    /// Bits of both dot products for the texture coordinate, as derived.
    pub texture_bits: f64,
    /// Bits that the literal reading of the paper asks of `N.V`.
    pub direction_bits: f64,
    /// Fewest bits found by trying on the CPU in f64.
    pub cpu: MeasuredBits,
    /// Bits of `N.V` found by trying where the components of both vectors are rounded instead.
    pub component_bits: u32,
    /// Fewest bits found on the device in f32.
    pub gpu_f32: Option<MeasuredBits>,
    /// Fewest bits found on the device in f64.
    pub gpu_f64: Option<MeasuredBits>,
}

/// Bits tried on the device: up to what the steps of an f32 can show.
const GPU_BITS: std::ops::RangeInclusive<u32> = 1..=22;

pub(super) fn measure(
    gpu: Option<&GpuContext>,
    ranges_per_octave: u32,
) -> Result<Vec<SpanRow>, GpuError> {
    let views = views(ranges_per_octave);
    let on_gpu = |float| gpu.map_or(Ok(None), |gpu| tried_on_gpu(gpu, float, &views));
    let f32_bits = on_gpu(NativeFloat::F32)?;
    let f64_bits = on_gpu(NativeFloat::F64)?;
    let at = |bits: &Option<Vec<MeasuredBits>>, index: usize| bits.as_ref().map(|all| all[index]);
    let rows = views.iter().enumerate().map(|(index, view)| SpanRow {
        half_pixel_rad: view.half_pixel_rad,
        range: view.range,
        leading_zeros: view.leading_zeros(),
        normal_dot_bits: view.normal_dot_bits(),
        texture_bits: view.texture_bits(TEXEL_PART),
        direction_bits: view.direction_bits(),
        cpu: measured_bits(view, TEXEL_PART),
        component_bits: measured_component_bits(view),
        gpu_f32: at(&f32_bits, index),
        gpu_f64: at(&f64_bits, index),
    });
    Ok(rows.collect())
}

/// Every view that is tried; ranges are f32s, so that both sides have the same.
fn views(ranges_per_octave: u32) -> Vec<SpanView> {
    let views = STUDIED_HALF_PIXELS_RAD.into_iter().flat_map(|half_pixel_rad| {
        let ranges = studied_ranges(half_pixel_rad, ranges_per_octave);
        ranges
            .into_iter()
            .map(move |range| SpanView { range: f64::from(range as f32), half_pixel_rad })
    });
    views.collect()
}

fn tried_on_gpu(
    gpu: &GpuContext,
    float: NativeFloat,
    views: &[SpanView],
) -> Result<Option<Vec<MeasuredBits>>, GpuError> {
    let trials = views.iter().flat_map(|view| {
        GPU_BITS.map(|bits| Trial {
            range: view.range as f32,
            half_pixel_rad: view.half_pixel_rad as f32,
            texel_part: TEXEL_PART as f32,
            bits,
        })
    });
    let outcomes = probe_span(gpu, float, &trials.collect::<Vec<_>>())?;
    let bits_of_views = |outcomes: Vec<Outcome>| {
        outcomes.chunks(GPU_BITS.count()).map(fewest_bits).collect::<Vec<_>>()
    };
    Ok(outcomes.map(bits_of_views))
}

/// What the trials of one view, fewest bits first, amount to.
fn fewest_bits(outcomes: &[Outcome]) -> MeasuredBits {
    let fewest = |holds: &dyn Fn(&Outcome) -> bool| {
        let first = GPU_BITS.zip(outcomes).find(|(_, outcome)| holds(outcome));
        first.map_or(*GPU_BITS.end() + 1, |(bits, _)| bits)
    };
    MeasuredBits {
        normal_dot: fewest(&|outcome| outcome.moved <= 1.0 && outcome.level <= 1.0),
        texture: fewest(&|outcome| outcome.texture <= 1.0),
    }
}
