use std::ops::Range;

use crate::gpu::coordinate_pass::target_texture;
use crate::gpu::frame_group::FrameGroup;
use crate::gpu::page_table::{PageBindings, PageMarks};
use crate::gpu::shader_library::Shader;
use crate::residency::page_table::{FaceCulling, PageLayout};

/// The `TextureMap` of `common/texture_map.wgsl`, where the members are explained.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct TextureMapUniforms {
    pub cells: [u32; 2],
    pub cell_texels: u32,
    pub cells_per_page_log2: u32,
    pub viewport_px: [f32; 2],
    pub ranges: u32,
    pub padding: u32,
}

impl TextureMapUniforms {
    /// Most cells along a side of the map.
    const MOST_CELLS: u32 = 8_192;
    /// Most halvings of a page's side: cells as large as what a few of the mesh's triangles show. Smaller ones
    /// would only draw more of them.
    const MOST_HALVINGS: u32 = 2;

    /// Of the map of a texture cut as `layout` says, for a picture of this size and so many ranges of triangles: as
    /// many cells as may be, and whole texels to a cell.
    pub fn new(layout: &PageLayout, viewport_px: [u32; 2], ranges: u32) -> Self {
        let longest = layout.columns.max(layout.rows);
        let fits = |halvings: &u32| {
            longest << halvings <= Self::MOST_CELLS
                && layout.tile_size_texels.trailing_zeros() >= *halvings
        };
        let halvings = (0..=Self::MOST_HALVINGS).rev().find(fits).unwrap_or(0);
        Self {
            cells: [layout.columns << halvings, layout.rows << halvings],
            cell_texels: layout.tile_size_texels >> halvings,
            cells_per_page_log2: halvings,
            viewport_px: viewport_px.map(|px| px as f32),
            ranges,
            padding: 0,
        }
    }
}

/// Lays triangles into the map and marks the pages that they show.
///
/// Back faces are dropped before their rasterisation, in one of two ways, or in every cell, for comparison; see
/// [`FaceCulling`].
pub(crate) struct TextureMapPass {
    draw: wgpu::RenderPipeline,
    /// Only where a pass before the drawing drops triangles.
    keep: Option<KeepTriangles>,
    /// What the cells are drawn into. Nothing of it is kept: the marks are.
    target: wgpu::TextureView,
}

/// Tells which triangles are laid into the map.
struct KeepTriangles {
    pipeline: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
    kept: wgpu::Buffer,
    indirect: wgpu::Buffer,
}

/// What the passes read: groups 0 and 1 to 3 but for what the map itself brings.
#[derive(Clone, Copy)]
pub(crate) struct MapBindings<'a> {
    pub frame: &'a FrameGroup,
    pub marks: &'a PageMarks,
    pub pages: &'a PageBindings,
    pub triangles: (&'a wgpu::BindGroupLayout, &'a wgpu::BindGroup),
}

/// The triangles to be laid into the map.
pub(crate) struct MapTriangles {
    /// Their numbers.
    pub runs: Vec<Range<u32>>,
    /// Ranges of them as `triangle_in_range` knows them.
    pub ranges: u32,
    /// Triangles of the longest range.
    pub longest_range: u32,
}

impl TextureMapPass {
    const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R8Unorm;
    /// Corners of the rectangle that a triangle is drawn as.
    const CORNERS: u32 = 6;
    const WORKGROUP: u32 = 64;
    const TRIANGLES_GROUP: u32 = 3;

    /// A pass with a shader over triangles of some kind, of which there are at most so many.
    pub fn new(
        device: &wgpu::Device,
        (shader, bindings): (&Shader, &MapBindings<'_>),
        map: &TextureMapUniforms,
        (culling, anisotropy): (FaceCulling, u32),
        most_triangles: u32,
    ) -> Self {
        let usage = wgpu::TextureUsages::empty();
        let target = target_texture(device, "texture map", map.cells, Self::FORMAT, usage);
        let keep = (culling == FaceCulling::Compute)
            .then(|| KeepTriangles::new(device, shader, bindings, most_triangles));
        Self {
            draw: draw_pipeline(device, shader, bindings, (culling, anisotropy)),
            keep,
            target: target.create_view(&Default::default()),
        }
    }

    /// Records the marking of all pages that the triangles show.
    pub fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        bindings: &MapBindings<'_>,
        triangles: &MapTriangles,
    ) {
        if let Some(keep) = &self.keep {
            keep.record(encoder, bindings, triangles);
        }
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("texture map"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.target,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Discard,
                },
            })],
            ..Default::default()
        });
        pass.set_pipeline(&self.draw);
        pass.set_bind_group(0, &bindings.frame.group, &[]);
        pass.set_bind_group(PageMarks::GROUP, &bindings.marks.group, &[]);
        pass.set_bind_group(PageBindings::GROUP, &bindings.pages.group, &[]);
        pass.set_bind_group(Self::TRIANGLES_GROUP, bindings.triangles.1, &[]);
        match &self.keep {
            Some(keep) => {
                pass.set_vertex_buffer(0, keep.kept.slice(..));
                pass.draw_indirect(&keep.indirect, 0);
            }
            None => {
                for run in &triangles.runs {
                    pass.draw(0..Self::CORNERS, run.clone());
                }
            }
        }
    }
}

