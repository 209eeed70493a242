use super::request_image::RequestImage;
use crate::gpu::shader_library::SAMPLE_PAGES;

/// Feedback as current engines do it: of every block of pixels one, another each frame.
pub(crate) struct SamplePagesPass {
    pipeline: wgpu::ComputePipeline,
    turn: wgpu::Buffer,
    samples: wgpu::Buffer,
    blocks: [u32; 2],
}

impl SamplePagesPass {
    /// Pixels along a block's side.
    pub const BLOCK_PX: u32 = 8;
    /// Frames after which every pixel has had its turn.
    pub const PERIOD: u32 = Self::BLOCK_PX * Self::BLOCK_PX;
    const WORKGROUP: u32 = 8;
    pub const SAMPLE_BYTES: u32 = 8;
    const TURN_BYTES: u64 = 16;

    /// For request images of this size.
    pub fn new(device: &wgpu::Device, size_px: [u32; 2]) -> Self {
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(SAMPLE_PAGES.name),
            layout: None,
            module: &SAMPLE_PAGES.module(device),
            entry_point: Some(SAMPLE_PAGES.name),
            compilation_options: Default::default(),
            cache: None,
        });
        let blocks = size_px.map(|px| px.div_ceil(Self::BLOCK_PX));
        let buffer = |label, size, usage| {
            let mapped_at_creation = false;
            let label = Some(label);
            device.create_buffer(&wgpu::BufferDescriptor { label, size, usage, mapped_at_creation })
        };
        use wgpu::BufferUsages as Usage;
        let bytes = Self::bytes_of(blocks);
        Self {
            pipeline,
            turn: buffer("turn", Self::TURN_BYTES, Usage::UNIFORM | Usage::COPY_DST),
            samples: buffer("page samples", bytes, Usage::STORAGE | Usage::COPY_SRC),
            blocks,
        }
    }

    /// Bytes of the samples of a frame.
    pub fn bytes(&self) -> u64 {
        Self::bytes_of(self.blocks)
    }

    fn bytes_of(blocks: [u32; 2]) -> u64 {
        u64::from(blocks[0]) * u64::from(blocks[1]) * u64::from(Self::SAMPLE_BYTES)
    }

    /// The pixel of every block whose turn it is in this frame. Turns that follow one another lie far apart: the
    /// bits of the frame's number, last first, are dealt to columns and rows by turns.
    pub fn turn(frame: u64) -> [u32; 2] {
        let mut pixel = [0; 2];
        for bit in 0..2 * Self::BLOCK_PX.ilog2() {
            let axis = (bit % 2) as usize;
            pixel[axis] = pixel[axis] << 1 | (frame >> bit & 1) as u32;
        }
        pixel
    }

    /// Records the sampling of the frame's turn and the copy of its samples. Returns the bytes.
    pub fn record(
        &self,
        (device, queue): (&wgpu::Device, &wgpu::Queue),
        encoder: &mut wgpu::CommandEncoder,
        image: &RequestImage,
        frame: u64,
        target: &wgpu::Buffer,
    ) -> u64 {
        let [x, y] = Self::turn(frame);
        queue.write_buffer(&self.turn, 0, bytemuck::bytes_of(&[x, y, 0, 0]));
        let resources = [
            wgpu::BindingResource::TextureView(&image.view),
            self.samples.as_entire_binding(),
            self.turn.as_entire_binding(),
        ];
        let bound = (0..).zip(resources);
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("sample pages"),
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &bound
                .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
                .collect::<Vec<_>>(),
        });
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("sample pages"),
            timestamp_writes: None,
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &group, &[]);
        let [across, down] = self.blocks.map(|blocks| blocks.div_ceil(Self::WORKGROUP));
        pass.dispatch_workgroups(across, down, 1);
        drop(pass);
        let bytes = self.bytes();
        encoder.copy_buffer_to_buffer(&self.samples, 0, target, 0, bytes);
        bytes
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn every_pixel_of_a_block_has_its_turn_once_a_period() {
        let turns = (0..u64::from(SamplePagesPass::PERIOD)).map(SamplePagesPass::turn);
        let turns = turns.collect::<BTreeSet<_>>();
        let side = 0..SamplePagesPass::BLOCK_PX;
        assert_eq!(turns, side.clone().flat_map(|x| side.clone().map(move |y| [x, y])).collect());
        assert_eq!(SamplePagesPass::turn(0), [0, 0]);
        assert_eq!(SamplePagesPass::turn(1), [4, 0], "half a block away");
    }
}
