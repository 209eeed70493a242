//! The page table on the GPU against its twin on the CPU: places, levels, requests and colours point by point, and
//! the pages that all pixels of an image ask for as a set.

use std::collections::BTreeSet;

use glam::{DVec2, IVec2, Vec2, dvec2, vec2};
use wgpu::util::DeviceExt;

use super::gpu;
use super::random_field::Random;
use crate::dataset::{ColourFormat, ColourTile};
use crate::gpu::atlas::AtlasGrid;
use crate::gpu::colour_atlas::ColourAtlas;
use crate::gpu::derive_colours_pass::DeriveColoursPass;
use crate::gpu::page_table::{GatherPagesPass, RequestImage, SamplePagesPass};
use crate::gpu::shader_library::PAGE_PROBE;
use crate::gpu::{GpuContext, PageBindings, PageTableUniforms, read_texture};
use crate::residency::page_table::{
    Footprint, PageEntry, PageId, PageLayout, PageRequest, PageStream, PagesAsked, TexturePlace,
    unite,
};
use crate::srgb::LINEAR_FROM_CODE;

/// Texels of the texture, no whole number of pages.
const SIZE_TEXELS: [u32; 2] = [1_900, 1_150];
const TILE: u32 = 48;
const GUTTER: u32 = 4;
const ATLAS_COLUMNS: u32 = 16;
const MOST_TAPS: u32 = 8;

fn layout() -> PageLayout {
    PageLayout::of_texture(SIZE_TEXELS, (TILE, GUTTER), 1).unwrap()
}

/// The texture's content at a texel of a level, three channels of noise that neighbouring pages agree on.
fn texel_bytes(level: u8, texel: IVec2) -> [u8; 3] {
    let key = (u64::from(level) << 56) ^ ((texel.y as u64) << 28) ^ (texel.x as u64 & 0xfff_ffff);
    let hash = Random(key).next();
    [0, 8, 16].map(|shift| (hash >> shift) as u8)
}

fn page_content(page: PageId) -> ColourTile {
    let stored = TILE + 2 * GUTTER;
    let corner = IVec2::new(page.column as i32, page.row as i32) * TILE as i32;
    let texel = |index: u32| {
        let place = IVec2::new((index % stored) as i32, (index / stored) as i32);
        let [red, green, blue] = texel_bytes(page.level, corner + place - GUTTER as i32);
        [red, green, blue, 255]
    };
    ColourTile {
        id: layout().tile_of(page),
        stored_size_texels: stored,
        format: ColourFormat::Rgba8,
        data: (0..stored * stored).flat_map(texel).collect(),
    }
}

/// Linear light of a texel of a page's mip: the mean of what lies under it.
fn mip_texel(level: u8, mip: i32, texel: IVec2) -> [f64; 3] {
    let side = 1 << mip;
    let mut sum = [0.0; 3];
    for index in 0..side * side {
        let fine = texel * side + IVec2::new(index % side, index / side);
        for (sum, byte) in sum.iter_mut().zip(texel_bytes(level, fine)) {
            *sum += f64::from(LINEAR_FROM_CODE[usize::from(byte)]) / f64::from(side * side);
        }
    }
    sum
}

fn mix(a: [f64; 3], b: [f64; 3], part: f64) -> [f64; 3] {
    [0, 1, 2].map(|i| a[i] + (b[i] - a[i]) * part)
}

/// Bilinear light of a level's mip at a place in texels of level 0.
fn bilinear(level: u8, mip: i32, place: DVec2) -> [f64; 3] {
    let at = place / f64::from(1_i32 << (i32::from(level) + mip)) - 0.5;
    let low = at.floor();
    let part = at - low;
    let texel = |right, down| mip_texel(level, mip, low.as_ivec2() + IVec2::new(right, down));
    let north = mix(texel(0, 0), texel(1, 0), part.x);
    let south = mix(texel(0, 1), texel(1, 1), part.x);
    mix(north, south, part.y)
}

