use wgpu::util::DeviceExt;

use crate::surface::CircularMesh;

/// The flat mesh on the GPU, sent once, and the buffer its displaced vertices are written to.
pub(crate) struct MeshBuffers {
    pub vertices: wgpu::Buffer,
    pub blocks: wgpu::Buffer,
    pub indices: wgpu::Buffer,
    pub displaced: wgpu::Buffer,
    pub visible_blocks: wgpu::Buffer,
    /// Largest number of vertices in a block.
    pub max_block_vertices: u32,
    written_visible: Vec<u32>,
}

impl MeshBuffers {
    /// Bytes of one displaced vertex: x, y, z relative to the eye and the hints of its tiles.
    pub const VERTEX_BYTES: u64 = 16;

    pub fn new(device: &wgpu::Device, mesh: &CircularMesh) -> Self {
        let blocks = mesh
            .blocks
            .iter()
            .flat_map(|block| [block.vertex_start, block.vertex_count])
            .collect::<Vec<u32>>();
        let init = |label, contents: &[u8], usage| {
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some(label),
                contents,
                usage,
            })
        };
        let empty = |label, size, usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        use wgpu::BufferUsages as Usage;
        Self {
            vertices: init("mesh", bytemuck::cast_slice(&mesh.vertices), Usage::STORAGE),
            blocks: init("mesh blocks", bytemuck::cast_slice(&blocks), Usage::STORAGE),
            indices: init("mesh indices", bytemuck::cast_slice(&mesh.indices), Usage::INDEX),
            displaced: empty(
                "displaced vertices",
                mesh.vertices.len() as u64 * Self::VERTEX_BYTES,
                Usage::STORAGE | Usage::VERTEX,
            ),
            visible_blocks: empty(
                "visible blocks",
                mesh.blocks.len() as u64 * 4,
                Usage::STORAGE | Usage::COPY_DST,
            ),
            max_block_vertices: mesh
                .blocks
                .iter()
                .map(|block| block.vertex_count)
                .max()
                .unwrap_or(0),
            written_visible: Vec::new(),
        }
    }

    /// Bytes of the buffers that were filled from the CPU.
    pub fn sent_bytes(&self) -> u64 {
        self.vertices.size() + self.blocks.size() + self.indices.size()
    }

    /// Tells the GPU which blocks are drawn; returns the bytes sent, 0 where nothing changed.
    pub fn set_visible(&mut self, queue: &wgpu::Queue, visible: &[u32]) -> u64 {
        if visible == self.written_visible {
            return 0;
        }
        queue.write_buffer(&self.visible_blocks, 0, bytemuck::cast_slice(visible));
        self.written_visible = visible.to_vec();
        size_of_val(visible) as u64
    }
}
