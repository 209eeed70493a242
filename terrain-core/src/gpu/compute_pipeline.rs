use super::shader_library::Shader;

/// A pipeline of the shader's entry point of the same name, its layout taken from the shader.
pub(super) fn compute_pipeline(device: &wgpu::Device, shader: &Shader) -> wgpu::ComputePipeline {
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(shader.name),
        layout: None,
        module: &shader.module(device),
        entry_point: Some(shader.name),
        compilation_options: Default::default(),
        cache: None,
    })
}

/// Binds whole buffers, numbered in their order, as a group of the pipeline.
pub(super) fn bind_group(
    device: &wgpu::Device,
    pipeline: &wgpu::ComputePipeline,
    group: u32,
    buffers: &[&wgpu::Buffer],
) -> wgpu::BindGroup {
    let layout = pipeline.get_bind_group_layout(group);
    super::displace_pass::bind_buffers(device, &layout, buffers)
}
