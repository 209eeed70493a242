use bytemuck::{Pod, Zeroable};

use super::textures::ClipTextures;
use crate::dataset::{HeightSamples, HeightTile};
use crate::gpu::shader_library::CLIPMAP_HEIGHTS;
use crate::residency::clipmap::{ClipStrip, Piece, TexelRect};

/// The twin of `ClipHeightJob` in `clipmap_heights.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Default, Pod, Zeroable)]
pub(in crate::gpu) struct ClipHeightJob {
    pub target_x: u32,
    pub target_y: u32,
    pub layer: u32,
    pub width: u32,
    pub height: u32,
    pub first_group: u32,
    pub first_word: u32,
    pub form: u32,
    pub base_steps: i32,
    pub step_m: f32,
}

/// The twin of `ClipSlopeJob` in `clipmap_heights.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Default, Pod, Zeroable)]
pub(in crate::gpu) struct ClipSlopeJob {
    pub target_x: u32,
    pub target_y: u32,
    pub layer: u32,
    pub width: u32,
    pub height: u32,
    pub first_group: u32,
    pub known_west: i32,
    pub known_north: i32,
    pub known_east: i32,
    pub known_south: i32,
    pub texel_size_m: f32,
}

/// The forms of samples, as the shader numbers them.
const FORM_STEPS: u32 = 0;
const FORM_FLOAT: u32 = 1;
const FORM_EMPTY: u32 = 2;

/// A strip on its way into a level.
pub(crate) struct ClipHeightUpload<'a> {
    pub strip: ClipStrip,
    /// Its pieces and their tiles; `None` where there is no data.
    pub pieces: Vec<(Piece, Option<&'a HeightTile>)>,
    /// Side of one of its texels in metres.
    pub texel_size_m: f64,
}

/// Writes heights that are sent to where they wrap round to, and derives the slopes from them.
pub(crate) struct ClipHeightsPass {
    decode: wgpu::ComputePipeline,
    slopes: wgpu::ComputePipeline,
}

impl ClipHeightsPass {
    /// Texels of a workgroup.
    const GROUP: u32 = 64;
    /// Most workgroups along an axis of a dispatch.
    const MOST_GROUPS: u32 = 32_768;

    pub fn new(device: &wgpu::Device) -> Self {
        let module = CLIPMAP_HEIGHTS.module(device);
        let pipeline = |entry| {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry),
                layout: None,
                module: &module,
                entry_point: Some(entry),
                compilation_options: Default::default(),
                cache: None,
            })
        };
        Self { decode: pipeline("decode"), slopes: pipeline("slopes") }
    }

    /// Uploads the strips and records the passes that bring them into the textures; returns the bytes
    /// sent.
    pub fn record(
        &self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        textures: &ClipTextures,
        uploads: &[ClipHeightUpload<'_>],
    ) -> u64 {
        if uploads.is_empty() {
            return 0;
        }
        let (jobs, job_groups, payload) = pack(uploads);
        let (slopes, slope_groups) = slope_jobs(uploads, textures.sizes.heights[0]);
        let contents: [(_, &[u8]); 3] = [
            ("clip height jobs", bytemuck::cast_slice(&jobs)),
            ("clip height payload", &payload),
            ("clip slope jobs", bytemuck::cast_slice(&slopes)),
        ];
        let sent = contents.iter().map(|(_, bytes)| bytes.len() as u64).sum();
        let [jobs, payload, slopes] = contents.map(|(label, bytes)| mapped(device, label, bytes));
        let heights = ClipTextures::all_levels(&textures.heights);
        let slopes_out = ClipTextures::all_levels(&textures.slopes);
        use wgpu::BindingResource::TextureView;
        let decode_inputs = bind(
            device,
            &self.decode,
            0,
            [jobs.as_entire_binding(), payload.as_entire_binding(), TextureView(&heights)],
        );
        let slope_inputs = bind(
            device,
            &self.slopes,
            1,
            [slopes.as_entire_binding(), TextureView(&heights), TextureView(&slopes_out)],
        );
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("clip heights"),
            timestamp_writes: None,
        });
        pass.set_pipeline(&self.decode);
        pass.set_bind_group(0, &decode_inputs, &[]);
        dispatch(&mut pass, job_groups);
        pass.set_pipeline(&self.slopes);
        pass.set_bind_group(0, None, &[]);
        pass.set_bind_group(1, &slope_inputs, &[]);
        dispatch(&mut pass, slope_groups);
        sent
    }
}

