//! What frames promise: nothing needless is done, nothing is ever missing from the picture, and the
//! picture does not depend on where on Earth the data lies.

#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a step that fails fails the test")]
#![allow(clippy::print_stdout, reason = "measured values are to be seen")]

use std::sync::Arc;
use std::time::Duration;

use glam::{DVec2, dvec2};
use terrain_core::dataset::TileSource;
use terrain_core::gpu::{GpuContext, OFFSCREEN_FORMAT, OffscreenTarget};
use terrain_core::tiling::TileId;
use terrain_core::{CameraView, LookupMethod, RendererSettings, TerrainRenderer};
use terrain_tests::{AnalyticSource, Picture, Reluctant, Surface, gpu};

const SIZE_PX: [u32; 2] = [320, 180];

fn hills() -> Surface {
    Surface {
        height_m: |p| {
            900.0 * (p.x / 4000.0).sin() * (p.y / 5000.0).cos() + 200.0 * (p.x / 900.0).sin()
        },
        colour: |p| {
            let odd = ((p.x / 700.0).floor() + (p.y / 700.0).floor()) as i64 & 1;
            if odd == 0 { [110, 130, 80] } else { [170, 150, 110] }
        },
    }
}

fn source_at(centre: DVec2) -> AnalyticSource {
    AnalyticSource::new(hills(), centre, 65_536.0, [6, 6])
}

fn view_at(centre: DVec2) -> CameraView {
    CameraView {
        eye: (centre + dvec2(-3_000.0, -12_000.0)).extend(2_500.0),
        heading_deg: 20.0,
        pitch_deg: -18.0,
        fov_y_deg: 50.0,
        viewport_px: SIZE_PX,
    }
}

struct Bench {
    gpu: Arc<GpuContext>,
    renderer: TerrainRenderer,
    target: OffscreenTarget,
}

impl Bench {
    fn new(source: Arc<dyn TileSource>, settings: RendererSettings) -> Option<Self> {
        let gpu = gpu()?;
        let renderer = TerrainRenderer::new(Arc::clone(&gpu), source, settings).unwrap();
        let target = OffscreenTarget::new(&gpu, SIZE_PX);
        Some(Self { gpu, renderer, target })
    }

    fn settled(&mut self, view: &CameraView) -> Picture {
        let target = self.target.view();
        self.renderer.render_settled(view, target, OFFSCREEN_FORMAT).unwrap();
        Picture::read(&self.gpu, &self.target).unwrap()
    }
}

/// The pictures of two renderers are the same but for rounding: which slot a tile comes to depends on
/// the order in which tiles were loaded (with a single loading thread the pictures are equal bit for bit),
/// and how a sampler's coordinates round depends on the slot.
fn assert_same(a: &Picture, b: &Picture) {
    let differences = a.rgba.iter().zip(&b.rgba).map(|(a, b)| a.abs_diff(*b));
    let most = differences.clone().max().unwrap_or(0);
    let count = differences.filter(|difference| *difference > 0).count();
    assert!(a.size_px == b.size_px && most <= 1, "the pictures differ by up to {most} of 255");
    assert!(count * 10_000 <= a.rgba.len(), "the pictures differ in {count} values");
}

#[test]
fn a_still_camera_costs_nothing_but_its_picture() {
    let source = Arc::new(source_at(DVec2::ZERO));
    let Some(mut bench) = Bench::new(source, RendererSettings::default()) else { return };
    let view = view_at(DVec2::ZERO);
    let first = bench.settled(&view);
    assert!(!bench.renderer.needs_frame(&view), "a window need not draw again");
    for _ in 0..3 {
        let record = bench.renderer.render(&view, bench.target.view(), OFFSCREEN_FORMAT).unwrap();
        assert_eq!(record.upload_bytes, 0, "{record:?}");
        assert_eq!((record.readback_bytes, record.disk_bytes), (0, 0), "{record:?}");
        assert_eq!((record.tiles_new, record.tiles_missing), (0, 0), "{record:?}");
        assert!(!record.coordinate_pass_drawn && record.select_ms == 0.0, "{record:?}");
    }
    assert!(Picture::read(&bench.gpu, &bench.target).unwrap() == first, "the picture changed");
    let turned = CameraView { heading_deg: view.heading_deg + 0.1, ..view };
    assert!(bench.renderer.needs_frame(&turned));
}

