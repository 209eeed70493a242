use bytemuck::{Pod, Zeroable};

use super::height_atlas::HeightAtlas;
use super::shader_library::DERIVE_HEIGHTS;
use crate::dataset::{HeightSamples, HeightTile};

/// The twin of `DecodeJob` in `derive_heights.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(super) struct DecodeJob {
    pub atlas_x: u32,
    pub atlas_y: u32,
    pub first_word: u32,
    pub is_float: u32,
    pub base_steps: i32,
    pub step_m: f32,
    pub texel_size_m: f32,
    pub stored_size: u32,
}

/// A tile on its way into a slot of the height atlas.
pub(crate) struct HeightUpload<'a> {
    pub tile: &'a HeightTile,
    pub slot: u32,
    /// Side of one texel of the tile in metres.
    pub texel_size_m: f64,
}

/// Decodes uploaded heights into the atlas and derives slopes and mips from them.
pub(crate) struct DeriveHeightsPass {
    decode: wgpu::ComputePipeline,
    slopes: wgpu::ComputePipeline,
    halve_heights: [wgpu::ComputePipeline; 2],
    halve_slopes: [wgpu::ComputePipeline; 2],
    atlas_bindings: AtlasBindings,
}

/// Bindings that never change: the atlas's own mips.
struct AtlasBindings {
    halve_heights: [wgpu::BindGroup; 2],
    slopes: wgpu::BindGroup,
    halve_slopes: [wgpu::BindGroup; 2],
}

impl DeriveHeightsPass {
    const WORKGROUP: u32 = 8;

    pub fn new(device: &wgpu::Device, atlas: &HeightAtlas) -> Self {
        let module = DERIVE_HEIGHTS.module(device);
        let pipeline = |entry: &str, source_mip: u32| {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry),
                layout: None,
                module: &module,
                entry_point: Some(entry),
                compilation_options: wgpu::PipelineCompilationOptions {
                    constants: &[("SOURCE_MIP", f64::from(source_mip))],
                    ..Default::default()
                },
                cache: None,
            })
        };
        let decode = pipeline("decode", 0);
        let slopes = pipeline("slopes", 0);
        let halve_heights = [0, 1].map(|mip| pipeline("halve_heights", mip));
        let halve_slopes = [0, 1].map(|mip| pipeline("halve_slopes", mip));
        let atlas_bindings =
            AtlasBindings::new(device, atlas, &slopes, &halve_heights, &halve_slopes);
        Self { decode, slopes, halve_heights, halve_slopes, atlas_bindings }
    }

    /// Uploads the tiles and records the passes that derive the rest; returns the bytes sent.
    pub fn record(
        &self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        atlas: &HeightAtlas,
        uploads: &[HeightUpload<'_>],
    ) -> u64 {
        if uploads.is_empty() {
            return 0;
        }
        let (jobs, payload) = pack(atlas, uploads);
        let sent = (size_of_val(jobs.as_slice()) + payload.len()) as u64;
        let job_buffer = mapped_buffer(device, "height jobs", bytemuck::cast_slice(&jobs));
        let payload_buffer = mapped_buffer(device, "height payload", &payload);
        let bind = |pipeline: &wgpu::ComputePipeline, entries: &[wgpu::BindGroupEntry<'_>]| {
            device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("height jobs"),
                layout: &pipeline.get_bind_group_layout(0),
                entries,
            })
        };
        let jobs_entry = entry(0, job_buffer.as_entire_binding());
        let heights_out = atlas.height_mip(0);
        let decode_inputs = bind(
            &self.decode,
            &[
                jobs_entry.clone(),
                entry(1, payload_buffer.as_entire_binding()),
                entry(2, wgpu::BindingResource::TextureView(&heights_out)),
            ],
        );
        let jobs_for =
            |pipeline: &wgpu::ComputePipeline| bind(pipeline, std::slice::from_ref(&jobs_entry));

        let count = uploads.len() as u32;
        let size = atlas.grid.slot_size_texels;
        let bindings = &self.atlas_bindings;
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("derive heights"),
            timestamp_writes: None,
        });
        let mut run = |pipeline: &wgpu::ComputePipeline, groups: &[&wgpu::BindGroup], size: u32| {
            pass.set_pipeline(pipeline);
            for (index, &group) in (0..).zip(groups) {
                pass.set_bind_group(index, group, &[]);
            }
            let workgroups = size.div_ceil(Self::WORKGROUP);
            pass.dispatch_workgroups(workgroups, workgroups, count);
        };
        run(&self.decode, &[&decode_inputs], size);
        let jobs = jobs_for(&self.slopes);
        run(&self.slopes, &[&jobs, &bindings.slopes], size);
        for mip in 0..2 {
            let jobs = jobs_for(&self.halve_heights[mip]);
            let size = size >> (mip + 1);
            run(&self.halve_heights[mip], &[&jobs, &bindings.halve_heights[mip]], size);
            let jobs = jobs_for(&self.halve_slopes[mip]);
            run(&self.halve_slopes[mip], &[&jobs, &bindings.halve_slopes[mip]], size);
        }
        sent
    }
}

