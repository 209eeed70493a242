use super::map_pass::MapTriangles;
use super::scene_map::SceneTriangles;
use crate::gpu::objects::{ModelRun, ObjectBuffers, ObjectRange};

/// Where the triangles of models' instances lie, on the GPU.
pub(crate) struct ObjectRanges {
    buffer: wgpu::Buffer,
    written: Vec<ObjectRange>,
}

impl ObjectRanges {
    /// For so many instances at the most.
    pub fn new(device: &wgpu::Device, most_instances: usize) -> Self {
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("models' ranges"),
            size: (most_instances.max(1) * size_of::<ObjectRange>()) as u64,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Self { buffer, written: Vec::new() }
    }

    /// Writes the ranges of the instances in view; returns the bytes sent, 0 where nothing changed.
    pub fn set(&mut self, queue: &wgpu::Queue, objects: &ObjectBuffers, runs: &[ModelRun]) -> u64 {
        let ranges = objects.ranges(runs);
        if ranges == self.written {
            return 0;
        }
        queue.write_buffer(&self.buffer, 0, bytemuck::cast_slice(&ranges));
        self.written = ranges;
        size_of_val(&self.written[..]) as u64
    }

    /// The triangles, as `map_objects.wgsl` reads them.
    pub fn triangles<'a>(&'a self, objects: &'a ObjectBuffers) -> SceneTriangles<'a> {
        let [materials, vertices, indices, instances] = objects.storage();
        let count = self.written.last().map_or(0, |last| last.first_number + last.triangles);
        let longest = self.written.iter().map(|range| range.triangles).max();
        let run = 0..count;
        SceneTriangles {
            buffers: [materials, vertices, indices, instances, &self.buffer],
            triangles: MapTriangles {
                runs: if run.is_empty() { Vec::new() } else { vec![run] },
                ranges: self.written.len() as u32,
                longest_range: longest.unwrap_or(0),
            },
            // Turning the camera does not make the passes anew.
            most: count.next_power_of_two(),
        }
    }
}
