use glam::dvec2;

use super::gpu;
use super::sampling::Scene;
use crate::CameraView;
use crate::frame_setup::frame_uniforms;
use crate::gpu::mesh_buffers::MeshBuffers;
use crate::gpu::{FrameBindings, GpuContext, MeshScene, SceneMeshes};
use crate::renderer_settings::RendererSettings;
use crate::tiling::FixedPosition;

pub const SCALE_M: f64 = 512.0;

/// Where the position lies in a displaced vertex: three floats.
const POSITION_OFFSET: usize = 40;

/// The scene as a view's mesh is made for it.
pub fn mesh_scene<'a>(scene: &'a Scene, view: &'a CameraView) -> MeshScene<'a> {
    MeshScene {
        view,
        scale_m: SCALE_M,
        radius: 90_000.0 / SCALE_M,
        height_range_m: [-250.0, 800.0],
        data_extent: &scene.tree.data_extent,
        triangle_px: 12.0,
        has_coordinates: true,
    }
}

/// Displaces the scene's mesh and reads every vertex back: x, y, z relative to the eye.
fn displaced(gpu: &GpuContext, scene: &Scene) -> (SceneMeshes, Vec<[f32; 3]>) {
    let mut cache = scene.cache(gpu);
    let view = scene.view();
    let tables = cache.update_tables(gpu, &scene.tree, view.eye.truncate(), &scene.table, None);
    let mut bindings =
        FrameBindings::new(&gpu.device, &cache.table, &cache.heights, &cache.colours);
    let mut uniforms = frame_uniforms(&view, &scene.tree, &RendererSettings::default(), SCALE_M);
    uniforms.height_table = tables.ranges[0];
    bindings.frame.set_uniforms(&gpu.queue, &uniforms);
    let mut meshes = SceneMeshes::new(&gpu.device, &bindings, false);
    meshes.set_up(&gpu.device, &gpu.queue, &mesh_scene(scene, &view));
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_compute_pass(&Default::default());
    meshes.displace(&mut pass, &bindings, [true, false]);
    drop(pass);
    let vertices = &meshes.picture().unwrap().parts().1.displaced;
    let readback = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: vertices.size(),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    encoder.copy_buffer_to_buffer(vertices, 0, &readback, 0, vertices.size());
    gpu.queue.submit([encoder.finish()]);
    readback.slice(..).map_async(wgpu::MapMode::Read, |_| ());
    gpu.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    gpu.check().unwrap();
    let bytes = readback.slice(..).get_mapped_range().unwrap();
    let position = |vertex: &[u8]| {
        let floats = &vertex[POSITION_OFFSET..POSITION_OFFSET + 12];
        bytemuck::pod_read_unaligned::<[f32; 3]>(floats)
    };
    let positions = bytes.chunks_exact(MeshBuffers::VERTEX_BYTES as usize).map(position).collect();
    drop(bytes);
    (meshes, positions)
}

/// The coordinates that the GPU draws are those of this mesh: here every visible vertex is held
/// against an f64 evaluation of the same mesh over the same tiles.
#[test]
fn displaced_vertices_are_an_f64_evaluation_of_the_same_mesh() {
    let Some(gpu) = gpu() else { return };
    let scene = Scene::new(dvec2(500_000.0, 6_800_000.0));
    let (meshes, positions) = displaced(&gpu, &scene);
    let mesh = meshes.picture().unwrap();
    let view = scene.view();
    let uniforms = frame_uniforms(&view, &scene.tree, &RendererSettings::default(), SCALE_M);
    let [x, y] = uniforms.anchor_fixed.to_array();
    let anchor = FixedPosition { x, y };
    let mut compared = 0;
    for &block in mesh.visible() {
        let block = mesh.mesh().blocks[block as usize];
        let own = block.vertex_start..block.vertex_start + block.vertex_count;
        for index in own.map(|index| index as usize) {
            let vertex = mesh.mesh().vertices[index];
            let [x, y, z] = positions[index];
            let lowest = uniforms.data_min_from_eye_m;
            let highest = uniforms.data_max_from_eye_m;
            let flat = glam::Vec2::from(vertex.offset) * SCALE_M as f32;
            assert_eq!([x, y], flat.clamp(lowest, highest).to_array(), "vertex {index}");
            let from_anchor = glam::vec2(x, y) - uniforms.anchor_from_eye_m;
            let position =
                FixedPosition::from_offset(anchor, from_anchor.to_array(), uniforms.units_per_m);
            let tile = scene.table.entries[scene.table.find_linear(position).unwrap()].tile;
            let offset_m = dvec2(f64::from(x), f64::from(y));
            let spacing_m = vertex.spacing * SCALE_M as f32;
            let Some(height_m) = scene.filtered_height_m(tile, offset_m, spacing_m) else {
                continue;
            };
            let error_m = (f64::from(z) - (height_m - view.eye.z)).abs();
            let tolerance_m = scene.tolerance_m(tile, offset_m);
            assert!(error_m < tolerance_m, "vertex {index} in {tile}: {error_m} m");
            compared += 1;
        }
    }
    assert!(compared > 5_000, "too few vertices were compared: {compared}");
}
