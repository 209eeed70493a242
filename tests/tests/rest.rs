//! A still camera comes to rest: whatever the tiles do to the region seen, and the region to the tiles.

#![allow(clippy::unwrap_used, reason = "a step that fails fails the test")]
#![allow(clippy::print_stdout, reason = "measured values are to be seen")]

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use terrain_core::dataset::Dataset;
use terrain_core::gpu::{GpuContext, OFFSCREEN_FORMAT, OffscreenTarget};
use terrain_core::measure::Flight;
use terrain_core::prepare::{NoProgress, PrepareRequest, prepare};
use terrain_core::selection::Strategy;
use terrain_core::{RendererSettings, TerrainRenderer};
use terrain_tests::gpu;

const SIZE_PX: [u32; 2] = [640, 360];

/// Along the demo flight with a cache far too small for texels of half a pixel: every selection is
/// merged down to what fits, so a little more or less ground in view changes many tiles, and through
/// their heights the ground in view.
#[test]
fn where_tiles_and_region_feed_each_other_the_camera_still_comes_to_rest() {
    let Some(gpu) = gpu() else { return };
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/demo");
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("demo");
    let mut request = PrepareRequest::new(vec![data.join("dem.tif")], Vec::new(), out.clone());
    request.epsg = Some(3395);
    prepare(&request, &NoProgress, &AtomicBool::new(false)).unwrap();
    for strategy in [Strategy::RttQuadtree, Strategy::RttQuadtreeGpu, Strategy::PageTable] {
        comes_to_rest(&gpu, strategy, &data, &out);
    }
}

fn comes_to_rest(gpu: &Arc<GpuContext>, strategy: Strategy, data: &Path, out: &Path) {
    let flight = Flight::read(&data.join("flight.json")).unwrap();
    let settings = RendererSettings {
        strategy,
        texel_px: 0.5,
        vertical_exaggeration: 15.0,
        ..Default::default()
    };
    let source = Arc::new(Dataset::open(out).unwrap());
    let mut renderer = TerrainRenderer::new(Arc::clone(gpu), source, settings).unwrap();
    let target = OffscreenTarget::new(gpu, SIZE_PX);
    let mut most = 0;
    for frame in (560..574).chain(728..734) {
        let view = flight.view_at(flight.frame_time_s(frame), SIZE_PX);
        let record = renderer.render_settled(&view, target.view(), OFFSCREEN_FORMAT).unwrap();
        most = most.max(record.tiles_new);
        assert!(!renderer.needs_frame(&view), "{strategy}: frame {frame} goes on for ever");
    }
    println!("{strategy}: at most {most} tiles for a view");
    // Twice the cache; without a bound to it there were 1,682.
    assert!(most <= 72, "{strategy}: {most} tiles for one view");
}