impl KeepTriangles {
    fn new(
        device: &wgpu::Device,
        shader: &Shader,
        bindings: &MapBindings<'_>,
        most_triangles: u32,
    ) -> Self {
        let buffer = |label, size, usage| {
            let usage = usage | wgpu::BufferUsages::STORAGE;
            let mapped_at_creation = false;
            let label = Some(label);
            device.create_buffer(&wgpu::BufferDescriptor { label, size, usage, mapped_at_creation })
        };
        use wgpu::BufferUsages as Usage;
        let most = u64::from(most_triangles.max(1));
        let kept = buffer("kept triangles", 4 * most, Usage::VERTEX);
        let indirect = buffer("kept draw", 16, Usage::INDIRECT | Usage::COPY_DST);
        let entry = |binding| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Storage { read_only: false },
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        };
        let group_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("kept triangles"),
            entries: &[entry(2), entry(3)],
        });
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("kept triangles"),
            layout: &group_layout,
            entries: &[
                wgpu::BindGroupEntry { binding: 2, resource: kept.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 3, resource: indirect.as_entire_binding() },
            ],
        });
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("keep triangles"),
            bind_group_layouts: &[
                Some(&bindings.frame.layout),
                Some(&group_layout),
                Some(&bindings.pages.layout),
                Some(bindings.triangles.0),
            ],
            immediate_size: 0,
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("keep triangles"),
            layout: Some(&layout),
            module: &shader.module(device),
            entry_point: Some("keep_triangles"),
            compilation_options: Default::default(),
            cache: None,
        });
        Self { pipeline, group, kept, indirect }
    }

    fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        bindings: &MapBindings<'_>,
        triangles: &MapTriangles,
    ) {
        encoder.clear_buffer(&self.indirect, 0, None);
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("keep triangles"),
            timestamp_writes: None,
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &bindings.frame.group, &[]);
        pass.set_bind_group(1, &self.group, &[]);
        pass.set_bind_group(PageBindings::GROUP, &bindings.pages.group, &[]);
        pass.set_bind_group(TextureMapPass::TRIANGLES_GROUP, bindings.triangles.1, &[]);
        let across = triangles.longest_range.div_ceil(TextureMapPass::WORKGROUP);
        pass.dispatch_workgroups(across, triangles.ranges, 1);
    }
}

fn draw_pipeline(
    device: &wgpu::Device,
    shader: &Shader,
    bindings: &MapBindings<'_>,
    (culling, anisotropy): (FaceCulling, u32),
) -> wgpu::RenderPipeline {
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(shader.name),
        bind_group_layouts: &[
            Some(&bindings.frame.layout),
            Some(&bindings.marks.layout),
            Some(&bindings.pages.layout),
            Some(bindings.triangles.0),
        ],
        immediate_size: 0,
    });
    let module = shader.module(device);
    let back_faces = match culling {
        FaceCulling::Compute => 0.0,
        FaceCulling::Vertex => 1.0,
        FaceCulling::Fragment => 2.0,
    };
    let constants = [("BACK_FACES", back_faces), ("ANISOTROPY", f64::from(anisotropy))];
    let compilation =
        || wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() };
    let is_compute = culling == FaceCulling::Compute;
    let with_kept = [Some(wgpu::VertexBufferLayout {
        array_stride: 4,
        step_mode: wgpu::VertexStepMode::Instance,
        attributes: &wgpu::vertex_attr_array![0 => Uint32],
    })];
    let target = wgpu::ColorTargetState {
        format: TextureMapPass::FORMAT,
        blend: None,
        write_mask: wgpu::ColorWrites::empty(),
    };
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(shader.name),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some(if is_compute { "map_kept" } else { "map_all" }),
            compilation_options: compilation(),
            buffers: if is_compute { &with_kept } else { &[] },
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("mark_cell"),
            compilation_options: compilation(),
            targets: &[Some(target)],
        }),
        multiview_mask: None,
        cache: None,
    })
}
