use half::f16;

use super::context::GpuContext;
use super::shader_library::VIEW_MESH_UPDATE;
use crate::surface::view_mesh::{MeshChanges, ViewVertex};

/// A mesh that is made on the CPU, on the GPU: its vertices and triangles, changed by what is sent.
pub(crate) struct ViewMeshBuffers {
    /// Vertices by number, [`Self::VERTEX_BYTES`] each: `SentVertex` of `common/view_mesh_vertex.wgsl`.
    pub vertices: wgpu::Buffer,
    /// Triangles by place: three 32-bit numbers of vertices each.
    pub indices: wgpu::Buffer,
    changes: wgpu::Buffer,
    pipeline: wgpu::ComputePipeline,
    bindings: wgpu::BindGroup,
}

impl ViewMeshBuffers {
    /// Bytes of a vertex.
    pub const VERTEX_BYTES: u64 = 16;
    /// What of it a vertex stage reads.
    pub const ATTRIBUTES: [wgpu::VertexAttribute; 3] = [
        wgpu::VertexAttribute {
            format: wgpu::VertexFormat::Uint32x2,
            offset: 0,
            shader_location: 0,
        },
        wgpu::VertexAttribute {
            format: wgpu::VertexFormat::Float32,
            offset: 8,
            shader_location: 1,
        },
        wgpu::VertexAttribute {
            format: wgpu::VertexFormat::Float16x2,
            offset: 12,
            shader_location: 2,
        },
    ];
    /// Bytes that a changed vertex takes on its way: its number and itself.
    pub const SENT_VERTEX_BYTES: u64 = 20;
    /// Bytes that a changed triangle takes on its way: its place and three numbers, 24 bits each.
    pub const SENT_TRIANGLE_BYTES: u64 = 12;

    const TRIANGLE_BYTES: u64 = 12;
    const WORKGROUP: u32 = 64;

    /// How a pipeline reads the vertices.
    pub fn vertex_layout() -> wgpu::VertexBufferLayout<'static> {
        wgpu::VertexBufferLayout {
            array_stride: Self::VERTEX_BYTES,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &Self::ATTRIBUTES,
        }
    }

    pub fn new(device: &wgpu::Device) -> Self {
        let module = VIEW_MESH_UPDATE.module(device);
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(VIEW_MESH_UPDATE.name),
            layout: None,
            module: &module,
            entry_point: Some("update"),
            compilation_options: Default::default(),
            cache: None,
        });
        let [vertices, indices, changes] =
            [Kind::Vertices, Kind::Indices, Kind::Changes].map(|kind| kind.buffer(device, 1 << 16));
        let bindings = bind(device, &pipeline, [&changes, &vertices, &indices]);
        Self { vertices, indices, changes, pipeline, bindings }
    }

    /// Sends the changes and records carrying them out, in a mesh of so many vertices and triangles;
    /// returns the bytes sent. Buffers that have become too small grow, what is in them stays.
    pub fn update(
        &mut self,
        gpu: &GpuContext,
        encoder: &mut wgpu::CommandEncoder,
        (vertices, triangles): (usize, usize),
        changes: &MeshChanges,
    ) -> u64 {
        let count = (changes.vertices.len() + changes.triangles.len()) as u32;
        if count == 0 {
            return 0;
        }
        let words = packed(changes);
        let bytes: &[u8] = bytemuck::cast_slice(&words);
        let needed = [
            (Kind::Vertices, vertices as u64 * Self::VERTEX_BYTES),
            (Kind::Indices, triangles as u64 * Self::TRIANGLE_BYTES),
            (Kind::Changes, bytes.len() as u64),
        ];
        for (kind, needed_bytes) in needed {
            self.grow(&gpu.device, encoder, kind, needed_bytes);
        }
        gpu.queue.write_buffer(&self.changes, 0, bytes);
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some(VIEW_MESH_UPDATE.name),
            timestamp_writes: None,
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.bindings, &[]);
        pass.dispatch_workgroups(count.div_ceil(Self::WORKGROUP), 1, 1);
        bytes.len() as u64
    }

    fn grow(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        kind: Kind,
        needed_bytes: u64,
    ) {
        let buffer = match kind {
            Kind::Vertices => &mut self.vertices,
            Kind::Indices => &mut self.indices,
            Kind::Changes => &mut self.changes,
        };
        if buffer.size() >= needed_bytes {
            return;
        }
        let grown = kind.buffer(device, needed_bytes.next_power_of_two());
        if kind != Kind::Changes {
            encoder.copy_buffer_to_buffer(buffer, 0, &grown, 0, buffer.size());
        }
        *buffer = grown;
        self.bindings =
            bind(device, &self.pipeline, [&self.changes, &self.vertices, &self.indices]);
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Vertices,
    Indices,
    Changes,
}

impl Kind {
    fn buffer(self, device: &wgpu::Device, size: u64) -> wgpu::Buffer {
        use wgpu::BufferUsages as Usage;
        let (label, usage) = match self {
            Self::Vertices => ("view mesh vertices", Usage::VERTEX | Usage::COPY_SRC),
            Self::Indices => ("view mesh triangles", Usage::INDEX | Usage::COPY_SRC),
            Self::Changes => ("view mesh changes", Usage::empty()),
        };
        let usage = usage | Usage::STORAGE | Usage::COPY_DST;
        device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size,
            usage,
            mapped_at_creation: false,
        })
    }
}

fn bind(
    device: &wgpu::Device,
    pipeline: &wgpu::ComputePipeline,
    buffers: [&wgpu::Buffer; 3],
) -> wgpu::BindGroup {
    let entries = [0, 1, 2].map(|binding| wgpu::BindGroupEntry {
        binding,
        resource: buffers[binding as usize].as_entire_binding(),
    });
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some(VIEW_MESH_UPDATE.name),
        layout: &pipeline.get_bind_group_layout(0),
        entries: &entries,
    })
}

/// The changes as `view_mesh_update.wgsl` reads them.
fn packed(changes: &MeshChanges) -> Vec<u32> {
    let mut words = vec![changes.vertices.len() as u32, changes.triangles.len() as u32];
    for (number, vertex) in &changes.vertices {
        words.push(*number);
        words.extend(packed_vertex(vertex));
    }
    for &(place, [a, b, c]) in &changes.triangles {
        words.extend([place | (a << 24), (a >> 8) | (b << 16), (b >> 16) | (c << 8)]);
    }
    words
}

fn packed_vertex(vertex: &ViewVertex) -> [u32; 4] {
    let coverage = match vertex.coverage {
        part if part >= 1.0 => 3,
        part if part >= 0.5 => 2,
        part if part > 0.0 => 1,
        _ => 0,
    };
    let [east, north] = vertex.slope.map(|slope| u32::from(f16::from_f32(slope).to_bits()));
    [
        vertex.position.x as u32 | ((coverage & 1) << 31),
        vertex.position.y as u32 | ((coverage >> 1) << 31),
        vertex.height_m.to_bits(),
        east | (north << 16),
    ]
}
