//! What a frame did, for those who measure.

use super::TerrainRenderer;
use crate::measure::FrameRecord;
use crate::method::Moved;

impl TerrainRenderer {
    /// Milliseconds the GPU took for the latest picture whose timestamps have come back: after a wait
    /// for the GPU, for the picture drawn last. `None` without timestamps.
    pub fn latest_gpu_ms(&mut self) -> Option<f64> {
        // A failure of the device shows in the next check.
        let _ = self.gpu.device.poll(wgpu::PollType::Poll);
        self.timer.latest_ms()
    }

    /// The record of the frame just recorded.
    pub(super) fn record(&mut self, moved: Moved, coordinate_pass_drawn: bool) -> FrameRecord {
        let mut record = FrameRecord {
            strategy: self.settings.strategy.to_string(),
            frame: self.frame,
            gpu_ms: self.timer.latest_ms(),
            tiles_new: moved.new,
            tiles_evicted: moved.evicted,
            coordinate_pass_drawn,
            ..Default::default()
        };
        self.method.describe(&self.settings, &mut record);
        record.set_bytes(&self.ledger.take());
        record
    }
}
