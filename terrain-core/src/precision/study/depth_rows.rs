use serde::Serialize;

use crate::gpu::{GpuContext, GpuError, probe_depth};
use crate::precision::depth::{DepthGrid, DepthKind};

/// What one kind of depth tells apart at one distance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DepthRow {
    /// The kind.
    pub kind: DepthKind,
    /// Distance of the nearer surface, metres.
    pub distance_m: f64,
    /// Step between neighbouring depths by the formula, metres.
    pub step_m: f64,
    /// Smallest gap from which on all are told apart, with the CPU's f32, metres.
    pub cpu_gap_m: f64,
    /// Likewise drawn by the device.
    pub gpu_gap_m: Option<f64>,
}

pub(super) fn measure(gpu: Option<&GpuContext>) -> Result<Vec<DepthRow>, GpuError> {
    let grid = DepthGrid::studied();
    let mut rows = Vec::new();
    for kind in DepthKind::ALL {
        let on_cpu = grid.least_gaps_m(&grid.told_apart_on_cpu(kind));
        let drawn = gpu.map(|gpu| probe_depth(gpu, kind, &grid)).transpose()?;
        let on_gpu = drawn.map(|told_apart| grid.least_gaps_m(&told_apart));
        rows.extend(grid.places_m().enumerate().map(|(index, distance_m)| DepthRow {
            kind,
            distance_m,
            step_m: kind.step_m(distance_m),
            cpu_gap_m: on_cpu[index],
            gpu_gap_m: on_gpu.as_ref().map(|gaps| gaps[index]),
        }));
    }
    Ok(rows)
}
