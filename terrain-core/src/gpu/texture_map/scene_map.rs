use std::time::Instant;

use super::depth_pyramid::DepthPyramid;
use super::map_pass::{MapBindings, MapTriangles, TextureMapPass, TextureMapUniforms};
use crate::built_for::BuiltFor;
use crate::gpu::frame_group::FrameGroup;
use crate::gpu::page_table::{PageBindings, PageMarks};
use crate::gpu::shader_library::Shader;
use crate::gpu::{GpuContext, GpuError};
use crate::residency::page_table::{FaceCulling, PageLayout};

/// The texture map of one kind of triangles: its passes and the depth of its scene, made anew when what they are
/// made for changes.
pub(crate) struct SceneMap {
    shader: &'static Shader,
    layout: wgpu::BindGroupLayout,
    uniforms: wgpu::Buffer,
    written: Option<TextureMapUniforms>,
    depth: Option<DepthPyramid>,
    pass: BuiltFor<PassKey, TextureMapPass>,
}

/// What decides how the map's passes are built: the map itself, where back faces are dropped, the most taps, and the
/// most triangles there may be.
type PassKey = ([u32; 2], FaceCulling, u32, u32);

/// What a map is drawn with beside its triangles.
#[derive(Clone, Copy)]
pub(crate) struct MapScene<'a> {
    pub frame: &'a FrameGroup,
    pub marks: &'a PageMarks,
    pub pages: &'a PageBindings,
    pub layout: &'a PageLayout,
    pub viewport_px: [u32; 2],
    pub face_culling: FaceCulling,
    pub anisotropy: u32,
}

/// The triangles of a scene: bindings 0 to 4 of group 3 as the kind's shader names them, and how many there are.
pub(crate) struct SceneTriangles<'a> {
    pub buffers: [&'a wgpu::Buffer; 5],
    pub triangles: MapTriangles,
    /// The numbers of triangles are less than this.
    pub most: u32,
}

impl SceneMap {
    /// A map with the shader of a kind of triangles, whose binding 0 is of this type and whose others are storage.
    pub fn new(
        device: &wgpu::Device,
        shader: &'static Shader,
        first_binding: wgpu::BufferBindingType,
    ) -> Self {
        let uniforms = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("texture map"),
            size: size_of::<TextureMapUniforms>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let layout = group_layout(device, first_binding);
        Self { shader, layout, uniforms, written: None, depth: None, pass: BuiltFor::default() }
    }

