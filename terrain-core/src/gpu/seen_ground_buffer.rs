/// The ground last seen, on the GPU: the `seen` of the selection's shaders, laid out as
/// `common/seen_ground.wgsl` tells. A cleared buffer has seen nothing.
pub(super) struct SeenGroundBuffer {
    pub buffer: wgpu::Buffer,
}

impl SeenGroundBuffer {
    /// Bytes of the box and the number of pixels that see ground.
    pub const BOX_BYTES: u64 = 4 * 5;
    /// Bytes before the table of tiles.
    pub const HEADER_BYTES: u64 = 4 * 8;
    const TABLE_BYTES: u64 = 4 << 16;

    pub fn new(device: &wgpu::Device) -> Self {
        use wgpu::BufferUsages as Usage;
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("seen ground"),
            size: Self::HEADER_BYTES + Self::TABLE_BYTES,
            usage: Usage::STORAGE | Usage::COPY_DST | Usage::COPY_SRC,
            mapped_at_creation: false,
        });
        Self { buffer }
    }

    /// Records that nothing has been seen.
    pub fn clear_box(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.clear_buffer(&self.buffer, 0, Some(Self::BOX_BYTES));
    }

    /// Records that no tile is marked.
    pub fn clear_tiles(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.clear_buffer(&self.buffer, Self::BOX_BYTES, None);
    }
}
