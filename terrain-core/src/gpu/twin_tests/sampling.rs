use std::collections::HashMap;

use bytemuck::{Pod, Zeroable};
use glam::{DVec2, dvec2};
use wgpu::util::DeviceExt;

use super::gpu;
use super::random_field::{BASE_STEPS, Random, STEP_M, field_steps, field_tile};
use crate::CameraView;
use crate::dataset::{ColourFormat, HeightRange, HeightRanges, Shape};
use crate::frame_setup::frame_uniforms;
use crate::gpu::shader_library::LOOKUP_PROBE;
use crate::gpu::{FrameBindings, GpuContext, TerrainCache};
use crate::renderer_settings::RendererSettings;
use crate::residency::{OffsetTable, Placement};
use crate::selection::{LayerTree, TileTree};
use crate::tiling::{Extent, FixedPosition, LayerLayout, TileId, TileSet, TilingScheme};

pub const LAYOUT: LayerLayout =
    LayerLayout { tile_size_texels: 32, gutter_texels: 4, level_count: 9 };
/// Slots of the cache along either side.
pub const COLUMNS: u32 = 8;

/// A cache holding tiles of the random field: the root, and paths to random places.
pub struct Scene {
    pub tree: TileTree,
    pub residents: Vec<(TileId, u32)>,
    pub table: OffsetTable,
    pub eye: DVec2,
}

impl Scene {
    pub fn new(origin: DVec2) -> Self {
        Self::of_root(TilingScheme { origin, root_size_m: 60_000.0 })
    }

    pub fn of_root(scheme: TilingScheme) -> Self {
        let range = HeightRange { min_m: -250.0, max_m: 800.0 };
        let mut random = Random(7);
        let mut tiles: TileSet = [TileId::ROOT].into_iter().collect();
        while tiles.len() < u64::from(COLUMNS * COLUMNS) {
            let level = (random.next() % 9) as u8;
            let side = 1u64 << level;
            // A quarter of them close together, so that tiles lie beside and within one another.
            let near = if random.next().is_multiple_of(4) { side.min(3) } else { side };
            let tile =
                TileId::new(level, (random.next() % near) as u32, (random.next() % near) as u32);
            tiles.insert(tile);
        }
        let residents = tiles.iter().zip(0..).collect::<Vec<_>>();
        let tree = TileTree {
            scheme,
            data_extent: scheme.root_extent(),
            shape: Shape::Plane,
            heights: LayerTree { layout: LAYOUT, present: tiles },
            colours: None,
            height_ranges: HeightRanges { levels: vec![vec![Some(range)]] },
        };
        let table = OffsetTable::build(residents.iter().copied());
        Self { tree, table, residents, eye: scheme.root_extent().centre() }
    }

    /// Uploads every resident; every third tile as float32.
    pub fn cache(&self, gpu: &GpuContext) -> TerrainCache {
        let cache = TerrainCache::new(gpu, &self.tree, ColourFormat::Rgba8, (COLUMNS, COLUMNS));
        let uploads = self
            .residents
            .iter()
            .map(|&(tile, slot)| {
                let placement = Placement { tile, slot, evicted: None };
                (placement, field_tile(LAYOUT, tile, slot % 3 == 0))
            })
            .collect::<Vec<_>>();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let sent = cache.upload_heights(gpu, &mut encoder, &self.tree, &uploads);
        gpu.queue.submit([encoder.finish()]);
        let payload: u64 = uploads.iter().map(|(_, tile)| tile.samples.byte_len()).sum();
        assert_eq!(sent, payload + 32 * uploads.len() as u64, "samples and a job a tile");
        cache
    }

    /// Height of the field at a point given from the eye, filtered to a spacing as the shaders do, in
    /// f64. `None` outside the root.
    pub fn filtered_height_m(&self, tile: TileId, offset_m: DVec2, spacing_m: f32) -> Option<f64> {
        let world = self.view().eye.truncate() + offset_m;
        self.tree.scheme.root_extent().contains(world).then(|| {
            let texel_m = LAYOUT.texel_size_m(&self.tree.scheme, tile.level);
            let corner = self.tree.scheme.tile_origin(tile);
            let place = dvec2(world.x - corner.x, corner.y - world.y) / texel_m;
            let global = place + dvec2(f64::from(tile.column), f64::from(tile.row)) * 32.0;
            let mip = (f64::from(spacing_m) / texel_m).log2().clamp(0.0, 2.0);
            let (fine, part) = (mip.floor(), mip - mip.floor());
            let near = bilinear_m(tile.level, fine as u32, global);
            let far = bilinear_m(tile.level, (fine as u32 + 1).min(2), global);
            near + (far - near) * part
        })
    }

