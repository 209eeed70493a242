//! What a frame did, for those who measure.

use super::TerrainRenderer;
use crate::measure::FrameRecord;

impl TerrainRenderer {
    /// Milliseconds the GPU took for the latest picture whose timestamps have come back: after a wait
    /// for the GPU, for the picture drawn last. `None` without timestamps.
    pub fn latest_gpu_ms(&mut self) -> Option<f64> {
        // A failure of the device shows in the next check.
        let _ = self.gpu.device.poll(wgpu::PollType::Poll);
        self.timer.latest_ms()
    }

    /// The record of the frame just recorded: `new` tiles came, `evicted` made way.
    pub(super) fn record(
        &mut self,
        (new, evicted): (u64, u64),
        coordinate_pass_drawn: bool,
    ) -> FrameRecord {
        let (blocks, triangles) = self.meshes.picture().map_or((0, 0), |mesh| mesh.drawn());
        let mut record = FrameRecord {
            strategy: self.settings.strategy.to_string(),
            frame: self.frame,
            gpu_ms: self.timer.latest_ms(),
            tiles_selected: self.selection.tiles.len() as u64,
            tiles_new: new,
            tiles_missing: self.terrain.missing() as u64,
            tiles_evicted: evicted,
            tiles_resident: self.terrain.resident() as u64,
            region_age_frames: self.region_age_frames(),
            finest_level: self.selection.statistics.finest_level,
            coordinate_pass_drawn,
            blocks_drawn: blocks,
            triangles_drawn: triangles,
            ..Default::default()
        };
        record.set_bytes(&self.ledger.take());
        record
    }

    /// How many frames ago the region in use was seen; 0 where the camera has not moved since.
    fn region_age_frames(&self) -> Option<u64> {
        let state = self.region_in_use()?;
        let is_current = self.selected.is_some_and(|(view, _)| view == state.view);
        Some(if is_current { 0 } else { self.frame - state.frame })
    }
}
