use serde::Serialize;

use crate::gpu::{Answer, GpuContext, GpuError, probe_encodings};
use crate::precision::encodings::{
    Contract, Decoded, EncodedPoint, Encoding, EncodingErrors, EncodingScene, SweepAxes, Verdict,
    decode_on_cpu, measure_encodings, verdicts,
};

/// Encodings of places: errors on both sides, and what they come to.
#[derive(Clone, Debug, Serialize)]
pub struct EncodingStudy {
    /// The bounds.
    pub contract: Contract,
    /// Errors of the CPU's twin of the shader.
    pub cpu: EncodingErrors,
    /// Errors of the device.
    pub gpu: Option<EncodingErrors>,
    /// Verdicts on the CPU's errors.
    pub cpu_verdicts: Vec<Verdict>,
    /// Verdicts on the device's errors.
    pub gpu_verdicts: Option<Vec<Verdict>>,
    /// How far the twins agree; empty without a device.
    pub twins: Vec<TwinRow>,
    /// Points whose fixed-point position differed between the twins.
    pub positions_apart: usize,
}

/// How far the device's decoding agrees with the CPU's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct TwinRow {
    /// The encoding.
    pub encoding: Encoding,
    /// Numbers compared: four a point.
    pub numbers: usize,
    /// Numbers that differ in any bit.
    pub apart: usize,
    /// Most steps of an f32 between two that should be one.
    pub most_ulps: u32,
}

pub(super) fn measure(
    gpu: Option<&GpuContext>,
    axes: &SweepAxes,
) -> Result<EncodingStudy, GpuError> {
    let contract = Contract::SHIPPED;
    let on_cpu = |_: &EncodingScene, points: &[EncodedPoint]| Ok(decode_on_cpu(points));
    let cpu = measure_encodings::<GpuError>(axes, on_cpu)?;
    let mut twins = Twins::default();
    let on_gpu = |gpu| {
        measure_encodings(axes, |scene: &EncodingScene, points: &[EncodedPoint]| {
            let answers = probe_encodings(gpu, scene.uniforms(), points)?;
            twins.compare(scene, points, &answers);
            Ok(answers.iter().map(|answer| answer.decoded).collect())
        })
    };
    let gpu_errors = gpu.map(on_gpu).transpose()?;
    Ok(EncodingStudy {
        contract,
        cpu_verdicts: verdicts(&cpu, &contract),
        gpu_verdicts: gpu_errors.as_ref().map(|errors| verdicts(errors, &contract)),
        twins: gpu.map_or(Vec::new(), |_| twins.rows()),
        positions_apart: twins.positions_apart,
        cpu,
        gpu: gpu_errors,
    })
}

#[derive(Default)]
struct Twins {
    numbers: usize,
    apart: [usize; Encoding::ALL.len()],
    most_ulps: [u32; Encoding::ALL.len()],
    positions_apart: usize,
}

impl Twins {
    fn compare(&mut self, scene: &EncodingScene, points: &[EncodedPoint], answers: &[Answer]) {
        for ((point, cpu), answer) in points.iter().zip(decode_on_cpu(points)).zip(answers) {
            let position = scene.found_position(point.from_eye);
            self.positions_apart += usize::from([position.x, position.y] != answer.position);
            self.numbers += 4;
            for (index, (here, there)) in cpu.iter().zip(&answer.decoded).enumerate() {
                for (here, there) in numbers(here).into_iter().zip(numbers(there)) {
                    let ulps = ulps_between(here, there);
                    self.apart[index] += usize::from(ulps > 0);
                    self.most_ulps[index] = self.most_ulps[index].max(ulps);
                }
            }
        }
    }

    fn rows(&self) -> Vec<TwinRow> {
        let rows = Encoding::ALL.into_iter().enumerate().map(|(index, encoding)| TwinRow {
            encoding,
            numbers: self.numbers,
            apart: self.apart[index],
            most_ulps: self.most_ulps[index],
        });
        rows.collect()
    }
}

fn numbers(decoded: &Decoded) -> [f32; 4] {
    let ([x, y], [across, down]) = (decoded.relative_m, decoded.place_texels);
    [x, y, across, down]
}

/// Steps of an f32 between two numbers; none between the two zeros.
fn ulps_between(a: f32, b: f32) -> u32 {
    // Order the bits as the numbers are ordered.
    let ordered = |value: f32| {
        let bits = i64::from(value.to_bits() as i32);
        if bits < 0 { i64::from(i32::MIN) - bits } else { bits }
    };
    u32::try_from((ordered(a) - ordered(b)).unsigned_abs()).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_counted_across_zero() {
        assert_eq!(ulps_between(1.0, 1.0 + f32::EPSILON), 1);
        assert_eq!(ulps_between(-0.0, 0.0), 0);
        assert_eq!(ulps_between(f32::from_bits(1), -f32::from_bits(1)), 2);
        assert_eq!(ulps_between(1.0, 2.0), 1 << 23);
    }
}