    /// What f32 may cost a height: a place is known to an f32's part of the distance from the eye, and
    /// the field's neighbouring texels differ by up to 1024 m.
    pub fn tolerance_m(&self, tile: TileId, offset_m: DVec2) -> f64 {
        let texel_m = LAYOUT.texel_size_m(&self.tree.scheme, tile.level);
        1024.0 * 2.0 * (3.0e-7 * offset_m.length() / texel_m + 4.0e-6) + 1.0e-3
    }

    pub fn view(&self) -> CameraView {
        CameraView {
            eye: self.eye.extend(1234.567),
            heading_deg: 0.0,
            pitch_deg: -30.0,
            fov_y_deg: 60.0,
            viewport_px: [640, 360],
        }
    }
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct ProbePoint {
    east_m: f32,
    north_m: f32,
    spacing_m: f32,
    padding: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct ProbeAnswer {
    fixed: [i32; 2],
    linear: u32,
    descended: u32,
    height_m: f32,
    weight: f32,
    place: [f32; 2],
    cell: u32,
}

/// Runs the probe shader over the points.
fn probe(gpu: &GpuContext, scene: &Scene, points: &[ProbePoint]) -> Vec<ProbeAnswer> {
    let mut cache = scene.cache(gpu);
    let view = scene.view();
    let eye = view.eye.truncate();
    let tables = cache.update_tables(gpu, &scene.tree, eye, &scene.table, None);
    let mut bindings =
        FrameBindings::new(&gpu.device, &cache.table, &cache.heights, &cache.colours);
    let mut uniforms = frame_uniforms(&view, &scene.tree, &RendererSettings::default(), 1.0);
    uniforms.height_table = tables.ranges[0];
    bindings.frame.set_uniforms(&gpu.queue, &uniforms);

    let device = &gpu.device;
    let buffer = |contents: &[u8], usage| {
        device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: None,
            contents,
            usage,
        })
    };
    use wgpu::BufferUsages as Usage;
    let input = buffer(bytemuck::cast_slice(points), Usage::STORAGE);
    let zeroed = vec![0u8; points.len() * size_of::<ProbeAnswer>()];
    let output = buffer(&zeroed, Usage::STORAGE | Usage::COPY_SRC);
    let readback = buffer(&zeroed, Usage::MAP_READ | Usage::COPY_DST);
    let group_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: None,
        entries: &[0, 1].map(|binding| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Storage { read_only: binding == 0 },
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        }),
    });
    let layouts = [&bindings.frame.layout, &bindings.terrain_layout, &group_layout].map(Some);
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: &layouts,
        immediate_size: 0,
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: Some(&layout),
        module: &LOOKUP_PROBE.module(device),
        entry_point: Some("probe"),
        compilation_options: Default::default(),
        cache: None,
    });
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &group_layout,
        entries: &[
            wgpu::BindGroupEntry { binding: 0, resource: input.as_entire_binding() },
            wgpu::BindGroupEntry { binding: 1, resource: output.as_entire_binding() },
        ],
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_compute_pass(&Default::default());
    pass.set_pipeline(&pipeline);
    for (index, group) in (0..).zip([&bindings.frame.group, &bindings.terrain, &group]) {
        pass.set_bind_group(index, group, &[]);
    }
    pass.dispatch_workgroups((points.len() as u32).div_ceil(64), 1, 1);
    drop(pass);
    encoder.copy_buffer_to_buffer(&output, 0, &readback, 0, readback.size());
    gpu.queue.submit([encoder.finish()]);
    readback.slice(..).map_async(wgpu::MapMode::Read, |_| ());
    device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    gpu.check().unwrap();
    let view = readback.slice(..).get_mapped_range().unwrap();
    bytemuck::pod_collect_to_vec::<u8, ProbeAnswer>(&view)
}

/// Points all over the root and beyond it, and points on and beside the borders of its tiles.
fn points(scene: &Scene) -> Vec<ProbePoint> {
    let mut random = Random(11);
    let eye = scene.view().eye.truncate();
    let extent = scene.tree.scheme.root_extent().grown(2_000.0);
    let mut points = Vec::new();
    for index in 0..6_000 {
        let mut place = extent.min + extent.size_m() * dvec2(random.unit(), random.unit());
        if index % 3 == 0 {
            let (tile, _) = scene.residents[(random.next() as usize) % scene.residents.len()];
            let border = scene.tree.scheme.tile_extent(tile);
            place = border.min + border.size_m() * dvec2(random.unit(), random.unit());
            place.x = if index % 2 == 0 { border.min.x } else { border.max.x };
        }
        let offset = (place - eye).as_vec2();
        let spacing_m = (10.0 * random.unit()).exp2() as f32;
        points.push(ProbePoint { east_m: offset.x, north_m: offset.y, spacing_m, padding: 0 });
    }
    points
}

