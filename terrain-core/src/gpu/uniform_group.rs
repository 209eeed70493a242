/// A group of one uniform buffer at binding 0, of which several passes have a kind.
pub(super) struct UniformGroup {
    pub layout: wgpu::BindGroupLayout,
    pub group: wgpu::BindGroup,
    pub buffer: wgpu::Buffer,
}

impl UniformGroup {
    /// A buffer of so many bytes, written from the CPU and used as `usage` says besides.
    pub fn new(
        device: &wgpu::Device,
        label: &str,
        bytes: u64,
        visibility: wgpu::ShaderStages,
        usage: wgpu::BufferUsages,
    ) -> Self {
        let label = Some(label);
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label,
            entries: &[wgpu::BindGroupLayoutEntry {
                binding: 0,
                visibility,
                ty: wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Uniform,
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
                count: None,
            }],
        });
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label,
            size: bytes,
            usage: usage | wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label,
            layout: &layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: buffer.as_entire_binding() }],
        });
        Self { layout, group, buffer }
    }
}
