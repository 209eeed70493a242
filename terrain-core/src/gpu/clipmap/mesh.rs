use wgpu::util::DeviceExt;

use crate::surface::ClipBlock;

/// The patch that every block of the rings is drawn with, and the blocks in view.
pub(crate) struct ClipMeshBuffers {
    /// Cells along the patch's side, which its indices are made for.
    patch_cells: u32,
    indices: wgpu::Buffer,
    index_count: u32,
    blocks: wgpu::Buffer,
    written: Vec<ClipBlock>,
}

impl ClipMeshBuffers {
    const BLOCK_BYTES: u64 = size_of::<ClipBlock>() as u64;
    const ATTRIBUTES: [wgpu::VertexAttribute; 3] =
        wgpu::vertex_attr_array![0 => Sint32x2, 1 => Uint32, 2 => Uint32];

    /// Nothing yet.
    pub fn new(device: &wgpu::Device) -> Self {
        Self {
            patch_cells: 0,
            indices: index_buffer(device, &[]),
            index_count: 0,
            blocks: block_buffer(device, Self::BLOCK_BYTES),
            written: Vec::new(),
        }
    }

    /// How the blocks lie in their buffer: one an instance.
    pub fn instance_layout() -> wgpu::VertexBufferLayout<'static> {
        wgpu::VertexBufferLayout {
            array_stride: Self::BLOCK_BYTES,
            step_mode: wgpu::VertexStepMode::Instance,
            attributes: &Self::ATTRIBUTES,
        }
    }

    /// Brings the patch and the blocks in view to the GPU; returns the bytes sent, 0 where nothing
    /// changed.
    pub fn set(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        patch_cells: u32,
        visible: Vec<ClipBlock>,
    ) -> u64 {
        let mut sent = 0;
        if patch_cells != self.patch_cells {
            let indices = patch_indices(patch_cells);
            self.indices = index_buffer(device, &indices);
            self.index_count = indices.len() as u32;
            self.patch_cells = patch_cells;
            sent += size_of_val(indices.as_slice()) as u64;
        }
        if visible != self.written {
            let bytes: &[u8] = bytemuck::cast_slice(&visible);
            if bytes.len() as u64 > self.blocks.size() {
                self.blocks = block_buffer(device, (bytes.len() as u64).next_power_of_two());
            }
            queue.write_buffer(&self.blocks, 0, bytes);
            sent += bytes.len() as u64;
            self.written = visible;
        }
        sent
    }

    /// Blocks and triangles in view.
    pub fn drawn(&self) -> (u64, u64) {
        (self.written.len() as u64, self.written.iter().map(ClipBlock::triangles).sum())
    }

    /// Draws the blocks with the pipeline that is set.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>) {
        if self.written.is_empty() {
            return;
        }
        pass.set_vertex_buffer(0, self.blocks.slice(..));
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint16);
        pass.draw_indexed(0..self.index_count, 0, 0..self.written.len() as u32);
    }
}

/// The patch's triangles, two a cell, row by row. A square's middle edge runs from north-west to
/// south-east: the vertex stage puts vertices between two others of the next ring on that very line.
fn patch_indices(cells: u32) -> Vec<u16> {
    let columns = cells + 1;
    let vertex = |column: u32, row: u32| (row * columns + column) as u16;
    let mut indices = Vec::with_capacity((6 * cells * cells) as usize);
    for row in 0..cells {
        for column in 0..cells {
            let [nw, ne] = [vertex(column, row), vertex(column + 1, row)];
            let [sw, se] = [vertex(column, row + 1), vertex(column + 1, row + 1)];
            indices.extend([nw, sw, se, nw, se, ne]);
        }
    }
    indices
}

fn index_buffer(device: &wgpu::Device, indices: &[u16]) -> wgpu::Buffer {
    device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some("clip patch"),
        contents: bytemuck::cast_slice(indices),
        usage: wgpu::BufferUsages::INDEX,
    })
}

fn block_buffer(device: &wgpu::Device, size: u64) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("clip blocks"),
        size,
        usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}
