use super::frame_uniforms::FrameUniforms;
use super::uniform_group::UniformGroup;

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
        let usage = wgpu::BufferUsages::COPY_SRC;
        let UniformGroup { layout, group, buffer: uniforms } =
            UniformGroup::new(device, "frame", FrameUniforms::BYTES, ALL_STAGES, usage);
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
