use super::globe_uniforms::GlobeUniforms;
use crate::gpu::uniform_group::UniformGroup;

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
        let usage = wgpu::BufferUsages::empty();
        let UniformGroup { layout, group, buffer } =
            UniformGroup::new(device, "globe", GlobeUniforms::BYTES, ALL_STAGES, usage);
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
