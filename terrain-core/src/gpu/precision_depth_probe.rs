//! Asks the device's own depth test which surfaces it tells apart.

use encase::{ShaderType, UniformBuffer};
use glam::{Mat4, UVec2, Vec2, vec2};
use wgpu::util::DeviceExt;

use super::context::{GpuContext, GpuError};
use super::offscreen_target::read_texture;
use super::shader_library::PRECISION_DEPTH;
use crate::CameraView;
use crate::precision::depth::{DepthGrid, DepthKind};

/// The twin of `Projection` in `precision_depth.wgsl`.
#[derive(ShaderType)]
pub(crate) struct Projection {
    clip_from_relative: Mat4,
    half_size: Vec2,
    cells: UVec2,
}

const MARK_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R8Unorm;

/// Draws the surfaces of every cell, the farther first, and tells row by row of the grid where the nearer
/// one was seen.
///
/// # Errors
/// [`GpuError::Lost`] where the device fails.
pub fn probe_depth(
    gpu: &GpuContext,
    kind: DepthKind,
    grid: &DepthGrid,
) -> Result<Vec<bool>, GpuError> {
    let size_px = [grid.distances_m.len() as u32, grid.gaps.len() as u32];
    let pipeline = pipeline(gpu, kind);
    let group = bindings(gpu, &pipeline, kind, grid, size_px);
    let picture = texture(gpu, MARK_FORMAT, size_px, wgpu::TextureUsages::COPY_SRC);
    let depth = texture(gpu, depth_format(kind), size_px, wgpu::TextureUsages::empty());
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let view = |texture: &wgpu::Texture| texture.create_view(&Default::default());
    let (picture_view, depth_view) = (view(&picture), view(&depth));
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("precision depth"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: &picture_view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                store: wgpu::StoreOp::Store,
            },
        })],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &depth_view,
            depth_ops: Some(wgpu::Operations {
                load: wgpu::LoadOp::Clear(if kind.is_reverse() { 0.0 } else { 1.0 }),
                store: wgpu::StoreOp::Discard,
            }),
            stencil_ops: None,
        }),
        ..Default::default()
    });
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.draw(0..4, 0..2 * size_px[0] * size_px[1]);
    drop(pass);
    gpu.queue.submit([encoder.finish()]);
    let marks = read_texture(gpu, &picture, size_px, 1)?;
    // The grid's first row is drawn at the bottom.
    let rows = marks.chunks(size_px[0] as usize).rev();
    Ok(rows.flatten().map(|mark| *mark > 0).collect())
}

fn depth_format(kind: DepthKind) -> wgpu::TextureFormat {
    match kind {
        DepthKind::Usual24Bit => wgpu::TextureFormat::Depth24Plus,
        DepthKind::ReverseFloat | DepthKind::UsualFloat => super::DEPTH_FORMAT,
    }
}

fn bindings(
    gpu: &GpuContext,
    pipeline: &wgpu::RenderPipeline,
    kind: DepthKind,
    grid: &DepthGrid,
    size_px: [u32; 2],
) -> wgpu::BindGroup {
    let (columns, rows) = (grid.distances_m.len(), grid.gaps.len());
    let mut distances = grid.distances_m.clone();
    distances.extend(
        (0..rows).flat_map(|row| (0..columns).map(move |column| grid.farther_m(column, row))),
    );
    let buffer = |contents: &[u8], usage| {
        let label = Some("precision depth");
        gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label, contents, usage })
    };
    let projection = buffer(&projection(kind, size_px), wgpu::BufferUsages::UNIFORM);
    let distances = buffer(bytemuck::cast_slice(&distances), wgpu::BufferUsages::STORAGE);
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("precision depth"),
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[
            wgpu::BindGroupEntry { binding: 0, resource: projection.as_entire_binding() },
            wgpu::BindGroupEntry { binding: 1, resource: distances.as_entire_binding() },
        ],
    })
}

/// A camera that looks north with a right angle of view, as the uniform's bytes.
fn projection(kind: DepthKind, size_px: [u32; 2]) -> Vec<u8> {
    let view = CameraView {
        eye: glam::DVec3::ZERO,
        heading_deg: 0.0,
        pitch_deg: 0.0,
        fov_y_deg: 90.0,
        viewport_px: size_px,
    };
    let projection = Projection {
        clip_from_relative: kind.clip_from_relative(&view),
        half_size: vec2(view.aspect() as f32, 1.0),
        cells: UVec2::from(size_px),
    };
    let mut buffer = UniformBuffer::new(Vec::new());
    #[expect(clippy::expect_used, reason = "a Vec grows as needed: writing cannot fail")]
    buffer.write(&projection).expect("writing into a Vec");
    buffer.into_inner()
}

fn texture(
    gpu: &GpuContext,
    format: wgpu::TextureFormat,
    size_px: [u32; 2],
    more_usage: wgpu::TextureUsages,
) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("precision depth"),
        size: wgpu::Extent3d { width: size_px[0], height: size_px[1], depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | more_usage,
        view_formats: &[],
    })
}

fn pipeline(gpu: &GpuContext, kind: DepthKind) -> wgpu::RenderPipeline {
    let module = PRECISION_DEPTH.module(&gpu.device);
    let nearer = if kind.is_reverse() {
        wgpu::CompareFunction::Greater
    } else {
        wgpu::CompareFunction::Less
    };
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("precision depth"),
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("square"),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState {
            topology: wgpu::PrimitiveTopology::TriangleStrip,
            ..Default::default()
        },
        depth_stencil: Some(wgpu::DepthStencilState {
            format: depth_format(kind),
            depth_write_enabled: Some(true),
            depth_compare: Some(nearer),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("mark"),
            compilation_options: Default::default(),
            targets: &[Some(MARK_FORMAT.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}