/// Trilinear light of a page of `level` at a place, filtered to `wanted`.
fn trilinear(level: u8, wanted: f32, place: DVec2) -> [f64; 3] {
    let mip = f64::from((wanted - f32::from(level)).clamp(0.0, 2.0));
    let fine = bilinear(level, mip.floor() as i32, place);
    mix(fine, bilinear(level, mip.ceil() as i32, place), mip.fract())
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
    fn new(gpu: GpuContext, bias: f32, is_settled: bool) -> Self {
        let layout = layout();
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
        let grid = AtlasGrid { columns: ATLAS_COLUMNS, rows, slot_size_texels: TILE + 2 * GUTTER };
        let atlas = ColourAtlas::new(&gpu.device, grid, ColourFormat::Rgba8);
        let derive = DeriveColoursPass::new(&gpu.device, &atlas);
        let mut stream = PageStream::new(layout.clone(), grid.columns * grid.rows, 1_000);
        stream.request(&wanted);
        for page in stream.to_load().to_vec() {
            stream.loaded(page, page_content(page));
        }
        let uploads = stream.upload(u64::MAX, |_| 1);
        let mut pages = PageBindings::new(&gpu.device, &layout, &atlas);
        for upload in &uploads {
            atlas.upload(&gpu.queue, upload.slot, stream.payload(upload.page).unwrap());
        }
        while is_settled && stream.is_fading() {
            stream.advance_fades();
        }
        pages.set_entries(&gpu.queue, &stream.take_changed());
        pages.set_uniforms(&gpu.queue, &PageTableUniforms::new(&layout, &grid, [bias, bias]));
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let slots = uploads.iter().map(|upload| upload.slot).collect::<Vec<_>>();
        derive.record(&mut encoder, &atlas, &slots);
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
    /// The mean of all taps of a footprint, each from the page that the tables on the CPU name, in f64.
    fn filtered(&self, point: &PageProbePoint, answer: &PageProbeAnswer, bias: f32) -> [f64; 3] {
        let is_x = point.span_x.length_squared() > point.span_y.length_squared();
        let axis = if is_x { point.span_x } else { point.span_y }.as_dvec2();
        let taps = answer.taps as u32;
        let wanted = (answer.level + bias).floor().max(0.0) as u8;
        let coarsest = self.layout.coarsest_level;
        let mut sum = [0.0; 3];
        for tap in 0..taps {
            let along = (f64::from(tap) + 0.5) / f64::from(taps) - 0.5;
            let offset = Vec2::from(answer.part).as_dvec2() + axis * along;
            let place = TexturePlace::from_offset(answer.texel.into(), offset);
            let mut pages =
                (wanted.min(coarsest)..=coarsest).map(|level| place.page(&self.layout, level));
            let page = pages.find(|page| matches!(self.stream.on_gpu(*page), PageEntry::At(_)));
            let texel = place.texel.as_dvec2() + place.part.as_dvec2();
            let colour = trilinear(page.unwrap().level, answer.level + bias.max(0.0), texel);
            sum = [0, 1, 2].map(|i| sum[i] + colour[i] / f64::from(taps));
        }
        sum
    }
}

/// Waits for a buffer's first bytes.
fn read_buffer(gpu: &GpuContext, buffer: &wgpu::Buffer, bytes: u64) -> Vec<u8> {
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

fn mapped(gpu: &GpuContext, buffer: &wgpu::Buffer) -> Vec<u8> {
    buffer.slice(..).map_async(wgpu::MapMode::Read, |_| ());
    gpu.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    gpu.check().unwrap();
    buffer.slice(..).get_mapped_range().unwrap().to_vec()
}

/// Points all over the texture and on its edges, with footprints of all sizes and shapes.
fn points() -> Vec<PageProbePoint> {
    let mut random = Random(17);
    let mut coordinate = || match random.next() % 12 {
        0 => 0.0,
        1 => 1.0,
        _ => random.unit() as f32,
    };
    let places = (0..4_000).map(|_| vec2(coordinate(), coordinate())).collect::<Vec<_>>();
    let mut span = || {
        let length = (9.0 * random.unit() - 3.0).exp2();
        let angle = std::f64::consts::TAU * random.unit();
        (DVec2::from_angle(angle) * length).as_vec2()
    };
    let point = |st| PageProbePoint { st, span_x: span(), span_y: span(), padding: Vec2::ZERO };
    places.into_iter().map(point).collect()
}

/// Whether a value within rounding of this one may fall into another step of a level.
fn is_between_steps(level: f32) -> bool {
    let steps = level * PageRequest::STEPS as f32;
    (steps - steps.round()).abs() < 1.0e-3
}

#[test]
fn places_levels_and_requests_are_the_same_on_both() {
    let Some(gpu) = gpu() else { return };
    let bias = 0.3;
    let stage = Stage::new(gpu, bias, true);
    let layout = &stage.layout;
    let points = points();
    let mut uncertain = 0;
    for (point, answer) in points.iter().zip(stage.probe(&points)) {
        let exact = point.st.as_dvec2() * dvec2(1_900.0, 1_150.0);
        let texel = Vec2::from(answer.part) + IVec2::from(answer.texel).as_vec2();
        assert!((texel.as_dvec2() - exact).length() < 1.0e-3, "{answer:?}");
        let place = TexturePlace { texel: answer.texel.into(), part: answer.part.into() };
        let footprint = Footprint::new(point.span_x, point.span_y, MOST_TAPS);
        let ratio = {
            let squares = [point.span_x, point.span_y].map(|span| span.length_squared());
            (squares[0].max(squares[1]) / squares[0].min(squares[1]).max(1.0)).sqrt()
        };
        // Where the sides' ratio is all but whole, either number of taps is right.
        if (ratio - ratio.round()).abs() < 1.0e-4 || is_between_steps(footprint.level + bias) {
            uncertain += 1;
            continue;
        }
        assert_eq!(answer.taps, footprint.taps, "{answer:?}");
        assert!((answer.level - footprint.level).abs() < 1.0e-4, "{answer:?} {footprint:?}");
        let request = footprint.request(layout, place, bias).unwrap_or(PageRequest::NONE);
        assert_eq!(answer.request, request);
        let wanted = (footprint.level + bias).floor().clamp(0.0, f32::from(layout.coarsest_level));
        let mut pages =
            (wanted as u8..=layout.coarsest_level).map(|level| place.page(layout, level));
        let there = |page: &PageId| matches!(stage.stream.on_gpu(*page), PageEntry::At(_));
        let page = pages.find(there).unwrap();
        assert_eq!(answer.found_level, u32::from(page.level), "the finest that is there");
        let word = answer.found_word;
        let slot = PageEntry::At((word & 0xff) + ATLAS_COLUMNS * (word >> 8 & 0xff));
        assert_eq!(stage.stream.on_gpu(page), slot, "{page:?}");
        let within = place.in_page(layout, page);
        assert!((Vec2::from(answer.in_page) - within).length() < 1.0e-3, "{answer:?}");
    }
    println!("{uncertain} of {} points within rounding of two answers", points.len());
    assert!(uncertain < points.len() / 20);
}

/// The noise is white, so that a texel beside the right one is another colour altogether.
#[test]
fn colours_are_those_of_an_f64_evaluation_of_the_same_filter() {
    let Some(gpu) = gpu() else { return };
    let bias = 0.3;
    let stage = Stage::new(gpu, bias, true);
    let points = points();
    let (mut compared, mut across, mut anisotropic) = (0, 0, 0);
    for (point, answer) in points.iter().zip(stage.probe(&points)) {
        let size = dvec2(1_900.0, 1_150.0);
        let place = point.st.as_dvec2() * size;
        let to_edge = place.min(size - place).min_element();
        let reach = point.span_x.length().max(point.span_y.length());
        // At the edges the outermost texels go on.
        if to_edge < f64::from(reach) + 3.0 * f64::from(answer.found_level).exp2() {
            continue;
        }
        let expected = stage.filtered(point, &answer, bias);
        let worst = (0..3).map(|i| (f64::from(answer.colour[i]) - expected[i]).abs());
        let worst = worst.fold(0.0, f64::max);
        assert!(worst < 0.02, "{worst}: {answer:?}, expected {expected:?}");
        compared += 1;
        anisotropic += usize::from(answer.taps > 1.0);
        let within = Vec2::from(answer.in_page).min(TILE as f32 - Vec2::from(answer.in_page));
        across += usize::from(within.min_element() < 1.0);
    }
    println!("{compared} colours, {anisotropic} of several taps, {across} beside a page's border");
    assert!(anisotropic > 500 && compared > anisotropic + 200 && across > 50);
}

#[test]
fn at_the_far_edges_the_outermost_texels_show() {
    let Some(gpu) = gpu() else { return };
    let stage = Stage::new(gpu, 0.0, true);
    let still = vec2(0.0, 0.0);
    let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)];
    let point = |&(s, t): &(f32, f32)| PageProbePoint {
        st: vec2(s, t),
        span_x: still,
        span_y: still,
        padding: still,
    };
    let points = corners.iter().map(point).collect::<Vec<_>>();
    for ((s, t), answer) in corners.iter().zip(stage.probe(&points)) {
        let level = answer.found_level as u8;
        let texels = SIZE_TEXELS.map(|size| f64::from(size) / f64::from(level).exp2());
        let edge = |far: f32, texels: f64| if far > 0.0 { texels - 0.5 } else { 0.5 };
        let place = dvec2(edge(*s, texels[0]), edge(*t, texels[1])) * f64::from(level).exp2();
        let expected = bilinear(level, 0, place);
        let worst = (0..3).map(|i| (f64::from(answer.colour[i]) - expected[i]).abs());
        assert!(worst.fold(0.0, f64::max) < 0.02, "{answer:?}, expected {expected:?}");
    }
}

