use std::collections::BTreeMap;

use serde::Serialize;
use terrain_core::measure::FrameRecord;
use terrain_core::measure::error::Spread;
use terrain_core::measure::motion::jank_sum_ms;

use super::course::RunResult;

/// A run in numbers: what `summary.json` holds of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunSummary {
    /// What the flight is called.
    pub flight: String,
    /// What the run is called.
    pub run: String,
    /// How tiles were selected.
    pub strategy: String,
    /// Whether it stands for its strategy.
    pub is_typical: bool,
    /// Frames drawn.
    pub frames: u64,
    /// Frames whose error was measured.
    pub measured_frames: u64,
    /// Frames in which a tile that was wanted was not there yet.
    pub frames_with_missing_tiles: u64,
    /// Frames from a jump until the picture was sharp, mean over the jumps; `None` where there were none,
    /// or one was not sharp before the flight went on.
    pub frames_until_sharp: Option<f64>,
    /// Tiles brought while the camera was at rest.
    pub churn_at_rest: u64,
    /// Time of a frame in milliseconds, measuring left out.
    pub frame_ms: Spread,
    /// Work of the CPU a frame, milliseconds.
    pub cpu_ms: Spread,
    /// Work of the GPU a frame, milliseconds; `None` without timestamps.
    pub gpu_ms: Option<Spread>,
    /// Of the work of the CPU, each stage's, mean milliseconds a frame.
    pub stage_ms: BTreeMap<&'static str, f64>,
    /// Time beyond that of 60 frames a second, all frames together, milliseconds.
    pub jank_sum_ms: f64,
    /// Tiles uploaded, all frames together.
    pub tiles_new: u64,
    /// Tiles selected, hidden, new, missing, evicted and resident: means over the frames.
    pub tiles_a_frame: BTreeMap<&'static str, f64>,
    /// Frames that the region tiles were selected by was old, mean; `None` where there was none.
    pub region_age_frames: Option<f64>,
    /// Mean bytes a frame, by cause.
    pub bytes_a_frame: ByteMeans,
    /// Bytes to the GPU in the first frame, which brings what is sent once.
    pub first_frame_upload_bytes: u64,
    /// `bytes_a_frame` when flown again with what the first time had left in memory.
    pub warm_bytes_a_frame: Option<ByteMeans>,
    /// Mean bytes a frame that the tiles sent would be as RGBA8 and as 32-bit heights; `None` where they
    /// were not counted.
    pub plain_tile_bytes_a_frame: Option<f64>,
    /// Mean over the measured frames of each column of errors that has values.
    pub mean_errors: BTreeMap<&'static str, f64>,
}

/// Mean bytes a frame: the columns of bytes without `_bytes`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[serde(transparent)]
pub struct ByteMeans(BTreeMap<&'static str, f64>);

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
        let gpu_ms = records.iter().filter_map(|record| record.gpu_ms).collect::<Vec<_>>();
        let sharp = run.frames_until_sharp.iter().copied().collect::<Option<Vec<_>>>();
        Self {
            flight: run.flight.clone(),
            run: run.name.clone(),
            strategy: run.strategy.clone(),
            is_typical: run.is_typical,
            frames: records.len() as u64,
            measured_frames: count(records, |record| record.errors.flip_mean.is_some()),
            frames_with_missing_tiles: count(records, |record| record.tiles_missing > 0),
            frames_until_sharp: sharp.and_then(|frames| mean(frames.iter().map(|&n| n as f64))),
            churn_at_rest: run.churn_at_rest,
            frame_ms: spread(|record| record.frame_ms),
            cpu_ms: spread(|record| record.cpu_ms),
            gpu_ms: Spread::of(gpu_ms),
            stage_ms: means(records.iter().flat_map(FrameRecord::stage_columns)),
            jank_sum_ms: jank_sum_ms(records.iter().map(|record| record.frame_ms)),
            tiles_new: records.iter().map(|record| record.tiles_new).sum(),
            tiles_a_frame: means(records.iter().flat_map(|record| {
                record.tile_columns().map(|(name, tiles)| (name, tiles as f64))
            })),
            region_age_frames: mean(
                records.iter().filter_map(|record| record.region_age_frames).map(|age| age as f64),
            ),
            bytes_a_frame: ByteMeans::of(records),
            first_frame_upload_bytes: records.first().map_or(0, |record| record.upload_bytes),
            warm_bytes_a_frame: (!run.warm_records.is_empty())
                .then(|| ByteMeans::of(&run.warm_records)),
            plain_tile_bytes_a_frame: plain_tile_bytes(records),
            mean_errors: means(records.iter().flat_map(|record| {
                let known = record.errors.columns().into_iter();
                known.filter_map(|(name, error)| Some((name, error?)))
            })),
        }
    }

    /// Mean of a column of errors; not a number where it was not measured.
    pub fn error(&self, column: &str) -> f64 {
        self.mean_errors.get(column).copied().unwrap_or(f64::NAN)
    }

    /// KiB to the GPU a frame.
    pub fn upload_kib(&self) -> f64 {
        self.bytes_a_frame.kib("upload")
    }

    /// KiB to the GPU a frame after the first, which fills empty caches; of a single frame its own.
    pub fn later_upload_kib(&self) -> f64 {
        if self.frames < 2 {
            return self.upload_kib();
        }
        let all_kib = self.upload_kib() * self.frames as f64;
        (all_kib - self.first_frame_upload_bytes as f64 / 1024.0) / (self.frames as f64 - 1.0)
    }

    /// KiB to the GPU a frame after the first, and back.
    pub fn later_both_ways_kib(&self) -> f64 {
        self.later_upload_kib() + self.bytes_a_frame.kib("readback")
    }

    /// Mean frames a second.
    pub fn frames_a_second(&self) -> f64 {
        1000.0 / self.frame_ms.mean
    }
}

