use super::coordinate_image_bindings::CoordinateImageBindings;
use super::displace_pass::{bind_buffers, storage_layout};
use super::shader_library::MARK_SEEN_TILES;

/// Marks the tiles that the pixels of the coordinate image saw, as `SeenTiles` of the selection does.
pub(super) struct MarkSeenTilesPass {
    pipeline: wgpu::ComputePipeline,
    inputs: wgpu::BindGroup,
}

impl MarkSeenTilesPass {
    /// `params` and `heights`: the `params` and `height_units` of `common/selection.wgsl`.
    pub fn new(
        device: &wgpu::Device,
        params: &wgpu::Buffer,
        heights: &wgpu::Buffer,
        image: &CoordinateImageBindings,
    ) -> Self {
        let inputs = storage_layout(device, "mark seen tiles", &[true, true]);
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("mark seen tiles"),
            bind_group_layouts: &[Some(&inputs), Some(&image.layout)],
            immediate_size: 0,
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("mark seen tiles"),
            layout: Some(&layout),
            module: &MARK_SEEN_TILES.module(device),
            entry_point: Some("mark_seen_tiles"),
            compilation_options: Default::default(),
            cache: None,
        });
        Self { pipeline, inputs: bind_buffers(device, &inputs, &[params, heights]) }
    }

    /// Records the pass. Marks are added to those there are.
    pub fn record(&self, pass: &mut wgpu::ComputePass<'_>, image: &CoordinateImageBindings) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.inputs, &[]);
        image.dispatch(pass);
    }
}
