use super::frame_uniforms::FrameUniforms;

/// Group 0 of every drawing pass: the frame's uniforms.
pub(crate) struct FrameGroup {
    pub layout: wgpu::BindGroupLayout,
    pub group: wgpu::BindGroup,
    uniforms: wgpu::Buffer,
    written: Option<FrameUniforms>,
}

const ALL_STAGES: wgpu::ShaderStages =
    wgpu::ShaderStages::VERTEX_FRAGMENT.union(wgpu::ShaderStages::COMPUTE);

impl FrameGroup {
    pub fn new(device: &wgpu::Device) -> Self {
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
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
        });
        let uniforms = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("frame uniforms"),
            size: FrameUniforms::BYTES,
            usage: wgpu::BufferUsages::UNIFORM
                | wgpu::BufferUsages::COPY_DST
                | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("frame"),
            layout: &layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: uniforms.as_entire_binding() }],
        });
        Self { layout, group, uniforms, written: None }
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