#[test]
fn a_page_that_fades_in_shows_a_part_of_itself_over_what_was_there() {
    let Some(gpu) = gpu() else { return };
    let stage = Stage::new(gpu, 0.0, false);
    let points = points();
    let mut compared = 0;
    for (point, answer) in points.iter().zip(stage.probe(&points)) {
        let place = point.st.as_dvec2() * dvec2(1_900.0, 1_150.0);
        let found_level = answer.found_level as u8;
        let coarsest = stage.layout.coarsest_level;
        let to_edge = place.min(dvec2(1_900.0, 1_150.0) - place).min_element();
        if answer.taps > 1.0 || found_level + 1 >= coarsest || to_edge < 200.0 {
            continue;
        }
        let on_gpu = TexturePlace { texel: answer.texel.into(), part: answer.part.into() };
        let mut coarser =
            (found_level + 1..=coarsest).map(|level| on_gpu.page(&stage.layout, level));
        let there = |page: &PageId| matches!(stage.stream.on_gpu(*page), PageEntry::At(_));
        let below = trilinear(coarser.find(there).unwrap().level, answer.level, place);
        let expected = mix(below, trilinear(found_level, answer.level, place), 0.25);
        let worst = (0..3).map(|i| (f64::from(answer.colour[i]) - expected[i]).abs());
        assert!(worst.fold(0.0, f64::max) < 0.02, "{answer:?}, expected {expected:?}");
        compared += 1;
    }
    assert!(compared > 50, "{compared}");
}