fn anchor_and_units(scene: &Scene) -> (FixedPosition, f32) {
    let uniforms = frame_uniforms(&scene.view(), &scene.tree, &RendererSettings::default(), 1.0);
    let [x, y] = uniforms.anchor_fixed.to_array();
    assert!(uniforms.anchor_from_eye_m.length() < 1.0e-4, "the eye is over the root");
    (FixedPosition { x, y }, uniforms.units_per_m)
}

#[test]
fn the_lookup_gives_the_same_tile_on_both_bit_for_bit() {
    let Some(gpu) = gpu() else { return };
    let scene = Scene::new(dvec2(500_000.0, 6_800_000.0));
    let points = points(&scene);
    let (anchor, units_per_m) = anchor_and_units(&scene);
    let from_eye = frame_uniforms(&scene.view(), &scene.tree, &RendererSettings::default(), 1.0)
        .anchor_from_eye_m;
    for (point, answer) in points.iter().zip(probe(&gpu, &scene, &points)) {
        let offset_m = [point.east_m - from_eye.x, point.north_m - from_eye.y];
        let position = FixedPosition::from_offset(anchor, offset_m, units_per_m);
        assert_eq!(answer.fixed, [position.x, position.y], "{point:?}");
        let entry = scene.table.find_linear(position).unwrap();
        assert_eq!(answer.linear as usize, entry, "{point:?}");
        assert_eq!(answer.descended as usize, entry, "{point:?}");
    }
}

/// What lets a triangle whose vertices share a cell take one tile for all of its fragments.
#[test]
fn a_cell_shows_one_tile_and_is_a_square_of_the_quadtree() {
    let Some(gpu) = gpu() else { return };
    let scene = Scene::new(DVec2::ZERO);
    let mut cells: HashMap<u32, Vec<ProbeAnswer>> = HashMap::new();
    for answer in probe(&gpu, &scene, &points(&scene)) {
        cells.entry(answer.cell).or_default().push(answer);
    }
    for (cell, answers) in &cells {
        let spread = |axis: usize| {
            let first = answers[0].fixed[axis];
            answers.iter().fold(0, |bits, answer| bits | (answer.fixed[axis] ^ first))
        };
        // The smallest square of the quadtree that holds the cell's points shows no other tile.
        let differing = (spread(0) | spread(1)) as u32;
        let bits = u32::BITS - differing.leading_zeros();
        let square = |answer: &ProbeAnswer| answer.fixed.map(|place| place >> bits);
        let tile = answers[0].linear;
        assert!(answers.iter().all(|answer| answer.linear == tile), "cell {cell}");
        for (other, strangers) in cells.iter().filter(|(other, _)| *other != cell) {
            let overlaps = |answer: &ProbeAnswer| square(answer) == square(&answers[0]);
            assert!(!strangers.iter().any(overlaps), "cells {cell} and {other} overlap");
        }
    }
    let shared = cells.values().filter(|answers| answers.len() > 1).count();
    assert!(shared > 50, "too few cells hold several points: {shared}");
}

/// Height of the field's tile at a mip, box-filtered in f64, at a whole texel of that mip.
pub fn mip_texel_m(level: u8, mip: u32, row: i64, column: i64) -> f64 {
    let width = 1i64 << mip;
    let mut sum = 0.0;
    for (down, right) in (0..width).flat_map(|down| (0..width).map(move |right| (down, right))) {
        let steps = field_steps(level, row * width + down, column * width + right);
        sum += f64::from(BASE_STEPS + i32::from(steps)) * f64::from(STEP_M);
    }
    sum / (width * width) as f64
}

fn bilinear_m(level: u8, mip: u32, place: DVec2) -> f64 {
    let at = place / f64::from(1u32 << mip) - 0.5;
    let low = at.floor();
    let part = at - low;
    let (row, column) = (low.y as i64, low.x as i64);
    let texel = |down, right| mip_texel_m(level, mip, row + down, column + right);
    let north = texel(0, 0) * (1.0 - part.x) + texel(0, 1) * part.x;
    let south = texel(1, 0) * (1.0 - part.x) + texel(1, 1) * part.x;
    north * (1.0 - part.y) + south * part.y
}

