//! The pictures of the renderer's own textures show what is in them.

#![allow(clippy::expect_used, reason = "a step that fails fails the test")]

use std::sync::Arc;

use glam::{DVec2, dvec2};
use terrain_core::gpu::{
    DEBUG_IMAGE_FORMAT, DebugImage, GpuContext, OFFSCREEN_FORMAT, OffscreenTarget,
};
use terrain_core::{CameraView, RendererSettings, TerrainRenderer};
use terrain_tests::{AnalyticSource, Surface, gpu};

const ROOT_SIZE_M: f64 = 12_800.0;
/// Rows of 64 RGBA pixels are as long as a copy's rows must be: 256 bytes.
const SIDE_PX: u32 = 64;
const COLOUR: [u8; 3] = [200, 100, 50];

/// Rises by a tenth to the east; 0 in the middle.
fn slope(point: DVec2) -> f64 {
    0.1 * point.x
}

/// A renderer of a dataset of one tile, in caches of one slot, after a look straight down.
fn renderer(gpu: &Arc<GpuContext>) -> anyhow::Result<TerrainRenderer> {
    let surface = Surface { height_m: slope, colour: |_| COLOUR };
    let source = AnalyticSource::new(surface, DVec2::ZERO, ROOT_SIZE_M, [1, 1]);
    let settings =
        RendererSettings { cache_columns: 1, cache_rows: 1, max_tiles: 1, ..Default::default() };
    let mut renderer = TerrainRenderer::new(Arc::clone(gpu), Arc::new(source), settings)?;
    let view = CameraView {
        eye: dvec2(0.0, 0.0).extend(4_000.0),
        heading_deg: 0.0,
        pitch_deg: -90.0,
        fov_y_deg: 60.0,
        viewport_px: [64, 36],
    };
    let target = OffscreenTarget::new(gpu, view.viewport_px);
    renderer.render_settled(&view, target.view(), OFFSCREEN_FORMAT)?;
    Ok(renderer)
}

/// The picture, RGBA, first row on top.
fn picture(gpu: &GpuContext, renderer: &mut TerrainRenderer, image: DebugImage) -> Vec<[u8; 4]> {
    let size = wgpu::Extent3d { width: SIDE_PX, height: SIDE_PX, depth_or_array_layers: 1 };
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: DEBUG_IMAGE_FORMAT,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    renderer.draw_debug_image(image, &texture.create_view(&Default::default()), [SIDE_PX; 2]);
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(4 * SIDE_PX * SIDE_PX),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let layout = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(4 * SIDE_PX),
        rows_per_image: None,
    };
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let target = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), target, size);
    gpu.queue.submit([encoder.finish()]);
    buffer.map_async(wgpu::MapMode::Read, .., |_| {});
    gpu.wait().expect("the device works");
    let bytes = buffer.get_mapped_range(..).expect("the picture was mapped");
    bytes.chunks_exact(4).map(|texel| [texel[0], texel[1], texel[2], texel[3]]).collect()
}

fn at(picture: &[[u8; 4]], x: u32, y: u32) -> [u8; 4] {
    picture[(y * SIDE_PX + x) as usize]
}

#[test]
fn heights_go_from_dark_to_bright_over_the_datasets_range() -> anyhow::Result<()> {
    let Some(gpu) = gpu() else { return Ok(()) };
    let mut renderer = renderer(&gpu)?;
    let range = renderer.tree().height_ranges.range(terrain_core::tiling::TileId::ROOT);
    let range = range.expect("the dataset has heights");
    let picture = picture(&gpu, &mut renderer, DebugImage::HeightCache);
    // A slot is the tile's 128 texels and 4 of gutter on either side.
    let stored_m = ROOT_SIZE_M * 136.0 / 128.0;
    for x in [0, 10, 31, 32, 50, 63] {
        let east_m = (f64::from(x) + 0.5) / f64::from(SIDE_PX) * stored_m - 0.5 * stored_m;
        let share = (0.1 * east_m - f64::from(range.min_m)) / f64::from(range.max_m - range.min_m);
        let expected = 255.0 * share.clamp(0.0, 1.0);
        let [red, green, blue, _] = at(&picture, x, 20);
        assert!((f64::from(red) - expected).abs() < 2.5, "{red} is not {expected} at {x}");
        assert!(red == green && green == blue, "grey");
    }
    Ok(())
}

#[test]
fn imagery_is_shown_in_its_own_colours() -> anyhow::Result<()> {
    let Some(gpu) = gpu() else { return Ok(()) };
    let picture = picture(&gpu, &mut renderer(&gpu)?, DebugImage::ColourCache);
    for texel in picture {
        for (shown, stored) in texel.into_iter().zip(COLOUR) {
            assert!(shown.abs_diff(stored) <= 1, "{texel:?} is not {COLOUR:?}");
        }
    }
    Ok(())
}

#[test]
fn coordinates_redden_to_the_east_and_green_to_the_north() -> anyhow::Result<()> {
    let Some(gpu) = gpu() else { return Ok(()) };
    let picture = picture(&gpu, &mut renderer(&gpu)?, DebugImage::Coordinates);
    let [west, middle, east] = [2, 32, 61].map(|x| at(&picture, x, 32));
    let [north, south] = [2, 61].map(|y| at(&picture, 32, y));
    assert!(west[0] < middle[0] && middle[0] < east[0], "{west:?} {middle:?} {east:?}");
    assert!(south[1] < middle[1] && middle[1] < north[1], "{south:?} {middle:?} {north:?}");
    assert!(middle[0].abs_diff(128) < 6 && middle[1].abs_diff(128) < 6, "{middle:?}");
    Ok(())
}
