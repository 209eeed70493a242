//! What a frame did, for those who measure.

use std::time::Instant;

use super::TerrainRenderer;
use crate::measure::FrameRecord;
use crate::method::Moved;
use crate::selection::Strategy;

impl TerrainRenderer {
    /// Milliseconds the GPU took for the latest picture whose timestamps have come back: after a wait
    /// for the GPU, for the picture drawn last. `None` without timestamps.
    pub fn latest_gpu_ms(&mut self) -> Option<f64> {
        // A failure of the device shows in the next check.
        let _ = self.gpu.device.poll(wgpu::PollType::Poll);
        self.timer.latest_ms()
    }

    /// Fills in what the frame just recorded did, times left out.
    pub(super) fn describe(&mut self, record: &mut FrameRecord, moved: Moved) {
        let strategy = self.tin.as_ref().map_or(self.settings.strategy, |_| Strategy::PageTable);
        record.strategy = strategy.to_string();
        record.frame = self.frame;
        record.gpu_ms = self.timer.latest_ms();
        (record.tiles_new, record.tiles_evicted) = (moved.new, moved.evicted);
        self.method.describe(&self.settings, record);
        if let Some(objects) = &self.objects {
            objects.describe(record);
        }
        record.set_bytes(&self.ledger.take());
    }
}

/// Tells how long each stage of a frame took.
pub(super) struct StageClock(Instant);

impl StageClock {
    pub fn new() -> Self {
        Self(Instant::now())
    }

    /// Milliseconds since the last call.
    pub fn ms(&mut self) -> f64 {
        let now = Instant::now();
        let stage = now - std::mem::replace(&mut self.0, now);
        stage.as_secs_f64() * 1.0e3
    }
}