impl AtlasBindings {
    fn new(
        device: &wgpu::Device,
        atlas: &HeightAtlas,
        slopes: &wgpu::ComputePipeline,
        halve_heights: &[wgpu::ComputePipeline; 2],
        halve_slopes: &[wgpu::ComputePipeline; 2],
    ) -> Self {
        let heights = [0, 1, 2].map(|mip| atlas.height_mip(mip));
        let slope_views = [0, 1, 2].map(|mip| atlas.slope_mip(mip));
        let bind = |layout: wgpu::BindGroupLayout, views: &[(u32, &wgpu::TextureView)]| {
            let entries = views
                .iter()
                .map(|&(binding, view)| entry(binding, wgpu::BindingResource::TextureView(view)))
                .collect::<Vec<_>>();
            device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("derive heights"),
                layout: &layout,
                entries: &entries,
            })
        };
        Self {
            halve_heights: [0, 1].map(|mip| {
                let layout = halve_heights[mip].get_bind_group_layout(1);
                bind(layout, &[(0, &heights[mip]), (1, &heights[mip + 1])])
            }),
            slopes: bind(
                slopes.get_bind_group_layout(1),
                &[(2, &heights[0]), (3, &slope_views[0])],
            ),
            halve_slopes: [0, 1].map(|mip| {
                let layout = halve_slopes[mip].get_bind_group_layout(1);
                bind(layout, &[(3, &slope_views[mip + 1]), (4, &slope_views[mip])])
            }),
        }
    }
}

fn entry(binding: u32, resource: wgpu::BindingResource<'_>) -> wgpu::BindGroupEntry<'_> {
    wgpu::BindGroupEntry { binding, resource }
}

/// The jobs, and the samples of all tiles one after the other, each from a whole u32 on.
fn pack(atlas: &HeightAtlas, uploads: &[HeightUpload<'_>]) -> (Vec<DecodeJob>, Vec<u8>) {
    let mut payload = Vec::new();
    let mut jobs = Vec::with_capacity(uploads.len());
    for upload in uploads {
        let [atlas_x, atlas_y] = atlas.grid.slot_origin_texels(upload.slot);
        let first_word = (payload.len() / 4) as u32;
        let (is_float, base_steps, step_m) = match &upload.tile.samples {
            HeightSamples::Steps { base_steps, step_m, words } => {
                payload.extend_from_slice(bytemuck::cast_slice(words));
                (0, *base_steps, *step_m)
            }
            HeightSamples::Metres(heights_m) => {
                payload.extend_from_slice(bytemuck::cast_slice(heights_m));
                (1, 0, 0.0)
            }
        };
        payload.resize(payload.len().next_multiple_of(4), 0);
        jobs.push(DecodeJob {
            atlas_x,
            atlas_y,
            first_word,
            is_float,
            base_steps,
            step_m,
            texel_size_m: upload.texel_size_m as f32,
            stored_size: atlas.grid.slot_size_texels,
        });
    }
    (jobs, payload)
}

fn mapped_buffer(device: &wgpu::Device, label: &str, bytes: &[u8]) -> wgpu::Buffer {
    use wgpu::util::DeviceExt;
    device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some(label),
        contents: bytes,
        usage: wgpu::BufferUsages::STORAGE,
    })
}
