use super::globe_uniforms::GlobeUniforms;

const ALL_STAGES: wgpu::ShaderStages =
    wgpu::ShaderStages::VERTEX_FRAGMENT.union(wgpu::ShaderStages::COMPUTE);

/// Group 1 of the globe's passes.
pub(crate) struct GlobeGroup {
    pub layout: wgpu::BindGroupLayout,
    pub group: wgpu::BindGroup,
    buffer: wgpu::Buffer,
    written: Option<GlobeUniforms>,
}

impl GlobeGroup {
    /// The group the bindings are in.
    pub const GROUP: u32 = 1;

    pub fn new(device: &wgpu::Device) -> Self {
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("globe"),
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
        });
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("globe"),
            size: GlobeUniforms::BYTES,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("globe"),
            layout: &layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: buffer.as_entire_binding() }],
        });
        Self { layout, group, buffer, written: None }
    }

    /// Writes the uniforms; returns the bytes sent, 0 where nothing changed.
    pub fn set(&mut self, queue: &wgpu::Queue, uniforms: &GlobeUniforms) -> u64 {
        if self.written.as_ref() == Some(uniforms) {
            return 0;
        }
        queue.write_buffer(&self.buffer, 0, &uniforms.to_bytes());
        self.written = Some(*uniforms);
        GlobeUniforms::BYTES
    }
}
