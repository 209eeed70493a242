use wgpu::util::DeviceExt;

use super::cover_pipeline::cover_pipeline;
use super::shader_library::DEBUG_IMAGE;

/// The format debug images are drawn in: plain, because they hold colours as they are to be seen.
pub const DEBUG_IMAGE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// One of the renderer's own textures, to be looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DebugImage {
    /// What the coordinate pass drew last: offsets from the eye, east as red and north as green.
    Coordinates,
    /// The cache texture of the heights, from the lowest in the dataset (black) to the highest.
    HeightCache,
    /// The cache texture of the imagery.
    ColourCache,
}

/// Draws debug images.
pub(crate) struct DebugImagePass {
    layout: wgpu::BindGroupLayout,
    pipelines: [wgpu::RenderPipeline; 3],
}

/// What to draw and how.
pub(crate) struct DebugImageSource<'a> {
    pub image: DebugImage,
    /// One mip of the texture; `None` where there is none: all black.
    pub texture: Option<&'a wgpu::TextureView>,
    /// What is drawn darkest and brightest, metres. For coordinates the second is the offset that
    /// is drawn three quarters bright.
    pub range_m: [f32; 2],
}

impl DebugImagePass {
    pub fn new(device: &wgpu::Device) -> Self {
        let layout = layout(device);
        let module = DEBUG_IMAGE.module(device);
        let entries = ["show_coordinates", "show_heights", "show_colours"];
        let pipelines = entries.map(|entry| pipeline(device, &layout, &module, entry));
        Self { layout, pipelines }
    }

    /// Draws the source over the whole target, which has [`DEBUG_IMAGE_FORMAT`].
    pub fn record(
        &self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        source: &DebugImageSource<'_>,
        (target, size_px): (&wgpu::TextureView, [u32; 2]),
    ) {
        let bindings =
            source.texture.map(|texture| self.bind(device, texture, source.range_m, size_px));
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("debug image"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: target,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: wgpu::StoreOp::Store,
                },
            })],
            ..Default::default()
        });
        let Some(bindings) = bindings else { return };
        pass.set_pipeline(match source.image {
            DebugImage::Coordinates => &self.pipelines[0],
            DebugImage::HeightCache => &self.pipelines[1],
            DebugImage::ColourCache => &self.pipelines[2],
        });
        pass.set_bind_group(0, &bindings, &[]);
        pass.draw(0..3, 0..1);
    }

    fn bind(
        &self,
        device: &wgpu::Device,
        texture: &wgpu::TextureView,
        [low, high]: [f32; 2],
        [width, height]: [u32; 2],
    ) -> wgpu::BindGroup {
        let range = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("debug image range"),
            contents: bytemuck::cast_slice(&[low, high, width as f32, height as f32]),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("debug image"),
            layout: &self.layout,
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::TextureView(texture),
                },
                wgpu::BindGroupEntry { binding: 1, resource: range.as_entire_binding() },
            ],
        })
    }
}

fn layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty,
        count: None,
    };
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("debug image"),
        entries: &[
            entry(
                0,
                wgpu::BindingType::Texture {
                    sample_type: wgpu::TextureSampleType::Float { filterable: false },
                    view_dimension: wgpu::TextureViewDimension::D2,
                    multisampled: false,
                },
            ),
            entry(
                1,
                wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Uniform,
                    has_dynamic_offset: false,
                    min_binding_size: wgpu::BufferSize::new(16),
                },
            ),
        ],
    })
}

fn pipeline(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    module: &wgpu::ShaderModule,
    fragment_entry: &str,
) -> wgpu::RenderPipeline {
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("debug image"),
        bind_group_layouts: &[Some(layout)],
        immediate_size: 0,
    });
    let stage = (fragment_entry, DEBUG_IMAGE_FORMAT);
    cover_pipeline(device, "debug image", Some(&layout), module, stage)
}
