use glam::Vec2;

use super::page_atlas::PageAtlas;
use crate::gpu::atlas::AtlasGrid;
use crate::residency::page_table::{ChangedPage, PageLayout};

/// Group 2 of every pass that draws with a virtual texture or asks for its pages: how the texture is cut, the
/// page table's entries, and the atlas of its pages. Nothing of it depends on what is drawn.
pub(crate) struct PageBindings {
    pub layout: wgpu::BindGroupLayout,
    pub group: wgpu::BindGroup,
    uniforms: wgpu::Buffer,
    entries: wgpu::Buffer,
    atlas_columns: u32,
    written: Option<PageTableUniforms>,
}

/// The `PageTable` of `common/page_table.wgsl`, where the members are explained.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct PageTableUniforms {
    pub columns: u32,
    pub rows: u32,
    pub tile_texels: u32,
    pub gutter_texels: u32,
    pub coarsest_level: u32,
    pub first_resident_level: u32,
    pub round_texels: i32,
    pub padding: u32,
    pub data_first: [i32; 2],
    pub data_end: [i32; 2],
    pub uv_per_texel: Vec2,
    pub request_bias: f32,
    pub lookup_bias: f32,
    pub level_starts: [[u32; 4]; 7],
}

impl PageTableUniforms {
    /// Of a texture cut as `layout` says whose pages lie in an atlas cut as `grid` says. Pixels ask for pages
    /// `request_bias` levels coarser than their footprints, and are drawn from those `lookup_bias` coarser.
    pub fn new(
        layout: &PageLayout,
        grid: &AtlasGrid,
        [request_bias, lookup_bias]: [f32; 2],
    ) -> Self {
        let mut level_starts = [[0; 4]; 7];
        for (start, level) in level_starts.as_flattened_mut().iter_mut().zip(0..) {
            *start = layout.level_start(level);
        }
        Self {
            columns: layout.columns,
            rows: layout.rows,
            tile_texels: layout.tile_size_texels,
            gutter_texels: layout.gutter_texels,
            coarsest_level: u32::from(layout.coarsest_level),
            first_resident_level: u32::from(layout.first_resident_level()),
            round_texels: layout.round_texels,
            padding: 0,
            data_first: layout.data_first.to_array(),
            data_end: layout.data_end.to_array(),
            uv_per_texel: grid.uv_per_texel(),
            request_bias,
            lookup_bias,
            level_starts,
        }
    }
}

const FRAGMENT_AND_COMPUTE: wgpu::ShaderStages =
    wgpu::ShaderStages::FRAGMENT.union(wgpu::ShaderStages::COMPUTE);

impl PageBindings {
    /// The group the bindings are in.
    pub const GROUP: u32 = 2;

    /// Without any page yet: all entries are 0.
    pub fn new(device: &wgpu::Device, layout: &PageLayout, atlas: &PageAtlas) -> Self {
        use wgpu::BufferUsages as Usage;
        let buffer = |label, size, usage| {
            let mapped_at_creation = false;
            let usage = usage | Usage::COPY_DST;
            let label = Some(label);
            device.create_buffer(&wgpu::BufferDescriptor { label, size, usage, mapped_at_creation })
        };
        let size = size_of::<PageTableUniforms>() as u64;
        let uniforms = buffer("page table", size, Usage::UNIFORM);
        let entries = buffer("page entries", 4 * u64::from(layout.page_count()), Usage::STORAGE);
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("pages"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            mipmap_filter: wgpu::MipmapFilterMode::Linear,
            ..Default::default()
        });
        let group_layout = group_layout(device);
        let pages = atlas.view();
        let resources = [
            uniforms.as_entire_binding(),
            entries.as_entire_binding(),
            wgpu::BindingResource::TextureView(&pages),
            wgpu::BindingResource::Sampler(&sampler),
        ];
        let bound = (0..).zip(resources);
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("page table"),
            layout: &group_layout,
            entries: &bound
                .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
                .collect::<Vec<_>>(),
        });
        Self {
            layout: group_layout,
            group,
            uniforms,
            entries,
            atlas_columns: atlas.grid().columns,
            written: None,
        }
    }

    /// Writes the uniforms; returns the bytes sent, 0 where nothing changed.
    pub fn set_uniforms(&mut self, queue: &wgpu::Queue, uniforms: &PageTableUniforms) -> u64 {
        if self.written.as_ref() == Some(uniforms) {
            return 0;
        }
        queue.write_buffer(&self.uniforms, 0, bytemuck::bytes_of(uniforms));
        self.written = Some(*uniforms);
        size_of::<PageTableUniforms>() as u64
    }

    /// Writes entries that have changed, in order of their addresses; returns the bytes sent.
    pub fn set_entries(&self, queue: &wgpu::Queue, changed: &[ChangedPage]) -> u64 {
        for run in changed.chunk_by(|before, after| before.address + 1 == after.address) {
            let words = run.iter().map(|changed| self.word(changed)).collect::<Vec<_>>();
            let first = u64::from(run[0].address);
            queue.write_buffer(&self.entries, 4 * first, bytemuck::cast_slice(&words));
        }
        4 * changed.len() as u64
    }

    /// An entry as `common/page_colour.wgsl` explains it.
    fn word(&self, changed: &ChangedPage) -> u32 {
        let Some((slot, parts)) = changed.shown else { return 0 };
        let columns = self.atlas_columns.max(1);
        (slot % columns) | (slot / columns) << 8 | parts << 16
    }
}

fn group_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: FRAGMENT_AND_COMPUTE,
        ty,
        count: None,
    };
    let buffer =
        |ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
    let texture = wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: true },
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("page table"),
        entries: &[
            wgpu::BindGroupLayoutEntry {
                // Vertices ask too for the pages that triangles lie on.
                visibility: FRAGMENT_AND_COMPUTE | wgpu::ShaderStages::VERTEX,
                ..entry(0, buffer(wgpu::BufferBindingType::Uniform))
            },
            entry(1, buffer(wgpu::BufferBindingType::Storage { read_only: true })),
            entry(2, texture),
            entry(3, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering)),
        ],
    })
}
