use std::collections::BTreeMap;

use serde::Serialize;
use terrain_core::measure::FrameRecord;
use terrain_core::measure::error::Spread;
use terrain_core::measure::motion::jank_sum_ms;

use super::course::RunResult;

/// A run in numbers: what `summary.json` holds of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunSummary {
    /// What the run is called.
    pub run: String,
    /// How tiles were selected.
    pub strategy: &'static str,
    /// Frames drawn.
    pub frames: u64,
    /// Frames whose error was measured.
    pub measured_frames: u64,
    /// Frames in which a tile that was wanted was not there yet.
    pub frames_with_missing_tiles: u64,
    /// Time of a frame in milliseconds, measuring left out.
    pub frame_ms: Spread,
    /// Work of the CPU a frame, milliseconds.
    pub cpu_ms: Spread,
    /// Work of the GPU a frame, milliseconds; `None` without timestamps.
    pub gpu_ms: Option<Spread>,
    /// Time beyond that of 60 frames a second, all frames together, milliseconds.
    pub jank_sum_ms: f64,
    /// Tiles uploaded, all frames together.
    pub tiles_new: u64,
    /// Bytes a frame, by cause.
    pub bytes_a_frame: BytesAFrame,
    /// Mean over the measured frames of each column of errors that has values.
    pub mean_errors: BTreeMap<&'static str, f64>,
}

/// Mean bytes a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct BytesAFrame {
    /// To the GPU.
    pub upload: f64,
    /// Of these, heights.
    pub dem: f64,
    /// Of these, imagery.
    pub dom: f64,
    /// Of these, tables.
    pub table: f64,
    /// Of these, meshes.
    pub mesh: f64,
    /// Of these, uniforms.
    pub uniform: f64,
    /// Back from the GPU.
    pub readback: f64,
    /// From disk.
    pub disk: f64,
}

/// Which time of a frame is set against errors: its median over a run's frames, as a mean would
/// count what only the first frame does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RunTime {
    /// From the beginning of a frame to its end.
    Frame,
    /// The GPU's own.
    Gpu,
    /// The CPU's.
    Cpu,
}

impl RunTime {
    /// The time to set against errors of these runs. Where every frame waits for its tiles its time is
    /// that of the disk: the GPU's own then, or the CPU's where a run has no timestamps.
    pub fn of(runs: &[RunSummary], settle: bool) -> Self {
        match settle {
            false => Self::Frame,
            true if runs.iter().all(|run| run.gpu_ms.is_some()) => Self::Gpu,
            true => Self::Cpu,
        }
    }

    /// The run's median, milliseconds.
    pub fn median_ms(self, run: &RunSummary) -> f64 {
        match self {
            Self::Frame => run.frame_ms.p50,
            Self::Gpu => run.gpu_ms.map_or(f64::NAN, |spread| spread.p50),
            Self::Cpu => run.cpu_ms.p50,
        }
    }

    /// What the time is called on a plot.
    pub fn label(self) -> &'static str {
        match self {
            Self::Frame => "time a frame, median (ms)",
            Self::Gpu => "GPU time a frame, median (ms)",
            Self::Cpu => "CPU time a frame, median (ms)",
        }
    }

    /// What the time is called in `summary.json`.
    pub fn column(self) -> &'static str {
        match self {
            Self::Frame => "frame_ms_p50",
            Self::Gpu => "gpu_ms_p50",
            Self::Cpu => "cpu_ms_p50",
        }
    }
}

impl RunSummary {
    /// The summary of a run.
    pub fn of(run: &RunResult) -> Self {
        let records = &run.records;
        let spread = |value: fn(&FrameRecord) -> f64| {
            Spread::of(records.iter().map(value)).unwrap_or_default()
        };
        let measured = records.iter().filter(|record| record.errors.flip_mean.is_some());
        let missing = records.iter().filter(|record| record.tiles_missing > 0);
        Self {
            run: run.name.clone(),
            strategy: run.strategy.name(),
            frames: records.len() as u64,
            measured_frames: measured.count() as u64,
            frames_with_missing_tiles: missing.count() as u64,
            frame_ms: spread(|record| record.frame_ms),
            cpu_ms: spread(|record| record.cpu_ms),
            gpu_ms: Spread::of(records.iter().filter_map(|record| record.gpu_ms)),
            jank_sum_ms: jank_sum_ms(records.iter().map(|record| record.frame_ms)),
            tiles_new: records.iter().map(|record| record.tiles_new).sum(),
            bytes_a_frame: BytesAFrame::of(records),
            mean_errors: mean_errors(records),
        }
    }

