use wgpu::util::DeviceExt;

use crate::surface::{CircularMesh, MeshBlock};

/// The flat mesh on the GPU, sent once, and the buffers that the displaced vertices and the sorted
/// triangles are written to.
pub(crate) struct MeshBuffers {
    pub vertices: wgpu::Buffer,
    pub blocks: wgpu::Buffer,
    pub indices: wgpu::Buffer,
    /// The triangles within one tile of each layer, the others shrunk to a point.
    pub indices_within: wgpu::Buffer,
    /// The other triangles, those within a tile shrunk to a point.
    pub indices_across: wgpu::Buffer,
    pub displaced: wgpu::Buffer,
    pub visible_blocks: wgpu::Buffer,
    /// Largest number of vertices in a block.
    pub max_block_vertices: u32,
    /// Largest number of triangles in a block.
    pub max_block_triangles: u32,
    written_visible: Vec<u32>,
}

impl MeshBuffers {
    /// Bytes of one displaced vertex, `DisplacedVertex` of `common/mesh.wgsl`.
    pub const VERTEX_BYTES: u64 = 56;
    /// What the drawing passes read of it: the position; ground and atlas texel of the height tile,
    /// and of the colour tile.
    pub const ATTRIBUTES: [wgpu::VertexAttribute; 5] = [
        attribute(0, wgpu::VertexFormat::Float32x3, 40),
        attribute(1, wgpu::VertexFormat::Float32x3, 0),
        attribute(2, wgpu::VertexFormat::Uint32, 12),
        attribute(3, wgpu::VertexFormat::Float32x3, 16),
        attribute(4, wgpu::VertexFormat::Uint32, 28),
    ];

    /// How a pipeline reads the vertices.
    pub fn vertex_layout() -> wgpu::VertexBufferLayout<'static> {
        wgpu::VertexBufferLayout {
            array_stride: Self::VERTEX_BYTES,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &Self::ATTRIBUTES,
        }
    }

    pub fn new(device: &wgpu::Device, mesh: &CircularMesh) -> Self {
        let blocks = mesh
            .blocks
            .iter()
            .flat_map(|block| {
                [block.vertex_start, block.vertex_count, block.index_start, block.index_count]
            })
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
        let index_bytes = size_of_val(mesh.indices.as_slice()) as u64;
        let largest = |count: fn(&MeshBlock) -> u32| mesh.blocks.iter().map(count).max();
        use wgpu::BufferUsages as Usage;
        Self {
            vertices: init("mesh", bytemuck::cast_slice(&mesh.vertices), Usage::STORAGE),
            blocks: init("mesh blocks", bytemuck::cast_slice(&blocks), Usage::STORAGE),
            indices_within: empty(
                "indices within tiles",
                index_bytes,
                Usage::STORAGE | Usage::INDEX,
            ),
            indices_across: empty(
                "indices across tiles",
                index_bytes,
                Usage::STORAGE | Usage::INDEX,
            ),
            indices: init(
                "mesh indices",
                bytemuck::cast_slice(&mesh.indices),
                Usage::STORAGE | Usage::INDEX,
            ),
            displaced: empty(
                "displaced vertices",
                mesh.vertices.len() as u64 * Self::VERTEX_BYTES,
                Usage::STORAGE | Usage::VERTEX | Usage::COPY_SRC,
            ),
            visible_blocks: empty(
                "visible blocks",
                mesh.blocks.len() as u64 * 4,
                Usage::STORAGE | Usage::COPY_DST,
            ),
            max_block_vertices: largest(|block| block.vertex_count).unwrap_or(0),
            max_block_triangles: largest(|block| block.index_count / 3).unwrap_or(0),
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

const fn attribute(
    shader_location: u32,
    format: wgpu::VertexFormat,
    offset: u64,
) -> wgpu::VertexAttribute {
    wgpu::VertexAttribute { format, offset, shader_location }
}
