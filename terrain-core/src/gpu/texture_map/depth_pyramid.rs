use wgpu::util::DeviceExt;

use crate::gpu::DEPTH_FORMAT;
use crate::gpu::coordinate_pass::{depth_attachment, target_texture};
use crate::gpu::shader_library::HALVE_DEPTH;

/// The farthest depth of a scene, mip by mip: whether something is hidden can be told from a few places, however
/// large it is (Greene, Kass and Miller, "Hierarchical Z-Buffer Visibility", 1993).
///
/// The mips lie in a buffer: fragments read each a mip of its own, which loads from textures did not do reliably on
/// lavapipe (Mesa 22.3).
pub(crate) struct DepthPyramid {
    size_px: [u32; 2],
    #[cfg(test)]
    pub scene_depth: wgpu::Texture,
    scene_view: wgpu::TextureView,
    depth: wgpu::TextureView,
    farthest: wgpu::Buffer,
    copy: wgpu::ComputePipeline,
    halve: wgpu::ComputePipeline,
    /// A group a mip.
    mips: Vec<(MipRange, wgpu::BindGroup)>,
}

/// Where a mip lies in the buffer: the first four members of the shader's `Mip`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct MipRange {
    pub start: u32,
    pub width: u32,
    pub height: u32,
    padding: u32,
}

impl MipRange {
    /// All mips of pictures of this size, each half as large as the one before, rounded down, but at least 1.
    pub fn of_size([width, height]: [u32; 2]) -> Vec<Self> {
        let mut start = 0;
        let mip = |mip: u32| {
            let [width, height] = [width, height].map(|px: u32| (px >> mip).max(1));
            let range = Self { start, width, height, padding: 0 };
            start += width * height;
            range
        };
        (0..=width.max(height).max(1).ilog2()).map(mip).collect()
    }
}

impl DepthPyramid {
    /// What the scene's depth is drawn into.
    pub const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;
    const WORKGROUP: u32 = 8;
    #[cfg(not(test))]
    const TEST_USAGE: wgpu::TextureUsages = wgpu::TextureUsages::empty();
    #[cfg(test)]
    const TEST_USAGE: wgpu::TextureUsages = wgpu::TextureUsages::COPY_DST;

    /// Of pictures of this size.
    pub fn new(device: &wgpu::Device, size_px: [u32; 2]) -> Self {
        let usage = wgpu::TextureUsages::TEXTURE_BINDING | Self::TEST_USAGE;
        let target = |label, format, usage| target_texture(device, label, size_px, format, usage);
        let scene_depth = target("scene depth", Self::FORMAT, usage);
        let depth = target("scene depth test", DEPTH_FORMAT, wgpu::TextureUsages::empty());
        let ranges = MipRange::of_size(size_px);
        let places = ranges.last().map_or(1, |last| last.start + last.width * last.height);
        let farthest = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("farthest depth"),
            size: 4 * u64::from(places),
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        let scene_view = scene_depth.create_view(&Default::default());
        let group_layout = group_layout(device);
        let mips = (0..ranges.len()).map(|mip| {
            let finer = ranges[mip.saturating_sub(1)];
            let uniform = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("mip"),
                contents: bytemuck::bytes_of(&[ranges[mip], finer]),
                usage: wgpu::BufferUsages::UNIFORM,
            });
            let resources = [
                wgpu::BindingResource::TextureView(&scene_view),
                farthest.as_entire_binding(),
                uniform.as_entire_binding(),
            ];
            let bound = (0..).zip(resources);
            let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("mip"),
                layout: &group_layout,
                entries: &bound
                    .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
                    .collect::<Vec<_>>(),
            });
            (ranges[mip], group)
        });
        Self {
            size_px,
            mips: mips.collect(),
            depth: depth.create_view(&Default::default()),
            copy: pipeline(device, &group_layout, "copy_depth"),
            halve: pipeline(device, &group_layout, "halve_depth"),
            #[cfg(test)]
            scene_depth,
            scene_view,
            farthest,
        }
    }

    /// The size it was made for.
    pub fn size_px(&self) -> [u32; 2] {
        self.size_px
    }

    /// All mips one after the other, as [`MipRange::of_size`] has them.
    pub fn farthest(&self) -> &wgpu::Buffer {
        &self.farthest
    }

    /// Records the depth of what `draw` draws, and its mips.
    pub fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        draw: impl FnOnce(&mut wgpu::RenderPass<'_>),
    ) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("scene depth"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.scene_view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(depth_attachment(&self.depth)),
            ..Default::default()
        });
        draw(&mut pass);
        drop(pass);
        self.halve(encoder);
    }

    /// Records the mips of the scene's depth.
    pub fn halve(&self, encoder: &mut wgpu::CommandEncoder) {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("halve depth"),
            timestamp_writes: None,
        });
        pass.set_pipeline(&self.copy);
        for (mip, (range, group)) in self.mips.iter().enumerate() {
            if mip == 1 {
                pass.set_pipeline(&self.halve);
            }
            pass.set_bind_group(0, group, &[]);
            let [across, down] = [range.width, range.height].map(|px| px.div_ceil(Self::WORKGROUP));
            pass.dispatch_workgroups(across, down, 1);
        }
    }
}

fn group_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty,
        count: None,
    };
    let buffer =
        |ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
    let depth = wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: false },
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("halve depth"),
        entries: &[
            entry(0, depth),
            entry(1, buffer(wgpu::BufferBindingType::Storage { read_only: false })),
            entry(2, buffer(wgpu::BufferBindingType::Uniform)),
        ],
    })
}

fn pipeline(
    device: &wgpu::Device,
    group: &wgpu::BindGroupLayout,
    entry: &str,
) -> wgpu::ComputePipeline {
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(entry),
        bind_group_layouts: &[Some(group)],
        immediate_size: 0,
    });
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(entry),
        layout: Some(&layout),
        module: &HALVE_DEPTH.module(device),
        entry_point: Some(entry),
        compilation_options: Default::default(),
        cache: None,
    })
}
