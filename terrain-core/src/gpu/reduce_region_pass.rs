use super::coordinate_image_bindings::CoordinateImageBindings;
use super::shader_library::REDUCE_REGION;

/// Finds the box round all ground in the coordinate image, as
/// [`visible_region()`](crate::selection::visible_region()) does.
pub(super) struct ReduceRegionPass {
    pipeline: wgpu::ComputePipeline,
}

impl ReduceRegionPass {
    pub fn new(device: &wgpu::Device, image: &CoordinateImageBindings) -> Self {
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("reduce region"),
            bind_group_layouts: &[None, Some(&image.layout)],
            immediate_size: 0,
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("reduce region"),
            layout: Some(&layout),
            module: &REDUCE_REGION.module(device),
            entry_point: Some("reduce_region"),
            compilation_options: Default::default(),
            cache: None,
        });
        Self { pipeline }
    }

    /// Records the pass. The box grows by what the image shows: it is to be cleared before.
    pub fn record(&self, pass: &mut wgpu::ComputePass<'_>, image: &CoordinateImageBindings) {
        pass.set_pipeline(&self.pipeline);
        image.dispatch(pass);
    }
}
