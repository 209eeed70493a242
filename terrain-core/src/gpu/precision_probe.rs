//! Runs the arithmetic under study on the device itself: one compute dispatch a question.

use bytemuck::{Pod, Zeroable};
use wgpu::util::DeviceExt;

use super::context::{GpuContext, GpuError};
use super::frame_uniforms::FrameUniforms;
use super::shader_library::{
    PRECISION_ENCODINGS, PRECISION_FLOATS, PRECISION_NATIVE, PRECISION_NATIVE_F16,
    PRECISION_NATIVE_F64, PRECISION_SPAN, PRECISION_SPAN_F64, Shader,
};
use crate::precision::encodings::{Decoded, EncodedPoint, Encoding};

/// What the device decodes from a point: the twin of `Answer` in `precision_encodings.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Answer {
    /// One an encoding, in the order of [`Encoding::ALL`].
    pub decoded: [Decoded; Encoding::ALL.len()],
    /// Fixed-point position that the renderer's lookup takes the point for.
    pub position: [i32; 2],
}

/// A number of bits to try: the twin of `Trial` in `precision_span.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Trial {
    /// Ground distance over height.
    pub range: f32,
    /// Half the angle of a pixel, radians.
    pub half_pixel_rad: f32,
    /// Part of a texel that the coordinate may be off.
    pub texel_part: f32,
    /// Bits of the dot products, 1 to 32.
    pub bits: u32,
}

/// The worst of a trial's phases, each over its bound: the twin of `Outcome` in `precision_span.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Outcome {
    /// Movement of the ground under the ray, over half a footprint.
    pub moved: f32,
    /// Change of the level of detail, over half a level.
    pub level: f32,
    /// Error of the texture coordinate, over its part of a texel.
    pub texture: f32,
}

/// Numbers to compute with: the twin of `Operands` in `precision_floats.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[expect(missing_docs, reason = "three numbers")]
pub struct Operands {
    pub a: f32,
    pub b: f32,
    pub c: f32,
}

/// What the device made of them: the twin of `Results` in `precision_floats.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Results {
    /// `a * b + c` as written.
    pub plain: f32,
    /// `fma(a, b, c)`.
    pub fused: f32,
    /// `a / b`.
    pub quotient: f32,
    /// Error of the rounded `a + b`.
    pub sum_error: f32,
    /// Error of the rounded `a * b`.
    pub product_error: f32,
}

/// A float format of the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NativeFloat {
    /// 11 significant bits; needs an optional feature.
    F16,
    /// 24 significant bits.
    F32,
    /// 53 significant bits; needs an optional feature.
    F64,
}

impl NativeFloat {
    /// Significant bits of the format.
    pub fn significant_bits(self) -> u32 {
        match self {
            Self::F16 => 11,
            Self::F32 => 24,
            Self::F64 => 53,
        }
    }

    /// Whether the device computes in it.
    pub fn is_available(self, gpu: &GpuContext) -> bool {
        let features = gpu.device.features();
        match self {
            Self::F16 => features.contains(wgpu::Features::SHADER_F16),
            Self::F32 => true,
            Self::F64 => features.contains(wgpu::Features::SHADER_F64),
        }
    }
}

/// Decodes the points on the device, in the frame whose uniforms are given.
///
/// # Errors
/// [`GpuError::Lost`] where the device fails.
pub fn probe_encodings(
    gpu: &GpuContext,
    frame: &FrameUniforms,
    points: &[EncodedPoint],
) -> Result<Vec<Answer>, GpuError> {
    Probe { shader: &PRECISION_ENCODINGS, entry: "decode", frame: Some(frame) }.run(gpu, points)
}

/// Tries numbers of bits in f32, or in f64 if so asked; `None` where the device has no f64.
///
/// # Errors
/// [`GpuError::Lost`] where the device fails.
pub fn probe_span(
    gpu: &GpuContext,
    float: NativeFloat,
    trials: &[Trial],
) -> Result<Option<Vec<Outcome>>, GpuError> {
    let shader = match float {
        NativeFloat::F32 => &PRECISION_SPAN,
        NativeFloat::F64 if float.is_available(gpu) => &PRECISION_SPAN_F64,
        NativeFloat::F16 | NativeFloat::F64 => return Ok(None),
    };
    Probe { shader, entry: "try_bits", frame: None }.run(gpu, trials).map(Some)
}

/// Texture coordinates under rays (along and across the view, 1 down) computed in a float format, each
/// as a sum of two f32s; `None` where the device does not have the format.
///
/// # Errors
/// [`GpuError::Lost`] where the device fails.
pub fn probe_native(
    gpu: &GpuContext,
    float: NativeFloat,
    rays: &[[f32; 2]],
) -> Result<Option<Vec<[f32; 2]>>, GpuError> {
    if !float.is_available(gpu) {
        return Ok(None);
    }
    let shader = match float {
        NativeFloat::F16 => &PRECISION_NATIVE_F16,
        NativeFloat::F32 => &PRECISION_NATIVE,
        NativeFloat::F64 => &PRECISION_NATIVE_F64,
    };
    Probe { shader, entry: "divide", frame: None }.run(gpu, rays).map(Some)
}

