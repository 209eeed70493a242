//! Measuring a flight: drawn pictures against exact ones, and that measuring changes nothing.

#![allow(clippy::unwrap_used, reason = "a step that fails fails the test")]
#![allow(clippy::print_stdout, reason = "measured values are to be seen")]

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::{DVec2, DVec3};
use terrain_core::dataset::TileSource;
use terrain_core::gpu::{GpuContext, OFFSCREEN_FORMAT, OffscreenTarget};
use terrain_core::measure::FrameRecord;
use terrain_core::measure::error::{DrawnPicture, PictureDeviation, Spread, true_heights_m};
use terrain_core::measure::motion::{popping, swim_px};
use terrain_core::prepare::NoProgress;
use terrain_core::reference::{ReferenceScene, ReferenceSettings, render_reference};
use terrain_core::{CameraView, RendererSettings, TerrainRenderer};
use terrain_tests::{AnalyticSource, Surface, gpu};

const SIZE_PX: [u32; 2] = [160, 90];

/// Hills of 300 m, 2 km apart, coloured in stripes.
fn hills() -> Arc<dyn TileSource> {
    let surface = Surface {
        height_m: |p| 150.0 * ((p.x / 320.0).sin() + (p.y / 410.0).cos()),
        colour: |p| if (p.x / 700.0).sin() > 0.0 { [190, 170, 120] } else { [70, 120, 60] },
    };
    Arc::new(AnalyticSource::new(surface, DVec2::new(500_000.0, 6_800_000.0), 32_768.0, [4, 3]))
}

fn view(step: f64) -> CameraView {
    CameraView {
        eye: DVec3::new(500_000.0 + 40.0 * step, 6_795_000.0 + 90.0 * step, 1_500.0),
        heading_deg: 10.0 + step,
        pitch_deg: -18.0,
        fov_y_deg: 50.0,
        viewport_px: SIZE_PX,
    }
}

struct Stage {
    gpu: Arc<GpuContext>,
    target: OffscreenTarget,
    renderer: TerrainRenderer,
}

impl Stage {
    fn new(gpu: Arc<GpuContext>, settings: RendererSettings) -> Self {
        let target = OffscreenTarget::new(&gpu, SIZE_PX);
        let renderer = TerrainRenderer::new(Arc::clone(&gpu), hills(), settings).unwrap();
        Self { gpu, target, renderer }
    }

    fn draw(&mut self, view: &CameraView) -> (FrameRecord, Vec<[u8; 4]>) {
        let target = self.target.view();
        let record = self.renderer.render_settled(view, target, OFFSCREEN_FORMAT).unwrap();
        (record, self.pixels())
    }

    fn redraw(&mut self, view: &CameraView) -> Vec<[u8; 4]> {
        self.renderer.redraw(view, self.target.view(), OFFSCREEN_FORMAT).unwrap();
        self.pixels()
    }

    fn pixels(&self) -> Vec<[u8; 4]> {
        self.target.read_rgba8(&self.gpu).unwrap().as_chunks().0.to_vec()
    }

    fn ground(&mut self, view: &CameraView) -> Vec<DVec3> {
        let points = self.renderer.drawn_coordinates(view).unwrap();
        points.into_iter().map(DVec3::from_array).collect()
    }

    fn deviation(&mut self, view: &CameraView) -> PictureDeviation {
        let (_, rgba) = self.draw(view);
        let ground = self.ground(view);
        let scene = ReferenceScene::open(hills()).unwrap();
        let settings = ReferenceSettings::of_renderer(self.renderer.settings());
        let cancelled = AtomicBool::new(false);
        let exact = render_reference(&scene, view, &settings, &NoProgress, &cancelled).unwrap();
        let true_z_m = true_heights_m(&scene, &ground, 1.0);
        let drawn = DrawnPicture { rgba: &rgba, ground: &ground };
        PictureDeviation::measure(view, 1.0, drawn, &exact, Some(&true_z_m)).unwrap()
    }
}

