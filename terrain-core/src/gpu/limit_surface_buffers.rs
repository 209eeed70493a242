use wgpu::util::DeviceExt;

use super::limit_surface_pass::LimitUniforms;
use super::{GpuContext, GpuError};
use crate::reference::limit_surface::{LimitSurface, MipTexture};

/// A limit-triangulated surface and its texture on the GPU.
pub(super) struct LimitSurfaceBuffers {
    heights: wgpu::Buffer,
    ranges: wgpu::Buffer,
    words: wgpu::Buffer,
    knots: wgpu::Buffer,
    distances: wgpu::Buffer,
    imagery: wgpu::TextureView,
    trilinear: wgpu::Sampler,
    anisotropic: wgpu::Sampler,
}

impl LimitSurfaceBuffers {
    const MOST_TAPS: u16 = 16;

    /// Sends everything, heights relative to `base_m`.
    pub fn new(
        gpu: &GpuContext,
        surface: &LimitSurface,
        texture: &MipTexture,
        base_m: f64,
    ) -> Result<Self, GpuError> {
        let limits = gpu.device.limits();
        let (words, knots) = surface.colours().as_words();
        let most_bytes = limits.max_storage_buffer_binding_size;
        let largest = 4 * words.len().max(knots.len()) as u64;
        let side = texture.level(0).0.into_iter().max().unwrap_or(0) as u64;
        if largest > most_bytes || side > u64::from(limits.max_texture_dimension_2d) {
            return Err(GpuError::Unsuitable {
                adapter: gpu.adapter.get_info().name,
                reason: format!(
                    "the surface takes a buffer of {largest} bytes (it has up to {most_bytes}) and \
                     a texture of {side} texels a side"
                ),
            });
        }
        let device = &gpu.device;
        let relative = |height_m: f32| (f64::from(height_m) - base_m) as f32;
        let relief = surface.relief();
        let heights: Vec<f32> = relief.heights_m().iter().map(|&h| relative(h)).collect();
        let ranges: Vec<[f32; 2]> =
            relief.pyramid().as_parts().0.iter().map(|range| range.map(relative)).collect();
        let distances: Vec<f32> =
            surface.colours().distances().as_slice().iter().map(|&d| d as f32).collect();
        Ok(Self {
            heights: storage(device, "heights", bytemuck::cast_slice(&heights)),
            ranges: storage(device, "ranges", bytemuck::cast_slice(&ranges)),
            words: storage(device, "triangles", bytemuck::cast_slice(words)),
            knots: storage(device, "knots", bytemuck::cast_slice(knots)),
            distances: storage(device, "distances", bytemuck::cast_slice(&distances)),
            imagery: upload(gpu, texture),
            trilinear: sampler(device, 1),
            anisotropic: sampler(device, Self::MOST_TAPS),
        })
    }

    /// The layout of [`Self::bind`].
    pub fn layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
        use wgpu::BufferBindingType::{Storage, Uniform};
        let buffer = |ty| wgpu::BindingType::Buffer {
            ty,
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let read = || buffer(Storage { read_only: true });
        let imagery = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: true },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let types = [
            buffer(Uniform),
            read(),
            read(),
            read(),
            read(),
            read(),
            read(),
            buffer(Storage { read_only: false }),
            imagery,
            wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
            wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
        ];
        let entries = (0..).zip(types).map(|(binding, ty)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty,
            count: None,
        });
        device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("limit surface"),
            entries: &entries.collect::<Vec<_>>(),
        })
    }

    /// Binds everything for one cast.
    pub fn bind(
        &self,
        gpu: &GpuContext,
        layout: &wgpu::BindGroupLayout,
        uniforms: &LimitUniforms,
        places: &wgpu::Buffer,
        pixels: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        let uniforms = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("limit uniforms"),
            contents: bytemuck::bytes_of(uniforms),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let buffers = [
            &uniforms,
            &self.heights,
            &self.ranges,
            &self.words,
            &self.knots,
            &self.distances,
            places,
            pixels,
        ];
        let resources = buffers.into_iter().map(wgpu::Buffer::as_entire_binding).chain([
            wgpu::BindingResource::TextureView(&self.imagery),
            wgpu::BindingResource::Sampler(&self.trilinear),
            wgpu::BindingResource::Sampler(&self.anisotropic),
        ]);
        let entries = (0..)
            .zip(resources)
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource });
        gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("limit surface"),
            layout,
            entries: &entries.collect::<Vec<_>>(),
        })
    }
}

/// A read-only storage buffer; never empty, since that cannot be bound.
pub(super) fn storage(device: &wgpu::Device, label: &str, bytes: &[u8]) -> wgpu::Buffer {
    let contents = if bytes.is_empty() { &[0; 4] } else { bytes };
    let usage = wgpu::BufferUsages::STORAGE;
    device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some(label),
        contents,
        usage,
    })
}

/// Linear in all directions and between levels, with at most so many taps.
fn sampler(device: &wgpu::Device, anisotropy_clamp: u16) -> wgpu::Sampler {
    device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("imagery"),
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        mipmap_filter: wgpu::MipmapFilterMode::Linear,
        anisotropy_clamp,
        ..Default::default()
    })
}

/// The texture with as many of its mip levels as halve exactly: GPUs round sizes down, the texture up.
fn upload(gpu: &GpuContext, texture: &MipTexture) -> wgpu::TextureView {
    let [width, height] = texture.level(0).0.map(|side| side as u32);
    let halvings = width.trailing_zeros().min(height.trailing_zeros());
    let mip_level_count = (halvings + 1).min(texture.level_count() as u32);
    let target = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("imagery"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8UnormSrgb,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    for mip_level in 0..mip_level_count {
        let (size, texels) = texture.level(mip_level as usize);
        let [width, height] = size.map(|side| side as u32);
        gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo { mip_level, ..target.as_image_copy() },
            bytemuck::cast_slice(texels),
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(4 * width),
                rows_per_image: Some(height),
            },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
    }
    target.create_view(&Default::default())
}
