use super::seen_ground_buffer::SeenGroundBuffer;

/// Group 1 of the passes that look through a coordinate image: the image, and what was seen in it.
pub(super) struct CoordinateImageBindings {
    pub layout: wgpu::BindGroupLayout,
    pub group: wgpu::BindGroup,
    size_px: [u32; 2],
}

impl CoordinateImageBindings {
    /// The group the bindings are in.
    pub const GROUP: u32 = 1;
    /// Pixels across and down a workgroup of the passes.
    const WORKGROUP_PX: u32 = 16;

    /// For a texture of [`CoordinatePass::REGION_FORMAT`](super::CoordinatePass::REGION_FORMAT).
    pub fn new(device: &wgpu::Device, image: &wgpu::Texture, seen: &SeenGroundBuffer) -> Self {
        let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty,
            count: None,
        };
        let texture = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: false },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let buffer = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only: false },
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("coordinate image"),
            entries: &[entry(0, texture), entry(1, buffer)],
        });
        let view = image.create_view(&Default::default());
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("coordinate image"),
            layout: &layout,
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::TextureView(&view),
                },
                wgpu::BindGroupEntry { binding: 1, resource: seen.buffer.as_entire_binding() },
            ],
        });
        Self { layout, group, size_px: [image.width(), image.height()] }
    }

    /// Records an invocation a pixel of the pass's pipeline.
    pub fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>) {
        pass.set_bind_group(Self::GROUP, &self.group, &[]);
        let [across, down] = self.size_px.map(|px| px.div_ceil(Self::WORKGROUP_PX));
        pass.dispatch_workgroups(across, down, 1);
    }
}
