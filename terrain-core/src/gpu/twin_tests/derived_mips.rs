use std::collections::HashMap;

use glam::{DVec2, dvec2};

use super::gpu;
use super::sampling::{COLUMNS, LAYOUT, Scene, mip_texel_m};
use crate::gpu::{GpuContext, read_texture};
use crate::tiling::TileId;

#[test]
fn neighbours_of_a_level_agree_bit_for_bit_along_their_border_at_every_mip() {
    let Some(gpu) = gpu() else { return };
    let mut scene = Scene::new(dvec2(0.0, 0.0));
    let block = (0..8).flat_map(|row| (0..8).map(move |column| TileId::new(5, row, column)));
    scene.residents = block.zip(0..).collect();
    let cache = scene.cache(&gpu);
    let slot_of: HashMap<_, _> = scene.residents.iter().copied().collect();
    for mip in 0..3u32 {
        let size = (COLUMNS * LAYOUT.stored_size_texels()) >> mip;
        let heights = read_mip(&gpu, &cache.heights.heights, mip, size, 4);
        let slopes = read_mip(&gpu, &cache.heights.slopes, mip, size, 8);
        for (&tile, &slot) in &slot_of {
            let Some(&east) = slot_of.get(&TileId { column: tile.column + 1, ..tile }) else {
                continue;
            };
            let compare = |bytes: &[u8], texel_bytes: u32, overlap: std::ops::Range<i64>| {
                for (row, column) in
                    (0..32 >> mip).flat_map(|r| overlap.clone().map(move |c| (r, c)))
                {
                    let at = |slot: u32, column: i64| {
                        let [x, y] = cache.heights.grid.slot_origin_texels(slot);
                        let x = i64::from((x + 4) >> mip) + column;
                        let y = i64::from((y + 4) >> mip) + row;
                        let start = ((y * i64::from(size) + x) * i64::from(texel_bytes)) as usize;
                        &bytes[start..start + texel_bytes as usize]
                    };
                    let width = 32i64 >> mip;
                    assert_eq!(at(slot, width + column), at(east, column), "{tile} mip {mip}");
                }
            };
            // Bilinear sampling at the border reads the texels right beside it on either side.
            compare(&heights, 4, -1..1);
            compare(&slopes, 8, -1..1);
        }
    }
}

/// Slope east and north at a whole texel of a mip, in f64: the mean of central differences at the
/// first two, the difference of the halves under the texel at the coarsest.
fn mip_slope(level: u8, mip: u32, row: i64, column: i64, texel_m: f64) -> DVec2 {
    let at = |mip, row, column| mip_texel_m(level, mip, row, column);
    let central = |row, column| {
        let east = at(0, row, column + 1) - at(0, row, column - 1);
        dvec2(east, at(0, row - 1, column) - at(0, row + 1, column)) / (2.0 * texel_m)
    };
    let (below, right) = (2 * row, 2 * column);
    let quad = [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(down, east)| (below + down, right + east));
    match mip {
        0 => central(row, column),
        1 => quad.map(|(row, column)| central(row, column)).iter().sum::<DVec2>() / 4.0,
        _ => {
            let [nw, ne, sw, se] = quad.map(|(row, column)| at(1, row, column));
            dvec2(ne + se - nw - sw, nw + ne - sw - se) / (2.0 * 2.0 * texel_m)
        }
    }
}

#[test]
fn slopes_are_those_of_the_heights_at_every_mip_up_to_the_border() {
    let Some(gpu) = gpu() else { return };
    let mut scene = Scene::new(dvec2(0.0, 0.0));
    let tile = TileId::new(5, 3, 6);
    scene.residents = vec![(tile, 9)];
    let cache = scene.cache(&gpu);
    let texel_m = LAYOUT.texel_size_m(&scene.tree.scheme, tile.level);
    for mip in 0..3u32 {
        let size = (COLUMNS * LAYOUT.stored_size_texels()) >> mip;
        let slopes = read_mip(&gpu, &cache.heights.slopes, mip, size, 8);
        let [x, y] = cache.heights.grid.slot_origin_texels(9).map(|corner| (corner + 4) >> mip);
        let width = 32i64 >> mip;
        // One texel of the gutter on each side is what filters at the border read.
        for (down, right) in (-1..=width).flat_map(|d| (-1..=width).map(move |r| (d, r))) {
            let texel = (i64::from(y) + down) * i64::from(size) + i64::from(x) + right;
            let bytes = &slopes[texel as usize * 8..][..8];
            let [east, north, coverage, _] = bytemuck::pod_read_unaligned::<[half::f16; 4]>(bytes);
            let row = i64::from(tile.row) * width + down;
            let column = i64::from(tile.column) * width + right;
            let expected = mip_slope(tile.level, mip, row, column, texel_m);
            let error = dvec2(f64::from(east), f64::from(north)) - expected;
            // Half floats keep 11 bits; slopes of the field reach 9.
            assert!(error.abs().max_element() < 0.008, "mip {mip} at {down}, {right}: {error}");
            assert_eq!(f32::from(coverage), 1.0, "mip {mip} at {down}, {right}");
        }
    }
}

fn read_mip(
    gpu: &GpuContext,
    texture: &wgpu::Texture,
    mip: u32,
    size: u32,
    texel_bytes: u32,
) -> Vec<u8> {
    let extent = wgpu::Extent3d { width: size, height: size, depth_or_array_layers: 1 };
    let copy = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: extent,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: texture.format(),
        usage: wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let source = wgpu::TexelCopyTextureInfo { mip_level: mip, ..texture.as_image_copy() };
    encoder.copy_texture_to_texture(source, copy.as_image_copy(), extent);
    gpu.queue.submit([encoder.finish()]);
    read_texture(gpu, &copy, [size, size], texel_bytes).unwrap()
}
