use glam::Vec4;

use crate::surface::models::{Model, ModelVertex, PackedImage};

/// The `ObjectMaterial` of `common/object.wgsl`, where the members and the buffers are explained.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct ObjectMaterial {
    pub colour: [f32; 4],
    pub mean: [f32; 4],
    pub first_texel: [i32; 2],
    pub size_texels: [f32; 2],
    pub wrap: [u32; 2],
    pub coarsest_level: f32,
    pub alpha_cutoff: f32,
}

impl ObjectMaterial {
    /// Of a colour alone, or on an image at this place of the virtual texture.
    pub fn new(colour: [f32; 4], alpha_cutoff: Option<f32>, image: Option<&PackedImage>) -> Self {
        let plain = Self {
            colour,
            mean: [1.0; 4],
            first_texel: [0; 2],
            size_texels: [0.0; 2],
            wrap: [0; 2],
            coarsest_level: -1.0,
            alpha_cutoff: alpha_cutoff.unwrap_or(0.0),
        };
        let Some(image) = image else { return plain };
        Self {
            mean: image.mean,
            first_texel: image.first_texel.map(|texel| texel as i32),
            size_texels: image.size_texels.map(|texels| texels as f32),
            wrap: image.wrap.map(|mode| mode.code()),
            coarsest_level: f32::from(image.coarsest_level),
            ..plain
        }
    }
}

/// Where a model lies in the buffers.
#[derive(Clone, Copy, Debug)]
struct ModelRange {
    base_vertex: i32,
    first_index: u32,
    /// Indices of triangles whose back is not drawn, and of those seen from both sides.
    indices: [u32; 2],
}

/// Instances of one model that lie one after the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ModelRun {
    pub model: usize,
    /// Place of the first instance in the buffer of instances.
    pub first: u32,
    pub count: u32,
}

/// The `ObjectRange` of `map_objects.wgsl`, where the members are explained.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct ObjectRange {
    pub first_number: u32,
    pub triangles: u32,
    pub first_index: u32,
    pub base_vertex: u32,
    pub instance: u32,
    pub single_sided: u32,
}

/// The triangles, materials and instances of all models: group 3 of the passes that draw them.
pub(crate) struct ObjectBuffers {
    pub layout: wgpu::BindGroupLayout,
    pub group: wgpu::BindGroup,
    materials: wgpu::Buffer,
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    instances: wgpu::Buffer,
    models: Vec<ModelRange>,
    /// The instances as they were written.
    written: Vec<[Vec4; 3]>,
    sent_bytes: u64,
}

impl ObjectBuffers {
    /// The group the bindings are in.
    pub const GROUP: u32 = 3;
    /// Bytes of an instance: three rows.
    const INSTANCE_BYTES: u64 = size_of::<[Vec4; 3]>() as u64;

