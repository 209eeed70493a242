use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3, dvec3};

use super::limit_surface_buffers::{LimitSurfaceBuffers, storage};
use super::shader_library::LIMIT_SURFACE;
use super::{GpuContext, GpuError};
use crate::CameraView;
use crate::reference::limit_surface::{
    AccessCounts, CastPicture, LimitGrid, LimitSurface, MipTexture, RayPattern,
};

/// How the GPU colours rays that meet a limit-triangulated surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LimitGpuColour {
    /// From the triangle, formula (4).
    Limit,
    /// The texture unit's trilinear filter.
    Trilinear,
    /// The texture unit's anisotropic filter, at most 16 taps.
    Anisotropic,
}

/// A picture cast by the GPU.
#[derive(Clone, Debug)]
pub struct LimitGpuPicture {
    /// The picture. Texels read by the texture unit are counted as its filters are defined.
    pub picture: CastPicture,
    /// The triangle that each pixel's first ray meets and its distance in metres.
    pub first_hits: Vec<Option<(u32, f32)>>,
    /// Milliseconds the GPU took; `None` without timestamp queries.
    pub gpu_ms: Option<f64>,
}

/// Casts rays on a limit-triangulated surface in a compute pass, one invocation a pixel.
pub struct LimitSurfacePass {
    /// A pipeline a way of colouring.
    pipelines: [wgpu::ComputePipeline; 3],
    layout: wgpu::BindGroupLayout,
    buffers: LimitSurfaceBuffers,
    scene: Scene,
}

/// What uniforms need to know of the surface and its texture.
struct Scene {
    grid: LimitGrid,
    lowest_m: f64,
    highest_m: f64,
    base_m: f64,
    levels: Vec<[u32; 2]>,
    texture_origin: glam::DVec2,
    texture_size_m: glam::DVec2,
    texel_m: f64,
}

/// See the shader's struct of the same name.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct LimitUniforms {
    pub ray_corner: [f32; 3],
    pub cell_m: f32,
    pub ray_per_column: [f32; 3],
    pub lowest_m: f32,
    pub ray_per_row: [f32; 3],
    pub highest_m: f32,
    pub eye: [f32; 3],
    pub ray_angle: f32,
    pub background: [f32; 3],
    pub rays: u32,
    pub eye_cell: [i32; 2],
    pub grid_size: [i32; 2],
    pub uv_origin: [f32; 2],
    pub uv_per_cell: [f32; 2],
    pub size_px: [u32; 2],
    pub texel_m: f32,
    pub top_level: u32,
    pub levels: [[u32; 4]; 32],
}

/// See the shader's struct of the same name.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct CastPixel {
    pub linear: [f32; 3],
    pub triangle: u32,
    pub distance_m: f32,
    pub hits: u32,
    pub words: u32,
    pub places: u32,
}

impl LimitSurfacePass {
    const WORKGROUP: u32 = 8;

    /// Sends a surface and the texture it was made from to the GPU.
    ///
    /// # Errors
    /// [`GpuError::Unsuitable`] where they are larger than its buffers or textures may be.
    pub fn new(
        gpu: &GpuContext,
        surface: &LimitSurface,
        texture: &MipTexture,
    ) -> Result<Self, GpuError> {
        let scene = Scene::new(surface, texture);
        let buffers = LimitSurfaceBuffers::new(gpu, surface, texture, scene.base_m)?;
        let module = LIMIT_SURFACE.module(&gpu.device);
        let layout = LimitSurfaceBuffers::layout(&gpu.device);
        let pipeline_layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("limit surface"),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let pipeline = |method: f64| {
            gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some("limit surface"),
                layout: Some(&pipeline_layout),
                module: &module,
                entry_point: Some("cast_rays"),
                compilation_options: wgpu::PipelineCompilationOptions {
                    constants: &[("METHOD", method)],
                    ..Default::default()
                },
                cache: None,
            })
        };
        let pipelines = [0.0, 1.0, 2.0].map(pipeline);
        gpu.check()?;
        Ok(Self { pipelines, layout, buffers, scene })
    }

    /// Casts a picture and waits for it. `ray_angle_rad` is the angle a ray stands for, `background`
    /// linear light where nothing is met.
    ///
    /// # Errors
    /// Where the device fails.
    pub fn cast(
        &self,
        gpu: &GpuContext,
        view: &CameraView,
        rays: RayPattern,
        colour: LimitGpuColour,
        ray_angle_rad: f64,
        background: Vec3,
    ) -> Result<LimitGpuPicture, GpuError> {
        let uniforms = self.scene.uniforms(view, rays, ray_angle_rad, background);
        let run = Run::new(gpu, self, &uniforms, rays);
        let pipeline = match colour {
            LimitGpuColour::Limit => &self.pipelines[0],
            LimitGpuColour::Trilinear => &self.pipelines[1],
            LimitGpuColour::Anisotropic => &self.pipelines[2],
        };
        let groups = view.viewport_px.map(|side| side.div_ceil(Self::WORKGROUP));
        let (pixels, gpu_ms) = run.submit(gpu, pipeline, groups)?;
        Ok(picture_of(view.viewport_px, rays, &pixels, gpu_ms))
    }
}