impl ByteMeans {
    fn of(records: &[FrameRecord]) -> Self {
        let columns = records.iter().flat_map(FrameRecord::byte_columns);
        let short = |name: &'static str| name.strip_suffix("_bytes").unwrap_or(name);
        Self(means(columns.map(|(name, bytes)| (short(name), bytes as f64))))
    }

    /// KiB a frame of this cause; 0 where there is none of the name.
    pub fn kib(&self, cause: &str) -> f64 {
        self.0.get(cause).copied().unwrap_or(0.0) / 1024.0
    }
}

/// Bytes a frame of the tiles as 32 bits a texel, which is both RGBA8 and 32-bit heights.
fn plain_tile_bytes(records: &[FrameRecord]) -> Option<f64> {
    let has_uncounted = records.iter().any(|record| {
        (record.upload_dem_bytes > 0 && record.upload_dem_texels == 0)
            || (record.upload_dom_bytes > 0 && record.upload_dom_texels == 0)
    });
    let texels = records.iter().map(|record| record.upload_dem_texels + record.upload_dom_texels);
    if has_uncounted { None } else { mean(texels.map(|texels| 4.0 * texels as f64)) }
}

fn count(records: &[FrameRecord], is_counted: fn(&FrameRecord) -> bool) -> u64 {
    records.iter().filter(|record| is_counted(record)).count() as u64
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0_u32), |(sum, count), value| (sum + value, count + 1));
    (count > 0).then(|| sum / f64::from(count))
}

/// The mean of the values of each name.
fn means(values: impl Iterator<Item = (&'static str, f64)>) -> BTreeMap<&'static str, f64> {
    let mut sums: BTreeMap<&'static str, (f64, u32)> = BTreeMap::new();
    for (name, value) in values {
        let (sum, count) = sums.entry(name).or_default();
        *sum += value;
        *count += 1;
    }
    sums.into_iter().map(|(name, (sum, count))| (name, sum / f64::from(count))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_are_over_the_frames_that_have_a_value() {
        let mut records = vec![
            FrameRecord { frame_ms: 10.0, upload_bytes: 2048, ..Default::default() },
            FrameRecord { frame_ms: 30.0, tiles_missing: 2, select_ms: 1.0, ..Default::default() },
        ];
        records[1].errors.flip_mean = Some(0.25);
        let summary = RunSummary::of(&RunResult::of_records("a", records));
        assert_eq!((summary.frames, summary.measured_frames), (2, 1));
        assert_eq!((summary.error("flip_mean"), summary.upload_kib()), (0.25, 1.0));
        assert_eq!((summary.first_frame_upload_bytes, summary.later_upload_kib()), (2048, 0.0));
        assert_eq!((summary.frames_a_second(), summary.stage_ms["select_ms"]), (50.0, 0.5));
        assert!((summary.jank_sum_ms - (30.0 - 1000.0 / 60.0)).abs() < 1.0e-9);
        assert!(summary.error("ssim").is_nan());
    }

    #[test]
    fn plain_tiles_are_counted_or_not_known() {
        let frame = |upload_dem_bytes, upload_dem_texels, upload_dom_texels| FrameRecord {
            upload_dem_bytes,
            upload_dem_texels,
            upload_dom_texels,
            ..Default::default()
        };
        let plain =
            |records| RunSummary::of(&RunResult::of_records("a", records)).plain_tile_bytes_a_frame;
        assert_eq!(plain(vec![frame(200, 100, 0), frame(0, 0, 300)]), Some(800.0));
        assert_eq!(plain(vec![frame(200, 100, 0), frame(200, 0, 300)]), None);
    }

    #[test]
    fn one_jump_that_was_never_sharp_leaves_no_mean() {
        let sharp = |frames_until_sharp: Vec<Option<u64>>| {
            let run = RunResult { frames_until_sharp, ..RunResult::of_records("a", Vec::new()) };
            RunSummary::of(&run).frames_until_sharp
        };
        assert_eq!(sharp(vec![Some(2), Some(5)]), Some(3.5));
        assert_eq!((sharp(vec![Some(2), None]), sharp(Vec::new())), (None, None));
    }

    #[test]
    fn the_time_shown_is_the_time_named() {
        let summary = |gpu_ms: Option<f64>| {
            let first =
                FrameRecord { frame_ms: 900.0, cpu_ms: 800.0, gpu_ms, ..Default::default() };
            let later = FrameRecord { frame_ms: 30.0, cpu_ms: 3.0, gpu_ms, ..Default::default() };
            RunSummary::of(&RunResult::of_records("a", vec![first, later.clone(), later]))
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
