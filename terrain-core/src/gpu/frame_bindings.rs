use super::colour_atlas::ColourAtlas;
use super::frame_uniforms::FrameUniforms;
use super::height_atlas::HeightAtlas;
use super::offset_table_buffer::OffsetTableBuffer;

/// Groups 0 and 1 of every drawing pass: the frame's uniforms, and the cached terrain.
pub(crate) struct FrameBindings {
    pub frame_layout: wgpu::BindGroupLayout,
    pub terrain_layout: wgpu::BindGroupLayout,
    pub frame: wgpu::BindGroup,
    pub terrain: wgpu::BindGroup,
    uniforms: wgpu::Buffer,
    sampler: wgpu::Sampler,
    views: AtlasViews,
    written: Option<FrameUniforms>,
}

struct AtlasViews {
    heights: wgpu::TextureView,
    slopes: wgpu::TextureView,
    colours: wgpu::TextureView,
}

impl FrameBindings {
    pub fn new(
        device: &wgpu::Device,
        table: &OffsetTableBuffer,
        heights: &HeightAtlas,
        colours: &ColourAtlas,
    ) -> Self {
        let frame_layout = frame_layout(device);
        let terrain_layout = terrain_layout(device);
        let uniforms = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("frame uniforms"),
            size: FrameUniforms::BYTES,
            usage: wgpu::BufferUsages::UNIFORM
                | wgpu::BufferUsages::COPY_DST
                | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        let frame = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("frame"),
            layout: &frame_layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: uniforms.as_entire_binding() }],
        });
        let views = AtlasViews {
            heights: heights.heights.create_view(&Default::default()),
            slopes: heights.slopes.create_view(&Default::default()),
            colours: colours.colours.create_view(&Default::default()),
        };
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("atlas"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            mipmap_filter: wgpu::MipmapFilterMode::Linear,
            ..Default::default()
        });
        let terrain = bind_terrain(device, &terrain_layout, table, &views, &sampler);
        Self {
            frame_layout,
            terrain_layout,
            frame,
            terrain,
            uniforms,
            sampler,
            views,
            written: None,
        }
    }

    /// Binds the tables anew after their buffers grew.
    pub fn rebind(&mut self, device: &wgpu::Device, table: &OffsetTableBuffer) {
        self.terrain =
            bind_terrain(device, &self.terrain_layout, table, &self.views, &self.sampler);
    }

    #[cfg(test)]
    pub(super) fn uniforms(&self) -> &wgpu::Buffer {
        &self.uniforms
    }

    /// Records a copy of both tables' ranges from the beginning of `ranges` into the uniforms, which are
    /// written before the commands run.
    pub fn copy_table_ranges(&self, encoder: &mut wgpu::CommandEncoder, ranges: &wgpu::Buffer) {
        let offset = FrameUniforms::TABLE_RANGES_OFFSET;
        let bytes = FrameUniforms::BYTES - offset;
        encoder.copy_buffer_to_buffer(ranges, 0, &self.uniforms, offset, bytes);
    }

    /// Writes the uniforms; returns the bytes sent, 0 where nothing changed.
    pub fn set_uniforms(&mut self, queue: &wgpu::Queue, uniforms: &FrameUniforms) -> u64 {
        if self.written.as_ref() == Some(uniforms) {
            return 0;
        }
        queue.write_buffer(&self.uniforms, 0, &uniforms.to_bytes());
        self.written = Some(*uniforms);
        FrameUniforms::BYTES
    }
}

const ALL_STAGES: wgpu::ShaderStages =
    wgpu::ShaderStages::VERTEX_FRAGMENT.union(wgpu::ShaderStages::COMPUTE);
const FRAGMENT_AND_COMPUTE: wgpu::ShaderStages =
    wgpu::ShaderStages::FRAGMENT.union(wgpu::ShaderStages::COMPUTE);

fn frame_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("frame"),
        entries: &[wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility: ALL_STAGES,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Uniform,
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        }],
    })
}

fn terrain_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let layout_entry = |binding, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: FRAGMENT_AND_COMPUTE,
        ty,
        count: None,
    };
    let storage = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Storage { read_only: true },
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    let texture = |filterable| wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable },
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("terrain"),
        entries: &[
            layout_entry(0, storage),
            layout_entry(1, storage),
            layout_entry(2, texture(false)),
            layout_entry(3, texture(true)),
            layout_entry(4, sampler),
            layout_entry(5, texture(true)),
        ],
    })
}

fn bind_terrain(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    table: &OffsetTableBuffer,
    views: &AtlasViews,
    sampler: &wgpu::Sampler,
) -> wgpu::BindGroup {
    use wgpu::BindingResource::{Sampler, TextureView};
    let resources = [
        table.entries.as_entire_binding(),
        table.nodes.as_entire_binding(),
        TextureView(&views.heights),
        TextureView(&views.slopes),
        Sampler(sampler),
        TextureView(&views.colours),
    ];
    let entries = (0..)
        .zip(resources)
        .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
        .collect::<Vec<_>>();
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("terrain"),
        layout,
        entries: &entries,
    })
}
