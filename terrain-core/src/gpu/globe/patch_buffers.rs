use std::ops::Range;

use crate::surface::globe::{GlobePatch, GlobeVertex, PatchTriangles, VERTICES_A_PATCH};

/// The globe's patches on the GPU: vertices in slots of one buffer, and the triangles that all share.
pub(crate) struct PatchBuffers {
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    triangles: PatchTriangles,
}

/// A patch to draw: where its vertices are, and which triangles join them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct DrawnPatch {
    pub slot: u32,
    pub triangles: Range<u32>,
}

impl PatchBuffers {
    const ATTRIBUTES: [wgpu::VertexAttribute; 4] = wgpu::vertex_attr_array![
        0 => Sint32x3,
        1 => Uint16x4,
        2 => Float32,
        3 => Float16x2,
    ];
    /// Bytes of a patch.
    pub const PATCH_BYTES: u64 = (VERTICES_A_PATCH as usize * size_of::<GlobeVertex>()) as u64;

    /// With room for so many patches.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, slots: u32) -> Self {
        use wgpu::BufferUsages as Usage;
        let buffer = |label, size, usage| {
            let usage = usage | Usage::COPY_DST;
            let mapped_at_creation = false;
            let label = Some(label);
            device.create_buffer(&wgpu::BufferDescriptor { label, size, usage, mapped_at_creation })
        };
        let triangles = PatchTriangles::new();
        let bytes: &[u8] = bytemuck::cast_slice(&triangles.indices);
        let indices = buffer("globe triangles", bytes.len() as u64, Usage::INDEX);
        queue.write_buffer(&indices, 0, bytes);
        let size = u64::from(slots) * Self::PATCH_BYTES;
        Self { vertices: buffer("globe patches", size, Usage::VERTEX), indices, triangles }
    }

    /// Bytes of the lists of triangles, sent once.
    pub fn triangle_bytes(&self) -> u64 {
        self.indices.size()
    }

    /// How a pipeline reads the vertices.
    pub fn vertex_layout() -> wgpu::VertexBufferLayout<'static> {
        wgpu::VertexBufferLayout {
            array_stride: size_of::<GlobeVertex>() as u64,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &Self::ATTRIBUTES,
        }
    }

    /// Which triangles join a patch to its neighbours.
    pub fn triangles(&self, coarse_edges: u8) -> Range<u32> {
        self.triangles.range(coarse_edges)
    }

    /// Writes a patch into its slot; returns the bytes sent.
    pub fn write(&self, queue: &wgpu::Queue, slot: u32, patch: &GlobePatch) -> u64 {
        let bytes: &[u8] = bytemuck::cast_slice(&patch.vertices);
        queue.write_buffer(&self.vertices, u64::from(slot) * Self::PATCH_BYTES, bytes);
        bytes.len() as u64
    }

    /// Draws patches with the pipeline and groups that are set.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, patches: &[DrawnPatch]) {
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint16);
        for patch in patches {
            let first = (patch.slot * VERTICES_A_PATCH) as i32;
            pass.draw_indexed(patch.triangles.clone(), first, 0..1);
        }
    }
}