    /// Of the models, whose vertices name materials of their own; `materials` are those of all, model by model.
    pub fn new(
        device: &wgpu::Device,
        models: &[Model],
        materials: &[ObjectMaterial],
        most_instances: usize,
    ) -> Self {
        let Geometry { vertices, indices, ranges } = Geometry::of(models);
        use wgpu::BufferUsages as Usage;
        let filled = |label, bytes: &[u8], usage| filled_buffer(device, label, bytes, usage);
        let vertices = filled(
            "models' vertices",
            bytemuck::cast_slice(&vertices),
            Usage::VERTEX | Usage::STORAGE,
        );
        let indices = filled(
            "models' indices",
            bytemuck::cast_slice(&indices),
            Usage::INDEX | Usage::STORAGE,
        );
        let materials =
            filled("models' materials", bytemuck::cast_slice(materials), Usage::STORAGE);
        let instances = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("models' instances"),
            size: Self::INSTANCE_BYTES * most_instances.max(1) as u64,
            usage: Usage::VERTEX | Usage::STORAGE | Usage::COPY_DST,
            mapped_at_creation: false,
        });
        let layout = group_layout(device);
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("models"),
            layout: &layout,
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: materials.as_entire_binding(),
            }],
        });
        Self {
            sent_bytes: vertices.size() + indices.size() + materials.size(),
            layout,
            group,
            materials,
            vertices,
            indices,
            instances,
            models: ranges,
            written: Vec::new(),
        }
    }

    /// Bytes that making the buffers sent.
    pub fn sent_bytes(&self) -> u64 {
        self.sent_bytes
    }

    /// Writes the instances in view, model by model; returns the bytes sent, 0 where nothing changed.
    pub fn set_instances(&mut self, queue: &wgpu::Queue, rows: &[[Vec4; 3]]) -> u64 {
        if self.written == rows {
            return 0;
        }
        queue.write_buffer(&self.instances, 0, bytemuck::cast_slice(rows));
        self.written = rows.to_vec();
        Self::INSTANCE_BYTES * rows.len() as u64
    }

    /// How vertices and instances are read.
    pub fn vertex_layouts() -> [Option<wgpu::VertexBufferLayout<'static>>; 2] {
        const VERTEX: [wgpu::VertexAttribute; 4] =
            wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x2, 3 => Uint32];
        const INSTANCE: [wgpu::VertexAttribute; 3] =
            wgpu::vertex_attr_array![4 => Float32x4, 5 => Float32x4, 6 => Float32x4];
        let layout = |array_stride, step_mode, attributes| {
            Some(wgpu::VertexBufferLayout { array_stride, step_mode, attributes })
        };
        let vertex_bytes = size_of::<ModelVertex>() as u64;
        [
            layout(vertex_bytes, wgpu::VertexStepMode::Vertex, &VERTEX),
            layout(Self::INSTANCE_BYTES, wgpu::VertexStepMode::Instance, &INSTANCE),
        ]
    }

    /// The materials, vertices, indices and instances, to be read as storage.
    pub fn storage(&self) -> [&wgpu::Buffer; 4] {
        [&self.materials, &self.vertices, &self.indices, &self.instances]
    }

    /// Where the triangles of each instance lie.
    pub fn ranges(&self, runs: &[ModelRun]) -> Vec<ObjectRange> {
        let mut first_number = 0;
        let instances = runs.iter().flat_map(|run| {
            let range = self.models[run.model];
            (run.first..run.first + run.count).map(move |instance| (range, instance))
        });
        let range = |(range, instance): (ModelRange, u32)| {
            let triangles = (range.indices[0] + range.indices[1]) / 3;
            let found = ObjectRange {
                first_number,
                triangles,
                first_index: range.first_index,
                base_vertex: range.base_vertex as u32,
                instance,
                single_sided: range.indices[0] / 3,
            };
            first_number += triangles;
            found
        };
        instances.map(range).collect()
    }

    /// Draws triangles of the instances: those whose back is not drawn (0) or those seen from both sides (1).
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, runs: &[ModelRun], sides: usize) {
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
        for run in runs {
            let range = &self.models[run.model];
            let first = range.first_index + if sides == 0 { 0 } else { range.indices[0] };
            if range.indices[sides] == 0 {
                continue;
            }
            // Not every device draws from an instance other than the first.
            let begin = u64::from(run.first) * Self::INSTANCE_BYTES;
            let end = begin + u64::from(run.count) * Self::INSTANCE_BYTES;
            pass.set_vertex_buffer(1, self.instances.slice(begin..end));
            let indices = first..first + range.indices[sides];
            pass.draw_indexed(indices, range.base_vertex, 0..run.count);
        }
    }
}

/// The vertices and indices of all models, one after the other.
#[derive(Default)]
struct Geometry {
    vertices: Vec<ModelVertex>,
    indices: Vec<u32>,
    ranges: Vec<ModelRange>,
}

impl Geometry {
    fn of(models: &[Model]) -> Self {
        let (mut all, mut first_material) = (Self::default(), 0);
        for model in models {
            let single_sided = model.single_sided;
            all.ranges.push(ModelRange {
                base_vertex: all.vertices.len() as i32,
                first_index: all.indices.len() as u32,
                indices: [single_sided, model.indices.len() as u32 - single_sided],
            });
            all.vertices.extend(model.vertices.iter().map(|vertex| ModelVertex {
                material: first_material + vertex.material,
                ..*vertex
            }));
            all.indices.extend(&model.indices);
            first_material += model.materials.len() as u32;
        }
        all
    }
}

/// A buffer that holds the bytes; of a few zeros where there are none.
fn filled_buffer(
    device: &wgpu::Device,
    label: &str,
    bytes: &[u8],
    usage: wgpu::BufferUsages,
) -> wgpu::Buffer {
    use wgpu::util::DeviceExt;
    let contents = if bytes.is_empty() { &[0; 64] } else { bytes };
    device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some(label),
        contents,
        usage,
    })
}

fn group_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("models"),
        entries: &[wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility: wgpu::ShaderStages::VERTEX_FRAGMENT | wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Storage { read_only: true },
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        }],
    })
}
