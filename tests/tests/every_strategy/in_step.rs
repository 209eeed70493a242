//! Frames that wait for what earlier frames asked for, with tiles that come late.

use std::sync::Arc;

use glam::dvec3;
use terrain_core::RendererSettings;
use terrain_core::dataset::DelayedSource;
use terrain_core::gpu::GpuContext;
use terrain_core::measure::FrameRecord;
use terrain_core::selection::Strategy;
use terrain_tests::{Bench, Ridges};

/// What a frame chose, showed and moved.
fn told(record: &FrameRecord) -> [u64; 6] {
    let FrameRecord { tiles_selected, tiles_new, tiles_missing, .. } = *record;
    let bytes = [record.disk_bytes, record.upload_bytes, record.readback_bytes];
    [tiles_selected, tiles_new, tiles_missing, bytes[0], bytes[1], bytes[2]]
}

/// Twelve frames in step, after a jump from a settled view.
fn flown(gpu: &Arc<GpuContext>, strategy: Strategy, delay_frames: u32) -> Vec<[u64; 6]> {
    let source = Arc::new(DelayedSource { source: Ridges::source(), delay_frames });
    let settings = RendererSettings { strategy, ..Default::default() };
    let mut bench = Bench::on(gpu, source, settings).unwrap();
    bench.settle(&Ridges::view(0.0, -18.0, 2_500.0)).unwrap();
    let frame = |frame: u32| {
        let mut view = Ridges::view(4.0 * f64::from(frame), -18.0, 2_500.0);
        view.eye += dvec3(9_000.0, 14_000.0 + 90.0 * f64::from(frame), 0.0);
        bench.renderer.wait().unwrap();
        told(&bench.draw(&view).unwrap())
    };
    (0..12).map(frame).collect()
}

pub fn frames_in_step_are_the_same_on_every_run_and_late_tiles_come_late(
    gpu: &Arc<GpuContext>,
    strategy: Strategy,
) {
    const DELAY_FRAMES: u32 = 5;
    let frames = flown(gpu, strategy, DELAY_FRAMES);
    assert_eq!(frames, flown(gpu, strategy, DELAY_FRAMES), "of the same flight");
    // But for tiles that nobody wants any more, nothing comes before it is due.
    let first_read = |frames: &[[u64; 6]]| frames.iter().position(|told| told[3] > 0);
    let late = first_read(&frames).unwrap();
    let prompt = first_read(&flown(gpu, strategy, 0)).unwrap();
    assert!(prompt < late, "frame {late}, {prompt} without a delay");
}