#[test]
fn the_same_data_ten_thousand_kilometres_away_gives_the_same_picture() {
    let far = dvec2(10_000_000.0, -10_000_000.0);
    let pictures = [DVec2::ZERO, far].map(|centre| {
        let source = Arc::new(source_at(centre));
        let mut bench = Bench::new(source, RendererSettings::default())?;
        Some(bench.settled(&view_at(centre)))
    });
    let [Some(near), Some(far)] = pictures else { return };
    assert_same(&near, &far);
}

#[test]
fn both_lookups_draw_the_same_picture() {
    let pictures = [LookupMethod::Descend, LookupMethod::Linear].map(|lookup| {
        let source = Arc::new(source_at(DVec2::ZERO));
        let mut bench = Bench::new(source, RendererSettings { lookup, ..Default::default() })?;
        Some(bench.settled(&view_at(DVec2::ZERO)))
    });
    let [Some(descend), Some(linear)] = pictures else { return };
    assert_same(&descend, &linear);
}

#[test]
fn the_picture_does_not_depend_on_the_way_there() {
    let high =
        CameraView { eye: DVec2::ZERO.extend(60_000.0), pitch_deg: -60.0, ..view_at(DVec2::ZERO) };
    let pictures = [true, false].map(|climbs| {
        let mut bench = Bench::new(Arc::new(source_at(DVec2::ZERO)), RendererSettings::default())?;
        if climbs {
            bench.settled(&view_at(DVec2::ZERO));
        }
        Some(bench.settled(&high))
    });
    let [Some(climbed), Some(fresh)] = pictures else { return };
    // Not so where fine tiles of the way there still show.
    assert_same(&climbed, &fresh);
}

#[test]
fn ground_shows_from_any_height() {
    let source = Arc::new(source_at(DVec2::ZERO));
    let Some(mut bench) = Bench::new(source, RendererSettings::default()) else { return };
    for height_m in [1.0e5, 1.0e6, 1.0e7, 1.0e8] {
        let fov_y_deg = 2.0 * (15_000.0_f64 / height_m).atan().to_degrees();
        let view = CameraView { eye: DVec2::ZERO.extend(height_m), fov_y_deg, ..down() };
        let picture = bench.settled(&view);
        assert_eq!(holes(&picture), 0, "from {height_m} m");
        let is_black = |pixel: &[u8]| pixel[..3] == [0, 0, 0];
        assert!(!picture.rgba.chunks_exact(4).any(is_black), "black from {height_m} m");
    }
}

fn reluctant(refuses: bool) -> Arc<Reluctant> {
    let inner = source_at(DVec2::ZERO);
    Reluctant::new(Arc::new(inner), refuses)
}

/// Straight down, the whole picture is ground: a pixel that is not is a hole.
fn down() -> CameraView {
    CameraView { pitch_deg: -90.0, eye: dvec2(0.0, 0.0).extend(6_000.0), ..view_at(DVec2::ZERO) }
}

fn holes(picture: &Picture) -> usize {
    // Ground is greener or redder than blue here; what lies behind it is blue.
    let is_hole = |pixel: &[u8]| pixel[2] > pixel[0] && pixel[2] > pixel[1];
    picture.rgba.chunks_exact(4).filter(|pixel| is_hole(pixel)).count()
}

#[test]
fn while_tiles_are_late_the_coarser_ones_show_and_no_frame_waits_for_them() {
    let source = reluctant(false);
    let Some(mut bench) = Bench::new(source.clone(), RendererSettings::default()) else { return };
    let view = down();
    let mut last_missing = 0;
    for _ in 0..12 {
        let record = bench.renderer.render(&view, bench.target.view(), OFFSCREEN_FORMAT).unwrap();
        let picture = Picture::read(&bench.gpu, &bench.target).unwrap();
        assert_eq!(holes(&picture), 0, "frame {}", record.frame);
        last_missing = record.tiles_missing;
    }
    assert!(last_missing > 0, "nothing was late");
    assert!(bench.renderer.needs_frame(&view), "the late tiles are waited for");
    source.release();
    let settled = bench.settled(&view);
    assert_eq!(holes(&settled), 0);
    assert!(!bench.renderer.needs_frame(&view));
}