    /// Mean of a column of errors; not a number where it was not measured.
    pub fn error(&self, column: &str) -> f64 {
        self.mean_errors.get(column).copied().unwrap_or(f64::NAN)
    }
}

impl BytesAFrame {
    fn of(records: &[FrameRecord]) -> Self {
        let frames = records.len().max(1) as f64;
        let mean = |bytes: fn(&FrameRecord) -> u64| {
            records.iter().map(bytes).map(|bytes| bytes as f64).sum::<f64>() / frames
        };
        Self {
            upload: mean(|record| record.upload_bytes),
            dem: mean(|record| record.upload_dem_bytes),
            dom: mean(|record| record.upload_dom_bytes),
            table: mean(|record| record.upload_table_bytes),
            mesh: mean(|record| record.upload_mesh_bytes),
            uniform: mean(|record| record.upload_uniform_bytes),
            readback: mean(|record| record.readback_bytes),
            disk: mean(|record| record.disk_bytes),
        }
    }
}

fn mean_errors(records: &[FrameRecord]) -> BTreeMap<&'static str, f64> {
    let mut sums: BTreeMap<&'static str, (f64, u32)> = BTreeMap::new();
    for (name, error) in records.iter().flat_map(|record| record.errors.columns()) {
        if let Some(error) = error {
            let (sum, count) = sums.entry(name).or_default();
            *sum += error;
            *count += 1;
        }
    }
    sums.into_iter().map(|(name, (sum, count))| (name, sum / f64::from(count))).collect()
}

#[cfg(test)]
mod tests {
    use terrain_core::selection::Strategy;

    use super::*;

    #[test]
    fn means_are_over_the_frames_that_have_a_value() {
        let mut records = vec![
            FrameRecord { frame_ms: 10.0, upload_bytes: 100, ..Default::default() },
            FrameRecord { frame_ms: 30.0, tiles_missing: 2, ..Default::default() },
        ];
        records[1].errors.flip_mean = Some(0.25);
        let run = RunResult {
            name: "a".into(),
            strategy: Strategy::default(),
            records,
            worst: Vec::new(),
        };
        let summary = RunSummary::of(&run);
        assert_eq!((summary.frames, summary.measured_frames), (2, 1));
        assert_eq!((summary.error("flip_mean"), summary.bytes_a_frame.upload), (0.25, 50.0));
        assert!((summary.jank_sum_ms - (30.0 - 1000.0 / 60.0)).abs() < 1.0e-9);
        assert!(summary.error("ssim").is_nan());
    }

    #[test]
    fn the_time_shown_is_the_time_named() {
        let summary = |gpu_ms: Option<f64>| {
            let first =
                FrameRecord { frame_ms: 900.0, cpu_ms: 800.0, gpu_ms, ..Default::default() };
            let later = FrameRecord { frame_ms: 30.0, cpu_ms: 3.0, gpu_ms, ..Default::default() };
            let records = vec![first, later.clone(), later];
            let (name, strategy) = ("a".into(), Strategy::default());
            RunSummary::of(&RunResult { name, strategy, records, worst: Vec::new() })
        };
        let chosen = |runs: &[RunSummary], settle: bool| {
            let time = RunTime::of(runs, settle);
            (time.column(), time.median_ms(&runs[0]))
        };
        let (timed, untimed) = (summary(Some(7.0)), summary(None));
        assert_eq!(chosen(std::slice::from_ref(&timed), false), ("frame_ms_p50", 30.0));
        assert_eq!(chosen(std::slice::from_ref(&timed), true), ("gpu_ms_p50", 7.0));
        assert_eq!(chosen(&[timed, untimed], true), ("cpu_ms_p50", 3.0));
    }
}
