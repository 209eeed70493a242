use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

const WAITING: u8 = 0;
const MAPPED: u8 = 1;
const FAILED: u8 = 2;

/// A ring of buffers that brings textures or bytes back to the CPU without ever waiting for the GPU. What
/// comes back carries the metadata `M` it was asked for with: the camera and frame that made it.
pub(crate) struct ReadbackRing<M> {
    free: Vec<wgpu::Buffer>,
    in_flight: VecDeque<InFlight<M>>,
    size_px: [u32; 2],
    texel_bytes: u32,
}

struct InFlight<M> {
    buffer: wgpu::Buffer,
    state: Arc<AtomicU8>,
    metadata: M,
}

/// A texture that came back: rows of texels without padding.
pub(crate) struct Readback<M> {
    pub metadata: M,
    pub bytes: Vec<u8>,
}

impl<M> ReadbackRing<M> {
    pub fn new(device: &wgpu::Device, buffers: u32, size_px: [u32; 2], texel_bytes: u32) -> Self {
        let mut ring = Self { free: Vec::new(), in_flight: VecDeque::new(), size_px, texel_bytes };
        ring.free = (0..buffers)
            .map(|_| {
                device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some("readback"),
                    size: u64::from(ring.row_bytes()) * u64::from(size_px[1]),
                    usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
                    mapped_at_creation: false,
                })
            })
            .collect();
        ring
    }

    /// A ring for so many bytes.
    pub fn of_bytes(device: &wgpu::Device, buffers: u32, bytes: u32) -> Self {
        Self::new(device, buffers, [bytes, 1], 1)
    }

    /// Bytes of a padded row, as copies from textures want it.
    fn row_bytes(&self) -> u32 {
        (self.size_px[0] * self.texel_bytes).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT)
    }

    /// Whether a buffer is free, so that a readback can begin.
    pub fn has_free(&self) -> bool {
        !self.free.is_empty()
    }

    /// Whether something is still on its way.
    pub fn is_waiting(&self) -> bool {
        !self.in_flight.is_empty()
    }

    /// Records the copy of the texture. Returns the buffer to [`Self::begin`] after the submission,
    /// or `None` where the ring is full.
    pub fn record(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        texture: &wgpu::Texture,
    ) -> Option<wgpu::Buffer> {
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(self.row_bytes()),
            rows_per_image: None,
        };
        self.record_with(|buffer| {
            let source = texture.as_image_copy();
            let target = wgpu::TexelCopyBufferInfo { buffer, layout };
            encoder.copy_texture_to_buffer(source, target, texture.size());
        })
    }

    /// [`Self::record`] of any copy.
    pub fn record_with(&mut self, copy: impl FnOnce(&wgpu::Buffer)) -> Option<wgpu::Buffer> {
        let buffer = self.free.pop()?;
        copy(&buffer);
        Some(buffer)
    }

    /// Asks for the buffer's content once its copy is done. To be called after the submission.
    pub fn begin(&mut self, buffer: wgpu::Buffer, metadata: M) {
        let state = Arc::new(AtomicU8::new(WAITING));
        let mapped = Arc::clone(&state);
        buffer.slice(..).map_async(wgpu::MapMode::Read, move |result| {
            mapped.store(if result.is_ok() { MAPPED } else { FAILED }, Ordering::Release);
        });
        self.in_flight.push_back(InFlight { buffer, state, metadata });
    }

    /// The oldest texture that has come back since the last call, if any and if it is due. Never waits:
    /// the device must be polled for the answers to arrive.
    pub fn take_if(&mut self, is_due: impl Fn(&M) -> bool) -> Option<Readback<M>> {
        loop {
            let oldest = self.in_flight.front()?;
            let state = oldest.state.load(Ordering::Acquire);
            if state == WAITING || !is_due(&oldest.metadata) {
                return None;
            }
            let InFlight { buffer, metadata, .. } = self.in_flight.pop_front()?;
            let bytes = (state == MAPPED).then(|| self.copy_rows(&buffer)).flatten();
            buffer.unmap();
            self.free.push(buffer);
            if let Some(bytes) = bytes {
                return Some(Readback { metadata, bytes });
            }
        }
    }

    fn copy_rows(&self, buffer: &wgpu::Buffer) -> Option<Vec<u8>> {
        let view = buffer.slice(..).get_mapped_range().ok()?;
        let row = (self.size_px[0] * self.texel_bytes) as usize;
        let rows = view.chunks_exact(self.row_bytes() as usize);
        Some(rows.flat_map(|padded| &padded[..row]).copied().collect())
    }
}
