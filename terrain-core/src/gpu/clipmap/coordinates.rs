use super::bindings::ClipBindings;
use super::mesh::ClipMeshBuffers;
use crate::gpu::coordinate_pass::{CoordinatePass, draw_full_coordinates};
use crate::gpu::frame_group::FrameGroup;
use crate::gpu::ground_pipeline::{SurfaceOptions, surface_pipeline};
use crate::gpu::picture::TargetKind;
use crate::gpu::shader_library::CLIPMAP_COORDINATES;

/// Draws where on the ground each pixel looks, into a texture of this size: east, north and up of the
/// eye, and 1; 0 in the last where there is sky. For measuring: everything is made anew.
pub(crate) fn draw_clip_coordinates(
    device: &wgpu::Device,
    encoder: &mut wgpu::CommandEncoder,
    (frame, clip): (&FrameGroup, &ClipBindings),
    mesh: &ClipMeshBuffers,
    size_px: [u32; 2],
) -> wgpu::Texture {
    let options = SurfaceOptions {
        groups: &[&frame.layout, &clip.layout],
        vertices: ClipMeshBuffers::instance_layout(),
        // A mean of places on either side of an edge would be a place on neither.
        target: TargetKind { format: CoordinatePass::FULL_FORMAT, samples: 1 },
        constants: &[],
        polygon_mode: wgpu::PolygonMode::Fill,
    };
    let entries = ("coordinate_vertex", "coordinate_fragment");
    let pipeline = surface_pipeline(device, &CLIPMAP_COORDINATES, entries, &options);
    draw_full_coordinates(device, encoder, size_px, |pass| {
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &frame.group, &[]);
        pass.set_bind_group(1, &clip.group, &[]);
        mesh.draw(pass);
    })
}
