//! The texture map's depth pyramid against a walk over all that a place covers.

use super::{gpu, mapped};
use crate::gpu::{DepthPyramid, MipRange};

#[test]
fn a_place_of_a_mip_is_the_farthest_of_all_it_covers() {
    let Some(gpu) = gpu() else { return };
    let size = [45_u32, 23];
    let pyramid = DepthPyramid::new(&gpu.device, size);
    let depth_at = |x: u32, y: u32| ((x * 7_919 + y * 104_729) % 9_973) as f32 / 9_973.0;
    let depths = (0..size[0] * size[1]).map(|i| depth_at(i % size[0], i / size[0]));
    gpu.queue.write_texture(
        pyramid.scene_depth.as_image_copy(),
        bytemuck::cast_slice(&depths.collect::<Vec<f32>>()),
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(4 * size[0]),
            rows_per_image: None,
        },
        pyramid.scene_depth.size(),
    );
    let back = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: pyramid.farthest().size(),
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    pyramid.halve(&mut encoder);
    encoder.copy_buffer_to_buffer(pyramid.farthest(), 0, &back, 0, back.size());
    gpu.queue.submit([encoder.finish()]);
    let found = bytemuck::pod_collect_to_vec::<u8, f32>(&mapped(&gpu, &back));
    let mut expected = Vec::new();
    for (mip, range) in MipRange::of_size(size).into_iter().enumerate() {
        // What is left over belongs to the outermost place.
        let end = |place: u32, count: u32, size: u32| {
            if place + 1 == count { size } else { (place + 1) << mip }
        };
        for (x, y) in (0..range.height).flat_map(|y| (0..range.width).map(move |x| (x, y))) {
            let rows = (y << mip)..end(y, range.height, size[1]);
            let columns = (x << mip)..end(x, range.width, size[0]);
            let covered = rows.flat_map(|y| columns.clone().map(move |x| depth_at(x, y)));
            expected.push(covered.fold(1.0, f32::min));
        }
    }
    assert_eq!(found, expected);
}
