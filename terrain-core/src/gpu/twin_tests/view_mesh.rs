use glam::IVec2;
use half::f16;

use super::gpu;
use crate::gpu::{GpuContext, ViewMeshBuffers};
use crate::surface::view_mesh::{MeshChanges, ViewVertex};

fn read(gpu: &GpuContext, buffer: &wgpu::Buffer) -> Vec<u32> {
    let readback = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: buffer.size(),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    encoder.copy_buffer_to_buffer(buffer, 0, &readback, 0, buffer.size());
    gpu.queue.submit([encoder.finish()]);
    readback.slice(..).map_async(wgpu::MapMode::Read, |_| ());
    gpu.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    gpu.check().unwrap();
    bytemuck::pod_collect_to_vec(&readback.slice(..).get_mapped_range().unwrap())
}

/// A number without a pattern.
fn noise(seed: u32) -> u32 {
    let mixed = (seed ^ (seed >> 15)).wrapping_mul(0x2c1b_3c6d);
    (mixed ^ (mixed >> 12)).wrapping_mul(0x297a_2d39) ^ (mixed >> 15)
}

fn vertex(seed: u32) -> ViewVertex {
    let unit = |salt: u32| (noise(seed ^ salt) >> 2) as i32;
    ViewVertex {
        // The root's far border, 2^30, is the largest position there is.
        position: if seed.is_multiple_of(7) {
            IVec2::splat(1 << 30)
        } else {
            IVec2::new(unit(0x1000), unit(0x2000))
        },
        height_m: noise(seed) as f32 * 1.0e-6,
        slope: [0.25 * (seed % 9) as f32 - 1.0, -0.125 * (seed % 5) as f32],
        coverage: [0.0, 0.25, 0.5, 0.75, 1.0][seed as usize % 5],
    }
}

/// The four words of a vertex, put together byte by byte.
fn words(vertex: &ViewVertex) -> [u32; 4] {
    let step = [(0.0, 0), (0.25, 1), (0.5, 2), (0.75, 2), (1.0, 3)]
        .into_iter()
        .find_map(|(part, step)| (part == vertex.coverage).then_some(step))
        .unwrap();
    let [east, north] = vertex.slope.map(|slope| f16::from_f32(slope).to_le_bytes());
    [
        vertex.position.x as u32 + 0x8000_0000 * (step % 2),
        vertex.position.y as u32 + 0x8000_0000 * (step / 2),
        u32::from_le_bytes(vertex.height_m.to_le_bytes()),
        u32::from_le_bytes([east[0], east[1], north[0], north[1]]),
    ]
}

#[test]
fn every_change_sent_arrives_where_it_belongs_and_nothing_else_changes() {
    let Some(gpu) = gpu() else { return };
    let mut buffers = ViewMeshBuffers::new(&gpu.device);
    let mut vertices: Vec<[u32; 4]> = Vec::new();
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    // Beyond what the buffers have room for at first, so that they grow with what is in them.
    for (round, size) in [100_u32, 9_000, 20_000, 20_000].into_iter().enumerate() {
        let some = |offset: u32| {
            let salt = offset + round as u32;
            (0..size).filter(move |&n| n >= size - 50 || noise(n + salt).is_multiple_of(3))
        };
        let changes = MeshChanges {
            vertices: some(0).map(|n| (n, vertex(n + round as u32))).collect(),
            triangles: some(7)
                .map(|n| (n, [noise(n), noise(n + 1), noise(n + 2)].map(|n| n >> 8)))
                .collect(),
        };
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let size = size as usize;
        let sent = buffers.update(&gpu, &mut encoder, (size, size), &changes);
        gpu.queue.submit([encoder.finish()]);
        let expected = ViewMeshBuffers::SENT_VERTEX_BYTES * changes.vertices.len() as u64
            + ViewMeshBuffers::SENT_TRIANGLE_BYTES * changes.triangles.len() as u64;
        assert_eq!(sent, 8 + expected);
        vertices.resize(size, [0; 4]);
        triangles.resize(size, [0; 3]);
        for (number, vertex) in &changes.vertices {
            vertices[*number as usize] = words(vertex);
        }
        for (place, corners) in &changes.triangles {
            triangles[*place as usize] = *corners;
        }
    }
    assert_eq!(read(&gpu, &buffers.vertices)[..4 * vertices.len()], *vertices.as_flattened());
    assert_eq!(read(&gpu, &buffers.indices)[..3 * triangles.len()], *triangles.as_flattened());
}
