use super::page_bindings::PageBindings;
use super::page_marks::PageMarks;
use super::request_image::RequestImage;
use crate::gpu::shader_library::GATHER_PAGES;

/// The second stage of finding visible pages: all that pixels ask for, marked.
pub(crate) struct GatherPagesPass {
    pipeline: wgpu::ComputePipeline,
    group_layout: wgpu::BindGroupLayout,
}

impl GatherPagesPass {
    /// Pixels along the side of a block that one invocation looks through: 2^p.
    pub const BLOCK_PX: u32 = 4;
    const WORKGROUP: u32 = 8;

    pub fn new(device: &wgpu::Device, marks: &PageMarks, pages: &PageBindings) -> Self {
        let group_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("gather pages"),
            entries: &[wgpu::BindGroupLayoutEntry {
                binding: 0,
                visibility: wgpu::ShaderStages::COMPUTE,
                ty: wgpu::BindingType::Texture {
                    sample_type: wgpu::TextureSampleType::Uint,
                    view_dimension: wgpu::TextureViewDimension::D2,
                    multisampled: false,
                },
                count: None,
            }],
        });
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(GATHER_PAGES.name),
            bind_group_layouts: &[Some(&group_layout), Some(&marks.layout), Some(&pages.layout)],
            immediate_size: 0,
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("mark pages"),
            layout: Some(&layout),
            module: &GATHER_PAGES.module(device),
            entry_point: Some("mark_pages"),
            compilation_options: Default::default(),
            cache: None,
        });
        Self { pipeline, group_layout }
    }

    /// Records both stages, the list's among them.
    pub fn record(
        &self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        image: &RequestImage,
        marks: &PageMarks,
        pages: &PageBindings,
    ) {
        marks.clear(encoder);
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("gather pages"),
            layout: &self.group_layout,
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::TextureView(&image.view),
            }],
        });
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("gather pages"),
            timestamp_writes: None,
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.set_bind_group(PageMarks::GROUP, &marks.group, &[]);
        pass.set_bind_group(PageBindings::GROUP, &pages.group, &[]);
        let group_px = Self::BLOCK_PX * Self::WORKGROUP;
        let [across, down] = image.size_px().map(|px| px.div_ceil(group_px));
        pass.dispatch_workgroups(across, down, 1);
        marks.complete(&mut pass, pages);
    }
}
