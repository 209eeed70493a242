//! There is ground wherever there is data, whatever the tiles and the device do.

use std::sync::Arc;

use glam::DVec2;
use terrain_core::dataset::{ColourTile, HeightTile, LoadError, Loaded, Manifest, TileSource};
use terrain_core::gpu::GpuContext;
use terrain_core::selection::Strategy;
use terrain_core::tiling::{TileId, TileSet};
use terrain_core::{CameraView, RendererSettings};
use terrain_tests::{Bench, Reluctant, Ridges};

use crate::drawn::{check, down, holes};

fn bench(gpu: &Arc<GpuContext>, strategy: Strategy, source: Arc<dyn TileSource>) -> Bench {
    let settings = RendererSettings { strategy, ..Default::default() };
    Bench::on(gpu, source, settings).unwrap()
}

pub fn ground_shows_from_any_height(gpu: &Arc<GpuContext>, strategy: Strategy) {
    let mut bench = bench(gpu, strategy, Ridges::source());
    for height_m in [1.0e5, 1.0e6, 1.0e7, 1.0e8] {
        let fov_y_deg = 2.0 * (15_000.0_f64 / height_m).atan().to_degrees();
        let view = CameraView { eye: DVec2::ZERO.extend(height_m), fov_y_deg, ..down() };
        check(&mut bench, "from high above", &view);
        assert_eq!(holes(&bench.picture().unwrap()), 0, "from {height_m} m");
    }
}

pub fn while_tiles_are_late_the_coarser_ones_show_and_no_frame_waits_for_them(
    gpu: &Arc<GpuContext>,
    strategy: Strategy,
) {
    let source = Reluctant::new(Ridges::source(), false);
    let mut bench = bench(gpu, strategy, source.clone());
    for frame in 0..12 {
        let record = bench.draw(&down()).unwrap();
        assert_eq!(holes(&bench.picture().unwrap()), 0, "frame {frame}");
        assert!(frame < 6 || record.tiles_missing > 0, "frame {frame}: nothing is late");
    }
    assert!(bench.renderer.needs_frame(&down()), "the late tiles are waited for");
    source.release();
    check(&mut bench, "all have come", &down());
    assert_eq!(holes(&bench.picture().unwrap()), 0);
}

pub fn tiles_that_cannot_be_loaded_are_named_and_leave_no_hole(
    gpu: &Arc<GpuContext>,
    strategy: Strategy,
) {
    let mut bench = bench(gpu, strategy, Reluctant::new(Ridges::source(), true));
    // At rest: what failed is not asked for for ever.
    check(&mut bench, "only level 0", &down());
    assert_eq!(holes(&bench.picture().unwrap()), 0);
    let failures = bench.renderer.take_failures();
    assert!(failures.iter().any(|failure| failure.contains("the disk has failed")), "{failures:?}");
    bench.settle(&down()).unwrap();
    assert!(bench.renderer.take_failures().is_empty(), "what failed is tried again");
}

/// A source whose height tiles of some level are damaged, and whose imagery is none.
struct Damaged {
    inner: Arc<dyn TileSource>,
    manifest: Manifest,
    no_colours: TileSet,
}

impl TileSource for Damaged {
    fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    fn heights_present(&self) -> &TileSet {
        self.inner.heights_present()
    }

    fn colours_present(&self) -> &TileSet {
        &self.no_colours
    }

    fn load_heights(&self, tile: TileId) -> Result<Loaded<HeightTile>, LoadError> {
        if tile.level == 3 {
            return Err(LoadError::Absent { path: "damaged".into(), tile });
        }
        self.inner.load_heights(tile)
    }

    fn load_colours(&self, tile: TileId) -> Result<Loaded<ColourTile>, LoadError> {
        Err(LoadError::Absent { path: "damaged".into(), tile })
    }
}

pub fn a_damaged_level_without_imagery_leaves_no_hole(gpu: &Arc<GpuContext>, strategy: Strategy) {
    let inner = Ridges::source();
    let manifest = Manifest { colours: None, ..inner.manifest().clone() };
    let damaged = Damaged { inner, manifest, no_colours: TileSet::new() };
    let mut bench = bench(gpu, strategy, Arc::new(damaged));
    let view = CameraView { pitch_deg: -60.0, ..down() };
    let drawn = check(&mut bench, "level 3 is damaged", &view);
    assert_eq!(drawn.ground().count(), drawn.points.len(), "there is a hole");
    let failures = bench.renderer.take_failures();
    assert!(failures.iter().any(|failure| failure.contains("no tile 3/")), "{failures:?}");
}

pub fn a_lost_device_is_an_error_not_a_panic(gpu: &Arc<GpuContext>, strategy: Strategy) {
    let mut bench = bench(gpu, strategy, Ridges::source());
    let mut view = down();
    bench.draw(&view).unwrap();
    bench.gpu.device.destroy();
    let failed = (0..4).any(|_| {
        // The loss is told once the work before it has ended.
        let _ = bench.gpu.wait();
        view.heading_deg += 1.0;
        bench.draw(&view).is_err()
    });
    assert!(failed, "frames go on without a device");
}
