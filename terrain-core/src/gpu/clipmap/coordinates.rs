use super::bindings::ClipBindings;
use super::mesh::ClipMeshBuffers;
use super::pipeline::{ClipPipelineOptions, clip_pipeline};
use crate::gpu::DEPTH_FORMAT;
use crate::gpu::coordinate_pass::{CoordinatePass, depth_attachment};
use crate::gpu::frame_group::FrameGroup;
use crate::gpu::picture::TargetKind;
use crate::gpu::shader_library::CLIPMAP_COORDINATES;

/// Draws where on the ground each pixel looks, into a texture of this size: east, north and up of the
/// eye, and 1; 0 in the last where there is sky. For measuring: everything is made anew.
pub(crate) fn draw_clip_coordinates(
    device: &wgpu::Device,
    encoder: &mut wgpu::CommandEncoder,
    (frame, clip): (&FrameGroup, &ClipBindings),
    mesh: &ClipMeshBuffers,
    [width, height]: [u32; 2],
) -> wgpu::Texture {
    let format = CoordinatePass::FULL_FORMAT;
    let options = ClipPipelineOptions {
        // A mean of places on either side of an edge would be a place on neither.
        target: TargetKind { format, samples: 1 },
        constants: &[],
        polygon_mode: wgpu::PolygonMode::Fill,
    };
    let entries = ("coordinate_vertex", "coordinate_fragment");
    let pipeline = clip_pipeline(device, (frame, clip), &CLIPMAP_COORDINATES, entries, &options);
    let texture = |label, format, usage| {
        device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage,
            view_formats: &[],
        })
    };
    use wgpu::TextureUsages as Usage;
    let target = texture("coordinates", format, Usage::RENDER_ATTACHMENT | Usage::COPY_SRC);
    let depth = texture("coordinate depth", DEPTH_FORMAT, Usage::RENDER_ATTACHMENT);
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("coordinates"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: &target.create_view(&Default::default()),
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                store: wgpu::StoreOp::Store,
            },
        })],
        depth_stencil_attachment: Some(depth_attachment(&depth.create_view(&Default::default()))),
        ..Default::default()
    });
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &frame.group, &[]);
    pass.set_bind_group(1, &clip.group, &[]);
    mesh.draw(&mut pass);
    drop(pass);
    target
}
