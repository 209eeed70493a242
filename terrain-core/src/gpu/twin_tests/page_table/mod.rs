//! The page table on the GPU against its twin on the CPU: places, levels, requests and colours point by point, and
//! the pages that all pixels of an image ask for as a set.

mod sets;
mod values;

use glam::{DVec2, IVec2, Vec2};
use wgpu::util::DeviceExt;

use super::mapped;
use super::random_field::Random;
use crate::dataset::{ColourFormat, ColourTile, Shape};
use crate::geodesy::PlateCarree;
use crate::gpu::shader_library::PAGE_PROBE;
use crate::gpu::{GpuContext, PageAtlas, PageBindings, PageTableUniforms};
use crate::residency::page_table::{
    PageEntry, PageId, PageLayout, PageRequest, PageStream, PageUpload, TexturePlace,
};
use crate::srgb::LINEAR_FROM_CODE;

/// Texels of a texture that is no whole number of pages.
const SIZE_TEXELS: [u32; 2] = [1_900, 1_150];
const TILE: u32 = 48;
const GUTTER: u32 = 4;
const ATLAS_COLUMNS: u32 = 16;
const MOST_TAPS: u32 = 8;

fn layout() -> PageLayout {
    PageLayout::of_texture(SIZE_TEXELS, (TILE, GUTTER), 1).unwrap()
}

/// A texture that goes round.
fn globe_layout() -> PageLayout {
    let extent = PlateCarree::extent();
    PageLayout::of_ground(&PlateCarree::scheme(), (&extent, Shape::Globe), 5, (TILE, GUTTER))
}

/// Texels of level 0 that hold data.
fn size_of_data(layout: &PageLayout) -> DVec2 {
    (layout.data_end - layout.data_first).as_dvec2()
}

/// The way between two places in texels, the short way round.
fn between(layout: &PageLayout, a: DVec2, b: DVec2) -> DVec2 {
    let way = a - b;
    match f64::from(layout.round_texels) {
        0.0 => way,
        round => DVec2::new(way.x - round * (way.x / round).round(), way.y),
    }
}

/// The texture's content at a texel of a level, three channels of noise that neighbouring pages agree on.
fn texel_bytes(layout: &PageLayout, level: u8, texel: IVec2) -> [u8; 3] {
    let mut texel = texel;
    if layout.round_texels > 0 {
        texel.x = texel.x.rem_euclid(layout.round_texels >> level);
    }
    let key = (u64::from(level) << 56) ^ ((texel.y as u64) << 28) ^ (texel.x as u64 & 0xfff_ffff);
    let hash = Random(key).next();
    [0, 8, 16].map(|shift| (hash >> shift) as u8)
}

fn page_content(layout: &PageLayout, page: PageId) -> ColourTile {
    let stored = TILE + 2 * GUTTER;
    let corner = IVec2::new(page.column as i32, page.row as i32) * TILE as i32;
    let texel = |index: u32| {
        let place = IVec2::new((index % stored) as i32, (index / stored) as i32);
        let [red, green, blue] = texel_bytes(layout, page.level, corner + place - GUTTER as i32);
        [red, green, blue, 255]
    };
    ColourTile {
        id: layout.tile_of(page),
        stored_size_texels: stored,
        format: ColourFormat::Rgba8,
        data: (0..stored * stored).flat_map(texel).collect(),
    }
}

/// Linear light of a texel of a page's mip: the mean of what lies under it.
fn mip_texel(layout: &PageLayout, level: u8, mip: i32, texel: IVec2) -> [f64; 3] {
    let side = 1 << mip;
    let mut sum = [0.0; 3];
    for index in 0..side * side {
        let fine = texel * side + IVec2::new(index % side, index / side);
        for (sum, byte) in sum.iter_mut().zip(texel_bytes(layout, level, fine)) {
            *sum += f64::from(LINEAR_FROM_CODE[usize::from(byte)]) / f64::from(side * side);
        }
    }
    sum
}

fn mix(a: [f64; 3], b: [f64; 3], part: f64) -> [f64; 3] {
    [0, 1, 2].map(|i| a[i] + (b[i] - a[i]) * part)
}

/// Bilinear light of a level's mip at a place in texels of level 0.
fn bilinear(layout: &PageLayout, level: u8, mip: i32, place: DVec2) -> [f64; 3] {
    let at = place / f64::from(1_i32 << (i32::from(level) + mip)) - 0.5;
    let low = at.floor();
    let part = at - low;
    let texel =
        |right, down| mip_texel(layout, level, mip, low.as_ivec2() + IVec2::new(right, down));
    let north = mix(texel(0, 0), texel(1, 0), part.x);
    let south = mix(texel(0, 1), texel(1, 1), part.x);
    mix(north, south, part.y)
}

/// Trilinear light of a page of `level` at a place, filtered to `wanted`.
fn trilinear(layout: &PageLayout, level: u8, wanted: f32, place: DVec2) -> [f64; 3] {
    let mip = f64::from((wanted - f32::from(level)).clamp(0.0, 2.0));
    let fine = bilinear(layout, level, mip.floor() as i32, place);
    mix(fine, bilinear(layout, level, mip.ceil() as i32, place), mip.fract())
}