    /// Records the marking of all pages that the triangles show; `draw_depth` draws what may hide them. Returns the
    /// bytes sent for it.
    pub fn mark(
        &mut self,
        gpu: &GpuContext,
        encoder: &mut wgpu::CommandEncoder,
        scene: MapScene<'_>,
        drawn: &SceneTriangles<'_>,
        draw_depth: impl FnOnce(&mut wgpu::RenderPass<'_>),
    ) -> u64 {
        let (sent, group) = self.set_up(gpu, encoder, scene, drawn, draw_depth);
        self.record(&gpu.device, encoder, scene, drawn, &group);
        sent
    }

    /// Milliseconds from handing [`Self::mark`]'s commands to the GPU, the scene's depth left out, until it has carried
    /// them out, so many times over.
    pub fn time(
        &mut self,
        gpu: &GpuContext,
        scene: MapScene<'_>,
        drawn: &SceneTriangles<'_>,
        draw_depth: impl FnOnce(&mut wgpu::RenderPass<'_>),
        repeats: usize,
    ) -> Result<Vec<f64>, GpuError> {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let (_, group) = self.set_up(gpu, &mut encoder, scene, drawn, draw_depth);
        gpu.queue.submit([encoder.finish()]);
        gpu.wait()?;
        let mut times_ms = Vec::with_capacity(repeats);
        for _ in 0..repeats {
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            scene.marks.clear(&mut encoder);
            self.record(&gpu.device, &mut encoder, scene, drawn, &group);
            let commands = encoder.finish();
            let started = Instant::now();
            gpu.queue.submit([commands]);
            gpu.wait()?;
            times_ms.push(started.elapsed().as_secs_f64() * 1.0e3);
        }
        Ok(times_ms)
    }

    /// Brings the uniforms to the GPU and records the scene's depth. Returns the bytes sent and group 3.
    fn set_up(
        &mut self,
        gpu: &GpuContext,
        encoder: &mut wgpu::CommandEncoder,
        scene: MapScene<'_>,
        drawn: &SceneTriangles<'_>,
        draw_depth: impl FnOnce(&mut wgpu::RenderPass<'_>),
    ) -> (u64, wgpu::BindGroup) {
        let size_px = scene.viewport_px;
        let uniforms = TextureMapUniforms::new(scene.layout, size_px, drawn.triangles.ranges);
        let sent = self.set_uniforms(&gpu.queue, &uniforms);
        let depth = match self.depth.take() {
            Some(depth) if depth.size_px() == size_px => depth,
            _ => DepthPyramid::new(&gpu.device, size_px),
        };
        depth.record(encoder, draw_depth);
        let group = self.bind(&gpu.device, drawn.buffers, &depth);
        self.depth = Some(depth);
        (sent, group)
    }

    /// Records the marking.
    fn record(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        scene: MapScene<'_>,
        drawn: &SceneTriangles<'_>,
        group: &wgpu::BindGroup,
    ) {
        let MapScene { frame, marks, pages, face_culling, anisotropy, .. } = scene;
        let bindings = MapBindings { frame, marks, pages, triangles: (&self.layout, group) };
        let ranges = drawn.triangles.ranges;
        let uniforms = TextureMapUniforms::new(scene.layout, scene.viewport_px, ranges);
        let key = (uniforms.cells, face_culling, anisotropy, drawn.most);
        let (over, how) = ((self.shader, &bindings), (face_culling, anisotropy));
        let build = || TextureMapPass::new(device, over, &uniforms, how, drawn.most);
        self.pass.get(key, build).record(encoder, &bindings, &drawn.triangles);
    }

    /// Writes the uniforms; returns the bytes sent, 0 where nothing changed.
    fn set_uniforms(&mut self, queue: &wgpu::Queue, uniforms: &TextureMapUniforms) -> u64 {
        if self.written.as_ref() == Some(uniforms) {
            return 0;
        }
        queue.write_buffer(&self.uniforms, 0, bytemuck::bytes_of(uniforms));
        self.written = Some(*uniforms);
        size_of::<TextureMapUniforms>() as u64
    }

    fn bind(
        &self,
        device: &wgpu::Device,
        buffers: [&wgpu::Buffer; 5],
        depth: &DepthPyramid,
    ) -> wgpu::BindGroup {
        let bound = (0..).zip(buffers.into_iter().chain([&self.uniforms, depth.farthest()]));
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("map triangles"),
            layout: &self.layout,
            entries: &bound
                .map(|(binding, buffer)| wgpu::BindGroupEntry {
                    binding,
                    resource: buffer.as_entire_binding(),
                })
                .collect::<Vec<_>>(),
        })
    }
}

/// Five buffers of triangles, the map's uniforms, the scene's depth.
fn group_layout(
    device: &wgpu::Device,
    first_binding: wgpu::BufferBindingType,
) -> wgpu::BindGroupLayout {
    let storage = wgpu::BufferBindingType::Storage { read_only: true };
    let types = [first_binding, storage, storage, storage, storage];
    let types = types.into_iter().chain([wgpu::BufferBindingType::Uniform, storage]);
    let entries = (0..).zip(types).map(|(binding, ty)| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::VERTEX_FRAGMENT | wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
        count: None,
    });
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("map triangles"),
        entries: &entries.collect::<Vec<_>>(),
    })
}