/// Sums, products and quotients as the device computes them.
///
/// # Errors
/// [`GpuError::Lost`] where the device fails.
pub fn probe_floats(gpu: &GpuContext, operands: &[Operands]) -> Result<Vec<Results>, GpuError> {
    Probe { shader: &PRECISION_FLOATS, entry: "compute_floats", frame: None }.run(gpu, operands)
}

/// A compute shader that turns an array into another of the same length.
struct Probe<'a> {
    shader: &'static Shader,
    entry: &'static str,
    frame: Option<&'a FrameUniforms>,
}

/// Invocations in a workgroup of every probe.
const LANES: u32 = 64;

impl Probe<'_> {
    fn run<Input: Pod, Output: Pod>(
        &self,
        gpu: &GpuContext,
        inputs: &[Input],
    ) -> Result<Vec<Output>, GpuError> {
        if inputs.is_empty() {
            return Ok(Vec::new());
        }
        use wgpu::BufferUsages as Usage;
        let output_bytes = (inputs.len() * size_of::<Output>()) as u64;
        let input = filled(gpu, bytemuck::cast_slice(inputs), Usage::STORAGE);
        let output = empty(gpu, output_bytes, Usage::STORAGE | Usage::COPY_SRC);
        let readback = empty(gpu, output_bytes, Usage::MAP_READ | Usage::COPY_DST);
        let arrays = Bindings::new(gpu, &[(&input, true), (&output, false)]);
        let frame = self.frame.map(|frame| Bindings::of_frame(gpu, frame));
        let pipeline = self.pipeline(gpu, frame.as_ref(), &arrays);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        if let Some(frame) = &frame {
            pass.set_bind_group(0, &frame.group, &[]);
        }
        pass.set_bind_group(2, &arrays.group, &[]);
        pass.dispatch_workgroups((inputs.len() as u32).div_ceil(LANES), 1, 1);
        drop(pass);
        encoder.copy_buffer_to_buffer(&output, 0, &readback, 0, output_bytes);
        gpu.queue.submit([encoder.finish()]);
        read(gpu, &readback)
    }

    fn pipeline(
        &self,
        gpu: &GpuContext,
        frame: Option<&Bindings>,
        arrays: &Bindings,
    ) -> wgpu::ComputePipeline {
        let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(self.shader.name),
            bind_group_layouts: &[frame.map(|frame| &frame.layout), None, Some(&arrays.layout)],
            immediate_size: 0,
        });
        gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(self.shader.name),
            layout: Some(&layout),
            module: &self.shader.module(&gpu.device),
            entry_point: Some(self.entry),
            compilation_options: Default::default(),
            cache: None,
        })
    }
}

/// A group of buffers with its layout.
struct Bindings {
    layout: wgpu::BindGroupLayout,
    group: wgpu::BindGroup,
}

impl Bindings {
    fn of_frame(gpu: &GpuContext, frame: &FrameUniforms) -> Self {
        let buffer = filled(gpu, &frame.to_bytes(), wgpu::BufferUsages::UNIFORM);
        Self::of(gpu, &[(&buffer, wgpu::BufferBindingType::Uniform)])
    }

    /// Storage buffers, each with whether it is only read.
    fn new(gpu: &GpuContext, buffers: &[(&wgpu::Buffer, bool)]) -> Self {
        let typed = buffers
            .iter()
            .map(|&(buffer, read_only)| (buffer, wgpu::BufferBindingType::Storage { read_only }));
        Self::of(gpu, &typed.collect::<Vec<_>>())
    }

    fn of(gpu: &GpuContext, buffers: &[(&wgpu::Buffer, wgpu::BufferBindingType)]) -> Self {
        let layout_entries = (0..).zip(buffers).map(|(binding, &(_, ty))| {
            let ty =
                wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
            let visibility = wgpu::ShaderStages::COMPUTE;
            wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None }
        });
        let layout = gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("precision probe"),
            entries: &layout_entries.collect::<Vec<_>>(),
        });
        let entries = (0..).zip(buffers).map(|(binding, (buffer, _))| wgpu::BindGroupEntry {
            binding,
            resource: buffer.as_entire_binding(),
        });
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("precision probe"),
            layout: &layout,
            entries: &entries.collect::<Vec<_>>(),
        });
        Self { layout, group }
    }
}

fn filled(gpu: &GpuContext, contents: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
    let label = Some("precision probe");
    gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label, contents, usage })
}

fn empty(gpu: &GpuContext, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("precision probe"),
        size,
        usage,
        mapped_at_creation: false,
    })
}

fn read<T: Pod>(gpu: &GpuContext, buffer: &wgpu::Buffer) -> Result<Vec<T>, GpuError> {
    buffer.slice(..).map_async(wgpu::MapMode::Read, |_| ());
    gpu.wait()?;
    let view = buffer.slice(..).get_mapped_range();
    let view = view.map_err(|error| GpuError::Lost(error.to_string()))?;
    Ok(bytemuck::pod_collect_to_vec::<u8, T>(&view))
}
