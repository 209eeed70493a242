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
    /// What is derived, in this order.
    steps: [Step; 5],
}

/// Derives one mip of one texture from others.
struct Step {
    pipeline: wgpu::ComputePipeline,
    /// The mips it reads and writes: they never change.
    atlas: wgpu::BindGroup,
    /// Halvings from the tile to the mip it writes.
    halvings: u32,
}

impl DeriveHeightsPass {
    const WORKGROUP: u32 = 8;

    pub fn new(device: &wgpu::Device, atlas: &HeightAtlas) -> Self {
        let module = DERIVE_HEIGHTS.module(device);
        let [h0, h1, h2] = [0, 1, 2].map(|mip| atlas.height_mip(mip));
        let [s0, s1, s2] = [0, 1, 2].map(|mip| atlas.slope_mip(mip));
        let step = |name, halvings, views: &[(u32, &wgpu::TextureView)]| {
            Step::new(device, &module, (name, halvings), views)
        };
        Self {
            steps: [
                step("slopes", 0, &[(2, &h0), (3, &s0)]),
                step("halve_heights", 1, &[(0, &h0), (1, &h1)]),
                step("halve_slopes", 1, &[(4, &s0), (3, &s1)]),
                step("halve_heights", 2, &[(0, &h1), (1, &h2)]),
                step("coarsest_slopes", 2, &[(0, &h1), (4, &s1), (3, &s2)]),
            ],
            decode: pipeline(device, &module, "decode", 0),
        }
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

        let size = atlas.grid.slot_size_texels;
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
            pass.dispatch_workgroups(workgroups, workgroups, uploads.len() as u32);
        };
        run(&self.decode, &[&decode_inputs], size);
        for step in &self.steps {
            let jobs = bind(&step.pipeline, std::slice::from_ref(&jobs_entry));
            run(&step.pipeline, &[&jobs, &step.atlas], size >> step.halvings);
        }
        sent
    }
}

impl Step {
    fn new(
        device: &wgpu::Device,
        module: &wgpu::ShaderModule,
        (name, halvings): (&str, u32),
        views: &[(u32, &wgpu::TextureView)],
    ) -> Self {
        let pipeline = pipeline(device, module, name, halvings.saturating_sub(1));
        let entries = views
            .iter()
            .map(|&(binding, view)| entry(binding, wgpu::BindingResource::TextureView(view)))
            .collect::<Vec<_>>();
        let atlas = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("derive heights"),
            layout: &pipeline.get_bind_group_layout(1),
            entries: &entries,
        });
        Self { pipeline, atlas, halvings }
    }
}

fn pipeline(
    device: &wgpu::Device,
    module: &wgpu::ShaderModule,
    name: &str,
    source_mip: u32,
) -> wgpu::ComputePipeline {
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(name),
        layout: None,
        module,
        entry_point: Some(name),
        compilation_options: wgpu::PipelineCompilationOptions {
            constants: &[("SOURCE_MIP", f64::from(source_mip))],
            ..Default::default()
        },
        cache: None,
    })
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
