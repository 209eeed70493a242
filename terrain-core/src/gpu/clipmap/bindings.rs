use super::levels::{ClipFrame, ClipLevel};
use super::textures::ClipTextures;

/// Group 1 of the clipmap's drawing passes: what shows where, and the textures.
pub(crate) struct ClipBindings {
    pub layout: wgpu::BindGroupLayout,
    pub group: wgpu::BindGroup,
    frame: wgpu::Buffer,
    levels: wgpu::Buffer,
    sampler: wgpu::Sampler,
    written_frame: Option<ClipFrame>,
    written_levels: Vec<ClipLevel>,
}

impl ClipBindings {
    /// Levels the list has room for, both layers together; `MOST_LEVELS` of the shaders.
    pub const MOST_LEVELS: usize = 50;

    pub fn new(device: &wgpu::Device, textures: &ClipTextures) -> Self {
        let layout = layout(device);
        let buffer = |label, size| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        let frame = buffer("clip frame", size_of::<ClipFrame>() as u64);
        let levels = buffer("clip levels", (Self::MOST_LEVELS * size_of::<ClipLevel>()) as u64);
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("clip"),
            address_mode_u: wgpu::AddressMode::Repeat,
            address_mode_v: wgpu::AddressMode::Repeat,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        let group = bind(device, &layout, [&frame, &levels], textures, &sampler);
        Self {
            layout,
            group,
            frame,
            levels,
            sampler,
            written_frame: None,
            written_levels: Vec::new(),
        }
    }

    /// Binds other textures.
    pub fn rebind(&mut self, device: &wgpu::Device, textures: &ClipTextures) {
        let buffers = [&self.frame, &self.levels];
        self.group = bind(device, &self.layout, buffers, textures, &self.sampler);
    }

    /// Brings the levels in use to the GPU; returns the bytes sent, 0 where nothing changed.
    pub fn set_levels(&mut self, queue: &wgpu::Queue, mut levels: Vec<ClipLevel>) -> u64 {
        levels.truncate(Self::MOST_LEVELS);
        if self.written_levels == levels {
            return 0;
        }
        let bytes: &[u8] = bytemuck::cast_slice(&levels);
        queue.write_buffer(&self.levels, 0, bytes);
        let sent = bytes.len() as u64;
        self.written_levels = levels;
        sent
    }

    /// Brings the rest to the GPU; returns the bytes sent, 0 where nothing changed.
    pub fn set_frame(&mut self, queue: &wgpu::Queue, frame: &ClipFrame) -> u64 {
        if self.written_frame.as_ref() == Some(frame) {
            return 0;
        }
        queue.write_buffer(&self.frame, 0, bytemuck::bytes_of(frame));
        self.written_frame = Some(*frame);
        size_of::<ClipFrame>() as u64
    }
}

fn layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let entry = |binding, visibility, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility,
        ty,
        count: None,
    };
    let uniform = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Uniform,
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    let texture = |filterable| wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable },
        view_dimension: wgpu::TextureViewDimension::D2Array,
        multisampled: false,
    };
    let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
    use wgpu::ShaderStages as Stages;
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("clipmap"),
        entries: &[
            entry(0, Stages::VERTEX_FRAGMENT, uniform),
            entry(1, Stages::VERTEX_FRAGMENT, uniform),
            entry(2, Stages::VERTEX, texture(false)),
            entry(3, Stages::FRAGMENT, texture(true)),
            entry(4, Stages::FRAGMENT, sampler),
            entry(5, Stages::FRAGMENT, texture(true)),
        ],
    })
}

fn bind(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    [frame, levels]: [&wgpu::Buffer; 2],
    textures: &ClipTextures,
    sampler: &wgpu::Sampler,
) -> wgpu::BindGroup {
    let [heights, slopes, colours] =
        [&textures.heights, &textures.slopes, textures.colours()].map(ClipTextures::all_levels);
    use wgpu::BindingResource::{Sampler, TextureView};
    let resources = [
        frame.as_entire_binding(),
        levels.as_entire_binding(),
        TextureView(&heights),
        TextureView(&slopes),
        Sampler(sampler),
        TextureView(&colours),
    ];
    let entries = (0..)
        .zip(resources)
        .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
        .collect::<Vec<_>>();
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("clipmap"),
        layout,
        entries: &entries,
    })
}
