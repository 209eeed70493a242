use super::page_bindings::PageBindings;
use crate::gpu::displace_pass::bind_buffers;
use crate::gpu::shader_library::GATHER_PAGES;
use crate::residency::page_table::PageLayout;

/// Pages marked as needed, and the list of them, each once and in no order: the paper's U2 and U3. As
/// [`unite`](crate::residency::page_table::unite) does it on the CPU. Group 1 of whoever marks.
pub(crate) struct PageMarks {
    pub layout: wgpu::BindGroupLayout,
    pub group: wgpu::BindGroup,
    /// U2.
    marks: wgpu::Buffer,
    /// U3.
    list: wgpu::Buffer,
    complete: wgpu::ComputePipeline,
}

impl PageMarks {
    /// The group the bindings are in.
    pub const GROUP: u32 = 1;
    /// Most pages on a list. Where there are more, pixels left out are drawn coarser.
    pub const MOST_LISTED: u32 = 16_384;
    /// Bytes before the list's first page.
    pub const HEAD_BYTES: u64 = 8;
    pub const PAGE_BYTES: u64 = 8;
    const WORKGROUP: u32 = 64;

    pub fn new(device: &wgpu::Device, layout: &PageLayout, pages: &PageBindings) -> Self {
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
        let marks = buffer("page marks", 4 * u64::from(layout.page_count()));
        let list = buffer("page list", Self::list_bytes(Self::MOST_LISTED));
        let group_layout = group_layout(device);
        Self {
            complete: complete_pipeline(device, &group_layout, pages),
            group: bind_buffers(device, &group_layout, &[&marks, &list]),
            layout: group_layout,
            marks,
            list,
        }
    }

    /// Bytes of a list of so many pages.
    pub fn list_bytes(listed: u32) -> u64 {
        Self::HEAD_BYTES + Self::PAGE_BYTES * u64::from(listed)
    }

    /// Records that nothing is marked: before anything marks.
    pub fn clear(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.clear_buffer(&self.marks, 0, None);
        encoder.clear_buffer(&self.list, 0, Some(Self::HEAD_BYTES));
    }

    /// Records the completion of the list, after everything has marked.
    pub fn complete(&self, pass: &mut wgpu::ComputePass<'_>, pages: &PageBindings) {
        pass.set_pipeline(&self.complete);
        pass.set_bind_group(Self::GROUP, &self.group, &[]);
        pass.set_bind_group(PageBindings::GROUP, &pages.group, &[]);
        pass.dispatch_workgroups(Self::MOST_LISTED / Self::WORKGROUP, 1, 1);
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

/// Two buffers to write.
fn group_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let entry = |binding| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE | wgpu::ShaderStages::FRAGMENT,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only: false },
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    };
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("page marks"),
        entries: &[entry(0), entry(1)],
    })
}

fn complete_pipeline(
    device: &wgpu::Device,
    marks: &wgpu::BindGroupLayout,
    pages: &PageBindings,
) -> wgpu::ComputePipeline {
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("list pages"),
        bind_group_layouts: &[None, Some(marks), Some(&pages.layout)],
        immediate_size: 0,
    });
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("list pages"),
        layout: Some(&layout),
        module: &GATHER_PAGES.module(device),
        entry_point: Some("list_pages"),
        compilation_options: Default::default(),
        cache: None,
    })
}