#[test]
fn tiles_that_cannot_be_loaded_are_reported_and_leave_no_hole() {
    let source = reluctant(true);
    let Some(mut bench) = Bench::new(source, RendererSettings::default()) else { return };
    let view = down();
    let picture = bench.settled(&view);
    assert_eq!(holes(&picture), 0);
    let failures = bench.renderer.take_failures();
    assert!(failures.iter().any(|failure| failure.contains("the disk has failed")), "{failures:?}");
    assert!(!bench.renderer.needs_frame(&view), "what failed is not asked for for ever");
}

#[test]
fn a_view_of_the_sky_is_a_state() {
    let source = Arc::new(source_at(DVec2::ZERO));
    let Some(mut bench) = Bench::new(source, RendererSettings::default()) else { return };
    let up = CameraView { pitch_deg: 80.0, ..view_at(DVec2::ZERO) };
    bench.settled(&up);
    assert_eq!(bench.renderer.selection().tiles, [TileId::ROOT]);
    assert!(!bench.renderer.needs_frame(&up));
}

#[test]
fn a_lost_device_is_an_error_not_a_panic() {
    let source = Arc::new(source_at(DVec2::ZERO));
    let Some(mut bench) = Bench::new(source, RendererSettings::default()) else { return };
    let mut view = view_at(DVec2::ZERO);
    bench.renderer.render(&view, bench.target.view(), OFFSCREEN_FORMAT).unwrap();
    bench.gpu.device.destroy();
    let failed = (0..4).any(|_| {
        // The loss is told once the work before it has ended.
        let _ = bench.gpu.wait();
        view.heading_deg += 1.0;
        bench.renderer.render(&view, bench.target.view(), OFFSCREEN_FORMAT).is_err()
    });
    assert!(failed, "frames go on without a device");
}

#[test]
fn the_smallest_cache_still_draws() {
    let settings = RendererSettings {
        cache_columns: 1,
        cache_rows: 1,
        max_tiles: 1,
        upload_budget_bytes: 0,
        ..Default::default()
    };
    let source = Arc::new(source_at(DVec2::ZERO));
    let Some(mut bench) = Bench::new(source, settings) else { return };
    let picture = bench.settled(&down());
    assert_eq!(holes(&picture), 0);
    assert_eq!(bench.renderer.selection().tiles.len(), 1);
}

#[test]
fn a_change_of_the_cache_is_counted_and_one_too_large_is_refused() {
    let source = Arc::new(source_at(DVec2::ZERO));
    let Some(mut bench) = Bench::new(source, RendererSettings::default()) else { return };
    bench.settled(&down());
    let old = *bench.renderer.settings();
    let smaller = RendererSettings { cache_columns: 4, cache_rows: 4, max_tiles: 16, ..old };
    bench.renderer.set_settings(smaller).unwrap();
    let record = bench.renderer.render(&down(), bench.target.view(), OFFSCREEN_FORMAT).unwrap();
    assert!(record.upload_dem_bytes >= 136 * 136 * 4, "level 0 went up anew: {record:?}");
}

#[test]
fn a_cache_larger_than_a_texture_is_refused_and_the_old_one_stays() {
    let source = Arc::new(source_at(DVec2::ZERO).with_tile_sizes([128, 2048]));
    let old =
        RendererSettings { cache_columns: 2, cache_rows: 2, max_tiles: 4, ..Default::default() };
    let Some(mut bench) = Bench::new(source, old) else { return };
    let old = *bench.renderer.settings();
    let refused =
        bench.renderer.set_settings(RendererSettings { cache_columns: 40, ..old }).unwrap_err();
    assert!(refused.to_string().contains("choose a smaller cache"), "{refused}");
    assert_eq!(*bench.renderer.settings(), old);
    bench.settled(&down());
}

#[test]
fn the_budget_bounds_the_bytes_of_a_frame() {
    let budget = 700_000;
    let settings = RendererSettings { upload_budget_bytes: budget, ..Default::default() };
    let source = Arc::new(source_at(DVec2::ZERO));
    let Some(mut bench) = Bench::new(source, settings) else { return };
    let colour_tile = 392 * 392 * 4;
    for _ in 0..40 {
        let record = bench.renderer.render(&down(), bench.target.view(), OFFSCREEN_FORMAT).unwrap();
        // Heights come first; one tile of a layer goes through whatever is left.
        let most = budget + colour_tile;
        let tiles = record.upload_dem_bytes + record.upload_dom_bytes;
        assert!(tiles <= most, "{tiles} bytes in frame {}", record.frame);
        std::thread::sleep(Duration::from_millis(5));
    }
}
