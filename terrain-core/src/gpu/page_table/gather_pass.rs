use super::page_bindings::PageBindings;
use super::request_image::RequestImage;
use crate::gpu::shader_library::GATHER_PAGES;
use crate::residency::page_table::PageLayout;

/// The second and third stage of finding visible pages: each page that pixels ask for once, on a list. As
/// [`unite`](crate::residency::page_table::unite) does it on the CPU, in no order.
pub(crate) struct GatherPagesPass {
    mark: wgpu::ComputePipeline,
    list_pipeline: wgpu::ComputePipeline,
    group_layout: wgpu::BindGroupLayout,
    /// U2.
    marks: wgpu::Buffer,
    /// U3.
    list: wgpu::Buffer,
}

impl GatherPagesPass {
    /// Most pages on a list. Where there are more, pixels left out are drawn coarser.
    pub const MOST_LISTED: u32 = 16_384;
    /// Bytes before the list's first page.
    pub const HEAD_BYTES: u64 = 8;
    pub const PAGE_BYTES: u64 = 8;
    /// Pixels along the side of a block that one invocation looks through: 2^p.
    pub const BLOCK_PX: u32 = 4;
    const WORKGROUP: [u32; 2] = [8, 64];

    pub fn new(device: &wgpu::Device, layout: &PageLayout, pages: &PageBindings) -> Self {
        let group_layout = group_layout(device);
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(GATHER_PAGES.name),
            bind_group_layouts: &[Some(&group_layout), None, Some(&pages.layout)],
            immediate_size: 0,
        });
        let module = GATHER_PAGES.module(device);
        let pipeline = |entry| {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry),
                layout: Some(&pipeline_layout),
                module: &module,
                entry_point: Some(entry),
                compilation_options: Default::default(),
                cache: None,
            })
        };
        let buffer = |label, size| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage: wgpu::BufferUsages::STORAGE
                    | wgpu::BufferUsages::COPY_SRC
                    | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        Self {
            mark: pipeline("mark_pages"),
            list_pipeline: pipeline("list_pages"),
            marks: buffer("page marks", 4 * u64::from(layout.page_count())),
            list: buffer("page list", Self::list_bytes(Self::MOST_LISTED)),
            group_layout,
        }
    }

    /// Bytes of a list of so many pages.
    pub fn list_bytes(listed: u32) -> u64 {
        Self::HEAD_BYTES + Self::PAGE_BYTES * u64::from(listed)
    }

    /// Records both stages.
    pub fn record(
        &self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        image: &RequestImage,
        pages: &PageBindings,
    ) {
        encoder.clear_buffer(&self.marks, 0, None);
        encoder.clear_buffer(&self.list, 0, Some(Self::HEAD_BYTES));
        let resources = [
            wgpu::BindingResource::TextureView(&image.view),
            self.marks.as_entire_binding(),
            self.list.as_entire_binding(),
        ];
        let bound = (0..).zip(resources);
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("gather pages"),
            layout: &self.group_layout,
            entries: &bound
                .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
                .collect::<Vec<_>>(),
        });
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("gather pages"),
            timestamp_writes: None,
        });
        pass.set_bind_group(0, &group, &[]);
        pass.set_bind_group(PageBindings::GROUP, &pages.group, &[]);
        pass.set_pipeline(&self.mark);
        let group_px = Self::BLOCK_PX * Self::WORKGROUP[0];
        let [across, down] = image.size_px().map(|px| px.div_ceil(group_px));
        pass.dispatch_workgroups(across, down, 1);
        pass.set_pipeline(&self.list_pipeline);
        pass.dispatch_workgroups(Self::MOST_LISTED / Self::WORKGROUP[1], 1, 1);
    }

    /// Records the copy of the list's head and its first pages. Returns the bytes.
    pub fn copy_list(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        target: &wgpu::Buffer,
        listed: u32,
    ) -> u64 {
        let bytes = Self::list_bytes(listed.min(Self::MOST_LISTED));
        encoder.copy_buffer_to_buffer(&self.list, 0, target, 0, bytes);
        bytes
    }
}

/// The request image, and two buffers to write.
fn group_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty,
        count: None,
    };
    let storage = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Storage { read_only: false },
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("gather pages"),
        entries: &[entry(0, request_texture()), entry(1, storage), entry(2, storage)],
    })
}

/// How a request image is bound.
pub(super) fn request_texture() -> wgpu::BindingType {
    wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Uint,
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    }
}
