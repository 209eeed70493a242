use super::coordinate_pass::CoordinatePass;
use super::displaced_mesh::DisplacedMesh;
use super::frame_bindings::FrameBindings;
use super::readback_ring::ReadbackRing;
use crate::selection::CoordinateImage;
use crate::{CameraView, RendererSettings};

/// The coordinate pass of selection and the ring that brings its images back.
pub(crate) struct CoordinateFeedback {
    pub pass: CoordinatePass,
    ring: ReadbackRing<ReadbackTicket>,
    size_px: [u32; 2],
    /// Frames that an image is held back.
    latency_frames: u32,
}

/// The frame and the camera that drew an image.
#[derive(Clone, Copy)]
struct ReadbackTicket {
    frame: u64,
    view: CameraView,
}

impl CoordinateFeedback {
    /// Buffers of the ring: one being drawn, one on its way, one being read, and as many as are held
    /// back.
    const BUFFERS: u32 = 3;
    const TEXEL_BYTES: u32 = 8;

    pub fn new(
        device: &wgpu::Device,
        bindings: &FrameBindings,
        settings: &RendererSettings,
    ) -> Self {
        let size_px = settings.coordinate_size_px;
        let latency_frames = settings.readback_latency_frames;
        let pass = CoordinatePass::new(device, bindings, CoordinatePass::REGION_FORMAT, size_px);
        let buffers = Self::BUFFERS + latency_frames;
        let ring = ReadbackRing::new(device, buffers, size_px, Self::TEXEL_BYTES);
        Self { pass, ring, size_px, latency_frames }
    }

    /// Bytes of one image.
    pub fn image_bytes(&self) -> u64 {
        u64::from(self.size_px[0]) * u64::from(self.size_px[1]) * u64::from(Self::TEXEL_BYTES)
    }

    /// Whether another image can be asked for.
    pub fn is_free(&self) -> bool {
        self.ring.has_free()
    }

    /// Whether an image is on its way.
    pub fn is_waiting(&self) -> bool {
        self.ring.is_waiting()
    }

    /// Records the pass and the copy of its image; [`Self::begin`] takes the result after the
    /// submission. `None` where no buffer is free: the frame then does without.
    pub fn record(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        bindings: &FrameBindings,
        mesh: &DisplacedMesh,
    ) -> Option<wgpu::Buffer> {
        self.pass.record(encoder, bindings, mesh.parts(), mesh.visible());
        self.ring.record(encoder, &self.pass.target)
    }

    /// Asks for the image once it is drawn.
    pub fn begin(&mut self, buffer: wgpu::Buffer, frame: u64, view: CameraView) {
        self.ring.begin(buffer, ReadbackTicket { frame, view });
    }

    /// The newest image that may be used in this frame of those that have come back since the last
    /// call, and how many have. Never waits.
    pub fn take_newest(&mut self, frame: u64) -> Option<(CoordinateImage, u64)> {
        let mut newest = None;
        let mut count = 0;
        let latency_frames = u64::from(self.latency_frames);
        let is_due = |ticket: &ReadbackTicket| ticket.frame + latency_frames <= frame;
        while let Some(readback) = self.ring.take_if(is_due) {
            newest = Some(readback);
            count += 1;
        }
        let readback = newest?;
        let ReadbackTicket { frame, view } = readback.metadata;
        let [width, height] = self.size_px;
        let offsets = bytemuck::pod_collect_to_vec::<u8, [f32; 2]>(&readback.bytes)
            .into_iter()
            .map(|offset| if offset[0] >= CoordinatePass::SKY { [f32::NAN; 2] } else { offset })
            .collect();
        let origin = view.eye.truncate();
        Some((CoordinateImage { width, height, origin, offsets, frame, view }, count))
    }
}