#[test]
fn measuring_beside_the_frames_changes_nothing_in_them() {
    let Some(gpu) = gpu() else { return };
    let mut plain = Stage::new(Arc::clone(&gpu), RendererSettings::default());
    let mut measured = Stage::new(gpu, RendererSettings::default());
    for (frame, step) in [0.0, 1.0, 1.0, 20.0].into_iter().enumerate() {
        let view = view(step);
        let (record, picture) = plain.draw(&view);
        if frame > 0 {
            measured.redraw(&view);
        }
        let (same_record, same_picture) = measured.draw(&view);
        measured.ground(&CameraView { heading_deg: 100.0, ..view });
        assert_eq!(record.without_times(), same_record.without_times(), "step {step}");
        assert_eq!(picture, same_picture, "step {step}");
        assert_eq!(measured.redraw(&view), picture, "nothing has arrived since");
    }
}

#[test]
fn settled_flights_move_the_same_bytes_however_fast_the_disk_is() {
    let Some(gpu) = gpu() else { return };
    let fly = || {
        let mut stage = Stage::new(Arc::clone(&gpu), RendererSettings::default());
        let steps = [0.0, 5.0, 30.0, 31.0];
        steps.map(|step| stage.draw(&view(step)).0.without_times())
    };
    assert_eq!(fly(), fly());
}

#[test]
fn finer_triangles_are_nearer_to_the_exact_picture() {
    let Some(gpu) = gpu() else { return };
    let deviation = |triangle_px| {
        let settings = RendererSettings { triangle_px, ..Default::default() };
        Stage::new(Arc::clone(&gpu), settings).deviation(&view(0.0))
    };
    let [coarse, fine] = [24.0, 2.0].map(deviation);
    println!("24 px triangles: {coarse:?}\n 2 px triangles: {fine:?}");
    let screen_px = |deviation: &PictureDeviation| deviation.screen_error_px.unwrap().p99;
    assert!(fine.flip.mean < 0.7 * coarse.flip.mean);
    assert!(screen_px(&fine) < 0.3 * screen_px(&coarse) && screen_px(&fine) < 0.5);
    assert!(fine.height.unwrap().rmse_m < 0.3 * coarse.height.unwrap().rmse_m);
    assert!(fine.psnr_db.unwrap() > coarse.psnr_db.unwrap() && fine.ssim > coarse.ssim);
}

#[test]
fn ground_swims_little_and_tiles_that_arrive_pop() {
    let Some(gpu) = gpu() else { return };
    let settings = RendererSettings { triangle_px: 4.0, ..Default::default() };
    let mut stage = Stage::new(gpu, settings);
    let (here, next) = (view(0.0), view(0.05));
    stage.draw(&here);
    let (before, after) = (stage.ground(&here), stage.ground(&next));
    let swim = Spread::of(swim_px(&next, &before, &after).unwrap()).unwrap();
    println!("swim of 4 px triangles: {swim:?} px a frame");
    assert!(swim.p50 < 0.02 && swim.p99 < 0.3, "{swim:?}");

    // Far away, only coarse tiles are there yet.
    let away = CameraView { eye: DVec3::new(508_000.0, 6_806_000.0, 900.0), ..view(0.0) };
    let coarse = stage.redraw(&away);
    let (record, fine) = stage.draw(&away);
    assert!(record.tiles_new > 0);
    assert!(popping(&coarse, &fine, SIZE_PX).unwrap().unwrap().mean > 0.01);
    let (record, same) = stage.draw(&away);
    assert_eq!(record.tiles_new, 0);
    assert_eq!(popping(&fine, &same, SIZE_PX).unwrap(), Some(Spread::default()));
}

#[test]
fn a_region_held_back_is_as_old_as_asked_for() {
    let Some(gpu) = gpu() else { return };
    for latency in [0, 2, 5] {
        let settings = RendererSettings { readback_latency_frames: latency, ..Default::default() };
        let mut stage = Stage::new(Arc::clone(&gpu), settings);
        let mut ages = Vec::new();
        for step in 0..16 {
            let target = stage.target.view();
            let record = stage.renderer.render(&view(f64::from(step)), target, OFFSCREEN_FORMAT);
            ages.push(record.unwrap().region_age_frames);
            stage.gpu.wait().unwrap();
        }
        // A frame's image cannot be back before the next frame.
        let expected = u64::from(latency).max(1);
        assert_eq!(ages[12..], [Some(expected); 4], "held back {latency} frames: {ages:?}");
    }
}