const IMAGE_PX: [u32; 2] = [203, 117];

/// The pixels of a plane seen at a slant, with sky above: places, and the exact sides of their footprints.
fn slanted_plane() -> Vec<Option<PageProbePoint>> {
    let place = |x: f64, y: f64| {
        let below = (y - 20.0) / 97.0;
        let distance = 0.05 / below;
        dvec2(0.45 + (x - 101.0) / 203.0 * distance * 3.0, 1.02 - 1.7 * distance)
    };
    let size = dvec2(1_900.0, 1_150.0);
    let pixel = |index: u32| {
        let (x, y) = (f64::from(index % IMAGE_PX[0]) + 0.5, f64::from(index / IMAGE_PX[0]) + 0.5);
        let st = place(x, y);
        let inside = y > 20.5 && st.cmpge(DVec2::ZERO).all() && st.cmple(DVec2::ONE).all();
        inside.then(|| PageProbePoint {
            st: st.as_vec2(),
            span_x: ((place(x + 1.0, y) - st) * size).as_vec2(),
            span_y: ((place(x, y + 1.0) - st) * size).as_vec2(),
            padding: Vec2::ZERO,
        })
    };
    (0..IMAGE_PX[0] * IMAGE_PX[1]).map(pixel).collect()
}

/// The request image of the plane, its requests made by the GPU.
fn request_image(stage: &Stage, pixels: &[Option<PageProbePoint>]) -> RequestImage {
    let seen = pixels.iter().flatten().copied().collect::<Vec<_>>();
    let mut requests = stage.probe(&seen).into_iter().map(|answer| answer.request);
    let texels =
        pixels.iter().map(|pixel| pixel.map_or(PageRequest::NONE, |_| requests.next().unwrap()));
    let texels = texels.collect::<Vec<_>>();
    let image = RequestImage::new(&stage.gpu.device, IMAGE_PX);
    let layout = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(IMAGE_PX[0] * RequestImage::TEXEL_BYTES),
        rows_per_image: None,
    };
    let (target, size) = (image.texture.as_image_copy(), image.texture.size());
    stage.gpu.queue.write_texture(target, bytemuck::cast_slice(&texels), layout, size);
    image
}

/// What the CPU works out from places and footprints alone: what is asked for for certain, and what may be, where a
/// value lies within rounding of the next step.
fn by_brute_force(
    layout: &PageLayout,
    pixels: &[Option<PageProbePoint>],
) -> [BTreeSet<(PageId, u32)>; 2] {
    let (mut certain, mut possible) = (BTreeSet::new(), BTreeSet::new());
    for point in pixels.iter().flatten() {
        let place = TexturePlace::from_coordinates(layout, point.st.as_dvec2());
        let nudged = [-2.0e-4, 0.0, 2.0e-4].map(|nudge| {
            let footprint = Footprint::new(point.span_x, point.span_y, MOST_TAPS);
            footprint.request(layout, place, nudge)
        });
        let asked = nudged
            .map(|request| request.map(|request| (request.page(layout).unwrap(), request.steps())));
        possible.extend(asked.iter().flatten());
        if asked[0] == asked[2] {
            certain.extend(asked[1]);
        }
    }
    [certain, possible]
}