impl Scene {
    fn new(surface: &LimitSurface, texture: &MipTexture) -> Self {
        let relief = surface.relief();
        let [lowest_m, highest_m] = relief.pyramid().whole().map(f64::from);
        // Whole metres: the difference of a height from it is exact in f32.
        let base_m = if lowest_m.is_finite() { lowest_m.floor() } else { 0.0 };
        let size = texture.level(0).0.map(|side| side as f64);
        Self {
            grid: *relief.grid(),
            lowest_m,
            highest_m,
            base_m,
            levels: relief.pyramid().as_parts().1,
            texture_origin: texture.origin(),
            texture_size_m: glam::DVec2::from(size) * texture.texel_m(),
            texel_m: texture.texel_m(),
        }
    }

    fn uniforms(
        &self,
        view: &CameraView,
        rays: RayPattern,
        ray_angle_rad: f64,
        background: Vec3,
    ) -> LimitUniforms {
        let grid = &self.grid;
        let per_m = dvec3(1.0 / grid.cell_m, -1.0 / grid.cell_m, 1.0);
        let corner = grid.origin.extend(self.base_m);
        let eye = (view.eye - corner) * per_m;
        let eye_cell = eye.truncate().floor();
        let [ray_corner, ray_per_column, ray_per_row] = picture_rays(view).map(|ray| ray * per_m);
        let from_texture = (grid.origin - self.texture_origin) * per_m.truncate();
        let mut levels = [[0; 4]; 32];
        for (level, &[start, columns]) in levels.iter_mut().zip(&self.levels) {
            *level = [start, columns, 0, 0];
        }
        let array = |v: DVec3| v.as_vec3().to_array();
        LimitUniforms {
            ray_corner: array(ray_corner),
            cell_m: grid.cell_m as f32,
            ray_per_column: array(ray_per_column),
            lowest_m: (self.lowest_m - self.base_m) as f32,
            ray_per_row: array(ray_per_row),
            highest_m: (self.highest_m - self.base_m) as f32,
            eye: array(eye - eye_cell.extend(0.0)),
            ray_angle: ray_angle_rad as f32,
            background: background.to_array(),
            rays: rays.rays(),
            eye_cell: eye_cell.as_ivec2().to_array(),
            grid_size: [grid.columns as i32, grid.rows as i32],
            uv_origin: (eye_cell + from_texture).as_vec2().to_array(),
            uv_per_cell: (grid.cell_m / self.texture_size_m).as_vec2().to_array(),
            size_px: view.viewport_px,
            texel_m: self.texel_m as f32,
            top_level: self.levels.len() as u32,
            levels,
        }
    }
}

/// World directions, not normalised: through the picture's top left corner, and the changes by a pixel
/// to the right and down.
fn picture_rays(view: &CameraView) -> [DVec3; 3] {
    let [width, height] = view.viewport_px.map(f64::from);
    let half_height = (0.5 * view.fov_y_deg.to_radians()).tan();
    let axes = view.view_from_world();
    let right = axes.row(0) * (half_height * view.aspect());
    let up = axes.row(1) * half_height;
    [up - right - axes.row(2), right * (2.0 / width), up * (-2.0 / height)]
}

fn picture_of(
    size_px: [u32; 2],
    rays: RayPattern,
    pixels: &[CastPixel],
    gpu_ms: Option<f64>,
) -> LimitGpuPicture {
    let sum = |of: fn(&CastPixel) -> u32| pixels.iter().map(|pixel| u64::from(of(pixel))).sum();
    let accesses = AccessCounts {
        rays: pixels.len() as u64 * u64::from(rays.rays()),
        hits: sum(|pixel| pixel.hits),
        words: sum(|pixel| pixel.words),
        places: sum(|pixel| pixel.places),
    };
    let first_hit = |pixel: &CastPixel| {
        (pixel.triangle != u32::MAX).then_some((pixel.triangle, pixel.distance_m))
    };
    LimitGpuPicture {
        first_hits: pixels.iter().map(first_hit).collect(),
        picture: CastPicture {
            size_px,
            linear: pixels.iter().map(|pixel| Vec3::from_array(pixel.linear)).collect(),
            accesses,
        },
        gpu_ms,
    }
}

