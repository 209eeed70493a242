use super::colour_atlas::ColourAtlas;
use super::frame_group::FrameGroup;
use super::height_atlas::HeightAtlas;
use super::offset_table_buffer::OffsetTableBuffer;

/// Groups 0 and 1 of every drawing pass: the frame's uniforms, and the cached terrain.
pub(crate) struct FrameBindings {
    pub frame: FrameGroup,
    pub terrain_layout: wgpu::BindGroupLayout,
    pub terrain: wgpu::BindGroup,
    sampler: wgpu::Sampler,
    views: AtlasViews,
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
        let terrain_layout = terrain_layout(device);
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
        let frame = FrameGroup::new(device);
        Self { frame, terrain_layout, terrain, sampler, views }
    }

    /// The layouts of both groups.
    pub fn layouts(&self) -> [&wgpu::BindGroupLayout; 2] {
        [&self.frame.layout, &self.terrain_layout]
    }

    /// Binds the tables anew after their buffers grew.
    pub fn rebind(&mut self, device: &wgpu::Device, table: &OffsetTableBuffer) {
        self.terrain =
            bind_terrain(device, &self.terrain_layout, table, &self.views, &self.sampler);
    }
}

const FRAGMENT_AND_COMPUTE: wgpu::ShaderStages =
    wgpu::ShaderStages::FRAGMENT.union(wgpu::ShaderStages::COMPUTE);

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
