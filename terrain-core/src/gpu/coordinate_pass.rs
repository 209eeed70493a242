use super::DEPTH_FORMAT;
use super::frame_bindings::FrameBindings;
use super::ground_pipeline::{SurfaceOptions, surface_pipeline};
use super::mesh_buffers::MeshBuffers;
use super::picture::TargetKind;
use super::shader_library::COORDINATES;
use super::terrain_pass::draw_blocks;
use crate::surface::CircularMesh;

/// Draws where on the ground each pixel looks, into a float texture of its own size.
pub(crate) struct CoordinatePass {
    pipeline: wgpu::RenderPipeline,
    pub target: wgpu::Texture,
    pub target_view: wgpu::TextureView,
    depth_view: wgpu::TextureView,
}

impl CoordinatePass {
    /// The format selection reads back: x and y.
    pub const REGION_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rg32Float;
    /// The format measurement reads back: x, y, z and whether there is ground.
    pub const FULL_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;
    /// What a pixel without ground holds in every channel. No offset in metres comes near it.
    pub const SKY: f32 = 3.0e38;

    pub fn new(
        device: &wgpu::Device,
        bindings: &FrameBindings,
        format: wgpu::TextureFormat,
        size_px: [u32; 2],
    ) -> Self {
        let entries = ("coordinate_vertex", "coordinate_fragment");
        let options = SurfaceOptions {
            groups: &bindings.layouts(),
            vertices: MeshBuffers::vertex_layout(),
            // A mean of places on either side of an edge would be a place on neither.
            target: TargetKind { format, samples: 1 },
            constants: &[],
            polygon_mode: wgpu::PolygonMode::Fill,
        };
        let pipeline = surface_pipeline(device, &COORDINATES, entries, &options);
        let texture = |label, format, usage| target_texture(device, label, size_px, format, usage);
        use wgpu::TextureUsages as Usage;
        let shown = Usage::COPY_SRC | Usage::TEXTURE_BINDING;
        let target = texture("coordinates", format, shown);
        let depth = texture("coordinate depth", DEPTH_FORMAT, Usage::empty());
        Self {
            pipeline,
            target_view: target.create_view(&Default::default()),
            depth_view: depth.create_view(&Default::default()),
            target,
        }
    }

    /// Records the pass over the visible blocks.
    pub fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        bindings: &FrameBindings,
        mesh: (&CircularMesh, &MeshBuffers),
        visible: &[u32],
    ) {
        let sky = f64::from(Self::SKY);
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("coordinates"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.target_view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color { r: sky, g: sky, b: sky, a: 0.0 }),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(depth_attachment(&self.depth_view)),
            ..Default::default()
        });
        pass.set_pipeline(&self.pipeline);
        draw_blocks(&mut pass, bindings, mesh, &mesh.1.indices, visible);
    }
}

/// A new texture of one mip and sample that is drawn into.
pub(super) fn target_texture(
    device: &wgpu::Device,
    label: &str,
    [width, height]: [u32; 2],
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: usage | wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    })
}

/// A new texture of this size in [`CoordinatePass::FULL_FORMAT`] that `draw_ground` has drawn into: where on
/// the ground each pixel looks, and 1; 0 in the last channel where there is sky.
pub(super) fn draw_full_coordinates(
    device: &wgpu::Device,
    encoder: &mut wgpu::CommandEncoder,
    size_px: [u32; 2],
    draw_ground: impl FnOnce(&mut wgpu::RenderPass<'_>),
) -> wgpu::Texture {
    let format = CoordinatePass::FULL_FORMAT;
    let texture = |label, format, usage| target_texture(device, label, size_px, format, usage);
    use wgpu::TextureUsages as Usage;
    let target = texture("coordinates", format, Usage::COPY_SRC);
    let depth = texture("coordinate depth", DEPTH_FORMAT, Usage::empty());
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
    draw_ground(&mut pass);
    drop(pass);
    target
}

/// A depth attachment cleared to infinitely far and not kept.
pub(crate) fn depth_attachment(
    view: &wgpu::TextureView,
) -> wgpu::RenderPassDepthStencilAttachment<'_> {
    wgpu::RenderPassDepthStencilAttachment {
        view,
        depth_ops: Some(wgpu::Operations {
            load: wgpu::LoadOp::Clear(0.0),
            store: wgpu::StoreOp::Discard,
        }),
        stencil_ops: None,
    }
}