/// The field is white noise of 1024 m between neighbouring texels, so an error of a texel's 1e-5th
/// part moves the height by a centimetre: real terrain is a hundred times smoother.
#[test]
fn heights_are_sampled_as_an_f64_evaluation_of_the_same_filter() {
    let Some(gpu) = gpu() else { return };
    let scene = Scene::new(dvec2(500_000.0, 6_800_000.0));
    let points = points(&scene);
    let view = scene.view();
    let coarse_m = view.eye.z.round();
    let mut worst_m = 0.0_f64;
    for (point, answer) in points.iter().zip(probe(&gpu, &scene, &points)) {
        let offset_m = dvec2(f64::from(point.east_m), f64::from(point.north_m));
        let tile = scene.table.entries[answer.linear as usize].tile;
        let Some(expected_m) = scene.filtered_height_m(tile, offset_m, point.spacing_m) else {
            continue;
        };
        let error_m = (f64::from(answer.height_m) - (expected_m - coarse_m)).abs();
        assert!(error_m < scene.tolerance_m(tile, offset_m), "{tile} {point:?}: {error_m} m");
        worst_m = worst_m.max(error_m);
    }
    assert!(worst_m > 0.0, "nothing was compared");
}

/// Ground drawn from tiles thousands of kilometres wide, as a planet's are until finer ones arrive or
/// where there are none, must not shake under an eye that is close to it.
#[test]
fn ground_close_to_the_eye_is_within_a_millimetre_however_large_its_tile() {
    let Some(gpu) = gpu() else { return };
    let scheme = TilingScheme { origin: dvec2(-2.0e7, 2.0e7), root_size_m: 4.0e7 };
    let mut worst_m = [0.0_f64; 9];
    for level in 0..9 {
        let mut scene = Scene::of_root(scheme);
        scene.eye = dvec2(6_543_210.987_6, -3_210_987.654_3);
        let tile = scheme.tile_at(level, scene.eye).unwrap();
        scene.residents = [TileId::ROOT, tile].into_iter().zip(0..).collect();
        if level == 0 {
            scene.residents.pop();
        }
        scene.table = OffsetTable::build(scene.residents.iter().copied());
        let mut random = Random(5);
        let points = (0..500).map(|_| {
            let mut offset_m = || (1400.0 * (random.unit() - 0.5)) as f32;
            ProbePoint { east_m: offset_m(), north_m: offset_m(), spacing_m: 1.0, padding: 0 }
        });
        let points = points.collect::<Vec<_>>();
        let coarse_m = scene.view().eye.z.round();
        for (point, answer) in points.iter().zip(probe(&gpu, &scene, &points)) {
            let offset_m = dvec2(f64::from(point.east_m), f64::from(point.north_m));
            let expected_m = scene.filtered_height_m(tile, offset_m, point.spacing_m).unwrap();
            let error_m = (f64::from(answer.height_m) - (expected_m - coarse_m)).abs();
            worst_m[usize::from(level)] = worst_m[usize::from(level)].max(error_m);
        }
    }
    println!("worst errors of heights by level, metres: {worst_m:.6?}");
    assert!(worst_m.iter().all(|error_m| *error_m < 1.0e-3), "{worst_m:?}");
}

#[test]
fn an_eye_far_outside_the_root_still_finds_the_tiles() {
    let root = TilingScheme { origin: DVec2::ZERO, root_size_m: 1000.0 };
    let mut scene = Scene::new(DVec2::ZERO);
    scene.tree.scheme = root;
    scene.tree.data_extent = Extent::new(dvec2(0.0, -1000.0), dvec2(1000.0, 0.0));
    let view = CameraView { eye: dvec2(-80_000.0, 20_000.0).extend(5_000.0), ..scene.view() };
    let uniforms = frame_uniforms(&view, &scene.tree, &RendererSettings::default(), 1.0);
    let [x, y] = uniforms.anchor_fixed.to_array();
    let anchor = FixedPosition { x, y };
    let target = dvec2(700.0, -300.0);
    let from_anchor = (target - view.eye.truncate()).as_vec2() - uniforms.anchor_from_eye_m;
    let found = FixedPosition::from_offset(anchor, from_anchor.to_array(), uniforms.units_per_m);
    let exact = root.fixed_from_world(target);
    // A tenth of a metre of the 82 km between: what an f32 tells apart there is 8 mm.
    let near = |a: i32, b: i32| f64::from((a - b).abs()) / f64::from(uniforms.units_per_m) < 0.1;
    assert!(near(found.x, exact.x) && near(found.y, exact.y), "{found:?} {exact:?}");
}