fn dispatch(pass: &mut wgpu::ComputePass<'_>, groups: u32) {
    let across = groups.clamp(1, ClipHeightsPass::MOST_GROUPS);
    pass.dispatch_workgroups(across, groups.div_ceil(across), 1);
}

fn bind(
    device: &wgpu::Device,
    pipeline: &wgpu::ComputePipeline,
    group: u32,
    resources: [wgpu::BindingResource<'_>; 3],
) -> wgpu::BindGroup {
    let entries = (0..)
        .zip(resources)
        .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
        .collect::<Vec<_>>();
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("clip heights"),
        layout: &pipeline.get_bind_group_layout(group),
        entries: &entries,
    })
}

fn mapped(device: &wgpu::Device, label: &str, contents: &[u8]) -> wgpu::Buffer {
    use wgpu::util::DeviceExt;
    device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some(label),
        // A binding holds at least a word.
        contents: if contents.is_empty() { &[0; 4] } else { contents },
        usage: wgpu::BufferUsages::STORAGE,
    })
}

/// Workgroups that cover a rectangle.
fn groups_of([width, height]: [u32; 2]) -> u32 {
    (width * height).div_ceil(ClipHeightsPass::GROUP)
}

/// The jobs, their workgroups, and the samples of all pieces one after the other, each from a whole u32
/// on.
fn pack(uploads: &[ClipHeightUpload<'_>]) -> (Vec<ClipHeightJob>, u32, Vec<u8>) {
    let (mut jobs, mut payload, mut groups) = (Vec::new(), Vec::new(), 0);
    for upload in uploads {
        for (piece, tile) in &upload.pieces {
            let mut job = ClipHeightJob {
                target_x: piece.target[0],
                target_y: piece.target[1],
                layer: u32::from(upload.strip.level),
                width: piece.size[0],
                height: piece.size[1],
                first_group: groups,
                first_word: (payload.len() / 4) as u32,
                form: FORM_EMPTY,
                ..Default::default()
            };
            if let Some(tile) = tile {
                (job.form, job.base_steps, job.step_m) = append(&mut payload, tile, piece);
            }
            payload.resize(payload.len().next_multiple_of(4), 0);
            groups += groups_of(piece.size);
            jobs.push(job);
        }
    }
    (jobs, groups, payload)
}

/// Appends a piece's samples, row by row; returns their form, base and step.
fn append(payload: &mut Vec<u8>, tile: &HeightTile, piece: &Piece) -> (u32, i32, f32) {
    let stride = tile.stored_size_texels as usize;
    let [x, y] = piece.source.map(|at| at as usize);
    let [width, height] = piece.size.map(|size| size as usize);
    let rows = (y..y + height).map(|row| row * stride + x..row * stride + x + width);
    match &tile.samples {
        HeightSamples::Steps { base_steps, step_m, words } => {
            rows.for_each(|row| payload.extend_from_slice(bytemuck::cast_slice(&words[row])));
            (FORM_STEPS, *base_steps, *step_m)
        }
        HeightSamples::Metres(heights_m) => {
            rows.for_each(|row| payload.extend_from_slice(bytemuck::cast_slice(&heights_m[row])));
            (FORM_FLOAT, 0, 0.0)
        }
    }
}

/// The slopes to derive: of the strips' texels, and of those along them that have a new neighbour.
fn slope_jobs(uploads: &[ClipHeightUpload<'_>], side: u32) -> (Vec<ClipSlopeJob>, u32) {
    let mut groups = 0;
    let jobs = uploads.iter().enumerate().map(|(index, upload)| {
        let ClipStrip { level, rect, .. } = upload.strip;
        // What is known of the level once all strips are there.
        let later = uploads[index..].iter().rfind(|later| later.strip.level == level);
        let known = later.map_or(upload.strip.filled, |later| later.strip.filled);
        let around = TexelRect {
            west: rect.west.saturating_sub(1),
            north: rect.north.saturating_sub(1),
            east: rect.east + 1,
            south: rect.south + 1,
        };
        let rect = around.intersection(&known);
        let from = |at: u32, start: u32| (i64::from(at) - i64::from(start)) as i32;
        let job = ClipSlopeJob {
            target_x: rect.west % side,
            target_y: rect.north % side,
            layer: u32::from(level),
            width: rect.width(),
            height: rect.height(),
            first_group: groups,
            known_west: from(known.west, rect.west),
            known_north: from(known.north, rect.north),
            known_east: from(known.east, rect.west),
            known_south: from(known.south, rect.north),
            texel_size_m: upload.texel_size_m as f32,
        };
        groups += groups_of([rect.width(), rect.height()]);
        job
    });
    (jobs.collect(), groups)
}