/// The resources of one cast.
struct Run {
    bindings: wgpu::BindGroup,
    pixels: wgpu::Buffer,
    readback: wgpu::Buffer,
    stamps: Option<Stamps>,
}

struct Stamps {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    readback: wgpu::Buffer,
}

impl Run {
    fn new(
        gpu: &GpuContext,
        pass: &LimitSurfacePass,
        uniforms: &LimitUniforms,
        rays: RayPattern,
    ) -> Self {
        let device = &gpu.device;
        let [width, height] = uniforms.size_px.map(u64::from);
        let bytes = width * height * size_of::<CastPixel>() as u64;
        let places: Vec<[f32; 2]> = rays.places().map(|place| place.as_vec2().to_array()).collect();
        let places = storage(device, "ray places", bytemuck::cast_slice(&places));
        let pixels =
            buffer(device, bytes, wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC);
        let bindings = pass.buffers.bind(gpu, &pass.layout, uniforms, &places, &pixels);
        let readback = buffer(device, bytes, READBACK);
        let has_queries = device.features().contains(wgpu::Features::TIMESTAMP_QUERY);
        let stamps = has_queries.then(|| Stamps::new(device));
        Self { bindings, pixels, readback, stamps }
    }

    fn submit(
        &self,
        gpu: &GpuContext,
        pipeline: &wgpu::ComputePipeline,
        [columns, rows]: [u32; 2],
    ) -> Result<(Vec<CastPixel>, Option<f64>), GpuError> {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("limit surface"),
            timestamp_writes: self.stamps.as_ref().map(|stamps| wgpu::ComputePassTimestampWrites {
                query_set: &stamps.queries,
                beginning_of_pass_write_index: Some(0),
                end_of_pass_write_index: Some(1),
            }),
        });
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &self.bindings, &[]);
        pass.dispatch_workgroups(columns, rows, 1);
        drop(pass);
        encoder.copy_buffer_to_buffer(&self.pixels, 0, &self.readback, 0, self.readback.size());
        if let Some(stamps) = &self.stamps {
            encoder.resolve_query_set(&stamps.queries, 0..2, &stamps.resolved, 0);
            encoder.copy_buffer_to_buffer(&stamps.resolved, 0, &stamps.readback, 0, Stamps::BYTES);
        }
        gpu.queue.submit([encoder.finish()]);
        let pixels = read::<CastPixel>(gpu, &self.readback)?;
        let Some(stamps) = &self.stamps else { return Ok((pixels, None)) };
        let ticks = read::<u64>(gpu, &stamps.readback)?;
        let period_ns = f64::from(gpu.queue.get_timestamp_period());
        let gpu_ms = ticks[1].checked_sub(ticks[0]).map(|ticks| ticks as f64 * period_ns * 1.0e-6);
        Ok((pixels, gpu_ms))
    }
}

impl Stamps {
    const BYTES: u64 = 16;

    fn new(device: &wgpu::Device) -> Self {
        let resolve = wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC;
        Self {
            queries: device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("limit surface"),
                ty: wgpu::QueryType::Timestamp,
                count: 2,
            }),
            resolved: buffer(device, Self::BYTES, resolve),
            readback: buffer(device, Self::BYTES, READBACK),
        }
    }
}

const READBACK: wgpu::BufferUsages =
    wgpu::BufferUsages::COPY_DST.union(wgpu::BufferUsages::MAP_READ);

fn buffer(device: &wgpu::Device, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
    let label = Some("limit surface");
    device.create_buffer(&wgpu::BufferDescriptor { label, size, usage, mapped_at_creation: false })
}

fn read<T: Pod>(gpu: &GpuContext, buffer: &wgpu::Buffer) -> Result<Vec<T>, GpuError> {
    buffer.slice(..).map_async(wgpu::MapMode::Read, |_| ());
    gpu.wait()?;
    let view = buffer.slice(..).get_mapped_range();
    let view = view.map_err(|error| GpuError::Lost(error.to_string()))?;
    Ok(bytemuck::pod_collect_to_vec(&view))
}
