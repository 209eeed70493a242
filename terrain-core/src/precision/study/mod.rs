//! The whole study in one run: measured, tabulated and drawn.

mod depth_rows;
mod encoding_rows;
mod float_rows;
mod plots;
mod report;
mod span_rows;
mod summary;
mod tables;

pub use depth_rows::DepthRow;
pub use encoding_rows::{EncodingStudy, TwinRow};
pub use float_rows::{FloatFindings, NativeRow};
pub use plots::{NamedPlot, plots};
pub use report::report_page;
pub use span_rows::SpanRow;
pub use summary::{NativeSummary, SpanSummary, Summary};
pub use tables::{NamedTable, tables};

use serde::Serialize;

use super::encodings::SweepAxes;
use crate::gpu::{GpuContext, GpuError};

/// How much to look at.
#[derive(Clone, Debug)]
pub struct StudyOptions {
    /// Values that the sweeps over encodings go through.
    pub axes: SweepAxes,
    /// Ranges tried to each doubling of the range.
    pub ranges_per_octave: u32,
}

impl StudyOptions {
    /// What the committed records hold.
    pub fn full() -> Self {
        Self { axes: SweepAxes::full(), ranges_per_octave: 8 }
    }

    /// A coarser grid with the same ends.
    pub fn quick() -> Self {
        Self { axes: SweepAxes::quick(), ranges_per_octave: 2 }
    }
}

/// Everything that was measured.
#[derive(Clone, Debug, Serialize)]
pub struct Study {
    /// The adapter's name, or `None` where everything was computed on the CPU alone.
    pub adapter: Option<String>,
    /// Bits of the dot products, a row an angle of pixel and range.
    pub spans: Vec<SpanRow>,
    /// The device's own floats; empty without a device.
    pub natives: Vec<NativeRow>,
    /// What the device does with the operations that extended precision rests on.
    pub floats: Option<FloatFindings>,
    /// Encodings of places.
    pub encodings: EncodingStudy,
    /// Depth, a row a kind and distance.
    pub depth: Vec<DepthRow>,
}

/// Parts of the work that [`run_study`] tells its progress in.
pub const STUDY_PARTS: u64 = 5;

/// Runs the study, on the device too where there is one. `progress` hears how many parts are done.
///
/// # Errors
/// [`GpuError::Lost`] where the device fails.
pub fn run_study(
    gpu: Option<&GpuContext>,
    options: &StudyOptions,
    progress: &dyn Fn(u64),
) -> Result<Study, GpuError> {
    progress(0);
    let spans = span_rows::measure(gpu, options.ranges_per_octave)?;
    progress(1);
    let natives = float_rows::measure_natives(gpu, options.ranges_per_octave)?;
    progress(2);
    let floats = gpu.map(float_rows::measure_floats).transpose()?;
    progress(3);
    let encodings = encoding_rows::measure(gpu, &options.axes)?;
    progress(4);
    let depth = depth_rows::measure(gpu)?;
    progress(STUDY_PARTS);
    let adapter = gpu.map(GpuContext::adapter_name);
    Ok(Study { adapter, spans, natives, floats, encodings, depth })
}