struct Stage {
    gpu: GpuContext,
    layout: PageLayout,
    stream: PageStream<ColourTile>,
    pages: PageBindings,
}

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct PageProbePoint {
    pub st: Vec2,
    pub span_x: Vec2,
    pub span_y: Vec2,
    pub padding: Vec2,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct PageProbeAnswer {
    pub colour: [f32; 4],
    pub texel: [i32; 2],
    pub part: [f32; 2],
    pub request: PageRequest,
    pub in_page: [f32; 2],
    pub level: f32,
    pub taps: f32,
    pub found_level: u32,
    pub found_word: u32,
}

impl Stage {
    /// With half of all pages resident, all of them shown as a whole where `is_settled`, and drawn with this bias.
    fn new(gpu: GpuContext, layout: PageLayout, bias: f32, is_settled: bool) -> Self {
        let mut random = Random(3);
        let mut wanted = Vec::new();
        for level in 0..layout.coarsest_level {
            for index in 0..layout.rows_at(level) * layout.columns_at(level) {
                let columns = layout.columns_at(level);
                let page = PageId { level, row: index / columns, column: index % columns };
                if random.unit() < 0.2 {
                    wanted.push(page);
                }
            }
        }
        let rows = (wanted.len() as u32 + 1).div_ceil(ATLAS_COLUMNS);
        let (slots, texels) = ((ATLAS_COLUMNS, rows), TILE + 2 * GUTTER);
        let atlas = PageAtlas::new(&gpu, slots, texels, ColourFormat::Rgba8).unwrap();
        let mut stream = PageStream::new(layout.clone(), ATLAS_COLUMNS * rows, 1_000);
        stream.request(&wanted);
        for page in stream.to_load().to_vec() {
            stream.loaded(page, page_content(&layout, page));
        }
        let uploads = stream.upload(u64::MAX, |_| 1);
        let mut pages = PageBindings::new(&gpu.device, &layout, &atlas);
        while is_settled && stream.is_fading() {
            stream.advance_fades();
        }
        pages.set_entries(&gpu.queue, &stream.take_changed());
        pages
            .set_uniforms(&gpu.queue, &PageTableUniforms::new(&layout, atlas.grid(), [bias, bias]));
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let content = |upload: &PageUpload| (upload.slot, stream.payload(upload.page).unwrap());
        let contents = uploads.iter().map(content).collect::<Vec<_>>();
        atlas.upload(&gpu.queue, &mut encoder, &contents);
        gpu.queue.submit([encoder.finish()]);
        Self { gpu, layout, stream, pages }
    }

    fn probe(&self, points: &[PageProbePoint]) -> Vec<PageProbeAnswer> {
        let device = &self.gpu.device;
        let storage = |read_only| wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only },
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let entries = [(0, storage(true)), (1, storage(false))].map(|(binding, ty)| {
            let visibility = wgpu::ShaderStages::COMPUTE;
            wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None }
        });
        let group_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: None,
            entries: &entries,
        });
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &[Some(&group_layout), None, Some(&self.pages.layout)],
            immediate_size: 0,
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: None,
            layout: Some(&pipeline_layout),
            module: &PAGE_PROBE.module(device),
            entry_point: Some("page_probe"),
            compilation_options: wgpu::PipelineCompilationOptions {
                constants: &[("ANISOTROPY", f64::from(MOST_TAPS))],
                ..Default::default()
            },
            cache: None,
        });
        let input = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: None,
            contents: bytemuck::cast_slice(points),
            usage: wgpu::BufferUsages::STORAGE,
        });
        let output = device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: (points.len() * size_of::<PageProbeAnswer>()) as u64,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        let group =
            crate::gpu::displace_pass::bind_buffers(device, &group_layout, &[&input, &output]);
        let mut encoder = device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.set_bind_group(PageBindings::GROUP, &self.pages.group, &[]);
        pass.dispatch_workgroups((points.len() as u32).div_ceil(64), 1, 1);
        drop(pass);
        self.gpu.queue.submit([encoder.finish()]);
        bytemuck::pod_collect_to_vec(&read_buffer(&self.gpu, &output, output.size()))
    }
}

impl Stage {
    /// The mean of all taps of a footprint, each from the page that the tables on the CPU name, in f64; and the
    /// coarsest level among those pages.
    fn filtered(
        &self,
        point: &PageProbePoint,
        answer: &PageProbeAnswer,
        bias: f32,
    ) -> ([f64; 3], u8) {
        let is_x = point.span_x.length_squared() > point.span_y.length_squared();
        let axis = if is_x { point.span_x } else { point.span_y }.as_dvec2();
        let taps = answer.taps as u32;
        let wanted = (answer.level + bias).floor().max(0.0) as u8;
        let coarsest = self.layout.coarsest_level;
        let (mut sum, mut coarsest_found) = ([0.0; 3], 0);
        for tap in 0..taps {
            let along = (f64::from(tap) + 0.5) / f64::from(taps) - 0.5;
            let offset = Vec2::from(answer.part).as_dvec2() + axis * along;
            let place = TexturePlace::from_offset(&self.layout, answer.texel.into(), offset);
            let mut pages =
                (wanted.min(coarsest)..=coarsest).map(|level| place.page(&self.layout, level));
            let page = pages.find(|page| matches!(self.stream.on_gpu(*page), PageEntry::At(_)));
            let level = page.unwrap().level;
            coarsest_found = level.max(coarsest_found);
            let texel = place.texel.as_dvec2() + place.part.as_dvec2();
            let colour = trilinear(&self.layout, level, answer.level, texel);
            sum = [0, 1, 2].map(|i| sum[i] + colour[i] / f64::from(taps));
        }
        (sum, coarsest_found)
    }
}

/// Waits for a buffer's first bytes.
pub(super) fn read_buffer(gpu: &GpuContext, buffer: &wgpu::Buffer, bytes: u64) -> Vec<u8> {
    let back = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: bytes,
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    encoder.copy_buffer_to_buffer(buffer, 0, &back, 0, bytes);
    gpu.queue.submit([encoder.finish()]);
    mapped(gpu, &back)
}