fn single_steps(asked: &PagesAsked) -> BTreeSet<(PageId, u32)> {
    let steps = |(&page, &steps): (&PageId, &u32)| {
        let bits = (0..PageRequest::STEP_BITS).map(|bit| 1 << bit);
        bits.filter(move |bit| steps & bit != 0).map(move |bit| (page, bit))
    };
    asked.iter().flat_map(steps).collect()
}

#[test]
fn the_list_the_whole_image_and_brute_force_give_the_same_pages() {
    let Some(gpu) = gpu() else { return };
    let stage = Stage::new(gpu, 0.0, true);
    let pixels = slanted_plane();
    let image = request_image(&stage, &pixels);

    let gather = GatherPagesPass::new(&stage.gpu.device, &stage.layout, &stage.pages);
    let bytes = GatherPagesPass::list_bytes(GatherPagesPass::MOST_LISTED);
    let back = stage.gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: bytes,
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder = stage.gpu.device.create_command_encoder(&Default::default());
    // Twice: the second time finds nothing of the first.
    for _ in 0..2 {
        gather.record(&stage.gpu.device, &mut encoder, &image, &stage.pages);
    }
    assert_eq!(gather.copy_list(&mut encoder, &back, u32::MAX), bytes);
    stage.gpu.queue.submit([encoder.finish()]);
    let words = bytemuck::pod_collect_to_vec::<u8, u32>(&mapped(&stage.gpu, &back));
    let listed = bytemuck::cast_slice::<u32, PageRequest>(&words[2..2 + 2 * words[0] as usize]);
    let by_list = unite(&stage.layout, listed.iter().copied());
    assert_eq!(by_list.len(), listed.len(), "each page once");

    let texels = read_texture(&stage.gpu, &image.texture, IMAGE_PX, RequestImage::TEXEL_BYTES);
    let texels = bytemuck::pod_collect_to_vec::<u8, PageRequest>(&texels.unwrap());
    let by_image = unite(&stage.layout, texels);
    assert_eq!(by_list, by_image);

    let [certain, possible] = by_brute_force(&stage.layout, &pixels);
    let asked = single_steps(&by_image);
    println!(
        "{} pages, {} with their steps, of which rounding decides {}",
        by_list.len(),
        asked.len(),
        possible.difference(&certain).count()
    );
    assert!(by_list.len() > 60, "{}", by_list.len());
    assert!(certain.is_subset(&asked), "{:?}", certain.difference(&asked));
    assert!(asked.is_subset(&possible), "{:?}", asked.difference(&possible));
}

#[test]
fn one_pixel_of_each_block_sees_a_part_and_all_of_them_in_turn_everything() {
    let Some(gpu) = gpu() else { return };
    let stage = Stage::new(gpu, 0.0, true);
    let image = request_image(&stage, &slanted_plane());
    let texels = read_texture(&stage.gpu, &image.texture, IMAGE_PX, RequestImage::TEXEL_BYTES);
    let texels = bytemuck::pod_collect_to_vec::<u8, PageRequest>(&texels.unwrap());
    let all = single_steps(&unite(&stage.layout, texels));
    let device = &stage.gpu.device;
    let sample = SamplePagesPass::new(device, IMAGE_PX);
    let (mut seen, mut counts) = (BTreeSet::new(), Vec::new());
    for frame in 0..u64::from(SamplePagesPass::PERIOD) {
        let back = device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: sample.bytes(),
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder = device.create_command_encoder(&Default::default());
        sample.record((device, &stage.gpu.queue), &mut encoder, &image, frame, &back);
        stage.gpu.queue.submit([encoder.finish()]);
        let samples = bytemuck::pod_collect_to_vec::<u8, PageRequest>(&mapped(&stage.gpu, &back));
        let part = single_steps(&unite(&stage.layout, samples));
        assert!(part.is_subset(&all), "frame {frame}");
        counts.push(part.len());
        seen.extend(part);
    }
    println!(
        "of {} a frame sees {} to {}",
        all.len(),
        counts.iter().min().unwrap(),
        counts.iter().max().unwrap()
    );
    assert!(counts.iter().all(|count| *count < all.len()));
    assert_eq!(seen, all);
}
