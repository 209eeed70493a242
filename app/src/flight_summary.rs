//! What a flight cost, all frames together.

use std::collections::BTreeMap;
use std::fmt::Write;

use serde::Serialize;
use terrain_core::measure::FrameRecord;

/// Sums and extremes over the frames of a flight.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FlightSummary {
    /// Frames drawn.
    pub frames: u64,
    /// Frames in which a tile that was wanted was not there yet.
    pub frames_with_missing_tiles: u64,
    /// All frames' time together, milliseconds.
    pub frame_ms_sum: f64,
    /// The longest frame, milliseconds.
    pub frame_ms_most: f64,
    /// Bytes by cause, as the columns of `frames.csv` are called.
    #[serde(flatten)]
    pub bytes: BTreeMap<&'static str, u64>,
}

impl FlightSummary {
    /// Takes a frame in.
    pub fn add(&mut self, record: &FrameRecord) {
        self.frames += 1;
        self.frames_with_missing_tiles += u64::from(record.tiles_missing > 0);
        self.frame_ms_sum += record.frame_ms;
        self.frame_ms_most = self.frame_ms_most.max(record.frame_ms);
        for (cause, bytes) in record.byte_columns() {
            *self.bytes.entry(cause).or_default() += bytes;
        }
    }

    /// The summary as lines for people.
    ///
    /// # Errors
    /// Never in practice: a string takes all that is written to it.
    pub fn page(&self) -> Result<String, std::fmt::Error> {
        let frames = self.frames.max(1) as f64;
        let mut page = String::new();
        let missing = self.frames_with_missing_tiles;
        writeln!(page, "frames          {}, {missing} of them with tiles missing", self.frames)?;
        let (mean, most) = (self.frame_ms_sum / frames, self.frame_ms_most);
        writeln!(page, "time            {mean:.1} ms a frame, {most:.1} ms the longest")?;
        for (cause, &bytes) in &self.bytes {
            let cause = cause.trim_end_matches("_bytes").replace('_', " ");
            writeln!(page, "{cause:<16}{:.2} KiB a frame", bytes as f64 / 1024.0 / frames)?;
        }
        Ok(page)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_are_over_all_frames() {
        let mut summary = FlightSummary::default();
        let frame = FrameRecord { upload_dem_bytes: 4096, frame_ms: 30.0, ..Default::default() };
        summary.add(&frame);
        summary.add(&FrameRecord { tiles_missing: 2, frame_ms: 10.0, ..Default::default() });
        let page = summary.page().unwrap();
        assert!(page.contains("frames          2, 1 of them"), "{page}");
        assert!(page.contains("20.0 ms a frame, 30.0 ms the longest"), "{page}");
        assert!(page.contains("upload dem      2.00 KiB a frame"), "{page}");
    }
}
