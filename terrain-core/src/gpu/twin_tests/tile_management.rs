//! The cache kept on the GPU against the rules it follows, and its tables against those built on the CPU.

use glam::{DVec2, dvec2};

use super::random_field::Random;
use super::sampling::LAYOUT;
use super::{gpu, mapped};
use crate::dataset::{ColourFormat, HeightRange, HeightRanges, Shape};
use crate::gpu::frame_bindings::FrameBindings;
use crate::gpu::manage_tiles_pass::{LayerDeliveries, ManageTilesPass, Slot};
use crate::gpu::offset_table_buffer::{TileEntry, TilePlace, ToldFrom};
use crate::gpu::tile_management::TileManagement;
use crate::gpu::tile_presence::presence_buffer;
use crate::gpu::tile_report::TileReport;
use crate::gpu::{FrameUniforms, GpuContext, TableRange, TerrainCache};
use crate::residency::managed_slots::{HeldTile, ManagedFrame, ManagedSlots, SlotState};
use crate::residency::{OffsetTable, TileInSlot};
use crate::selection::{LayerTree, Selection, TileTree};
use crate::tiling::{FixedPosition, LayerLayout, MAX_LEVEL, TileId, TileSet, TilingScheme};

/// Imagery deeper than the heights in places, its tiles three times a power of two texels wide.
const COLOUR_LAYOUT: LayerLayout =
    LayerLayout { tile_size_texels: 48, gutter_texels: 4, level_count: MAX_LEVEL + 1 };

/// Tiles of random places and levels, each with its ancestors but for some that are left out.
fn random_tiles(random: &mut Random, finest_level: u8, count: u64) -> TileSet {
    let mut tiles: TileSet = [TileId::ROOT].into_iter().collect();
    while tiles.len() < count {
        let level = (random.next() % (u64::from(finest_level) + 1)) as u8;
        let side = 1u64 << level;
        let near = if random.next().is_multiple_of(3) { side } else { side.min(5) };
        let mut place = || (random.next() % near) as u32;
        let tile = TileId::new(level, place(), place());
        for level in (0..=tile.level).filter(|level| level % 5 != 3) {
            tiles.insert(tile.ancestor_at(level));
        }
    }
    tiles
}

fn random_tree(random: &mut Random, scheme: TilingScheme) -> TileTree {
    let range = HeightRange { min_m: 0.0, max_m: 1.0 };
    let heights = random_tiles(random, LAYOUT.finest_level(), 400);
    TileTree {
        scheme,
        data_extent: scheme.root_extent(),
        shape: Shape::Plane,
        heights: LayerTree { layout: LAYOUT, present: heights },
        colours: Some(LayerTree {
            layout: COLOUR_LAYOUT,
            present: random_tiles(random, MAX_LEVEL, 700),
        }),
        height_ranges: HeightRanges { levels: vec![vec![Some(range)]] },
    }
}

/// The cache on the GPU and what it is to be told.
struct Bench {
    gpu: GpuContext,
    tree: TileTree,
    cache: TerrainCache,
    bindings: FrameBindings,
    selected: wgpu::Buffer,
    management: TileManagement,
}

/// What there is on the GPU after a frame.
struct Answer {
    report: TileReport,
    slots: Vec<Slot>,
    ranges: [TableRange; 2],
    entries: Vec<TileEntry>,
    nodes: Vec<u32>,
}

impl Bench {
    fn new(gpu: GpuContext, tree: TileTree, slots: (u32, u32)) -> Self {
        let mut cache = TerrainCache::new(&gpu, &tree, ColourFormat::Rgba8, slots);
        let selected = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("selected tiles"),
            size: 4 * (8 + 4 * u64::from(ManageTilesPass::MOST_SLOTS)),
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let inputs = (&selected, &presence_buffer(&gpu.device, &tree));
        let management = TileManagement::new(&gpu.device, &tree, &mut cache, inputs);
        let bindings =
            FrameBindings::new(&gpu.device, &cache.table, &cache.heights, &cache.colours);
        Self { gpu, tree, cache, bindings, selected, management }
    }

    fn slot_count(&self) -> u32 {
        self.cache.heights.grid.columns * self.cache.heights.grid.rows
    }

    /// Random tiles of either layer, level 0 first.
    fn random_selection(&self, random: &mut Random, pool: &[TileId]) -> Selection {
        let most = u64::from(self.slot_count()).min(pool.len() as u64);
        let count = random.next() % most;
        let mut tiles = vec![TileId::ROOT];
        let any = (0..count).map(|_| pool[(random.next() % pool.len() as u64) as usize]);
        for tile in any {
            if !tiles.contains(&tile) {
                tiles.push(tile);
            }
        }
        Selection { tiles, statistics: Default::default() }
    }

    fn frame(
        &mut self,
        selection: &Selection,
        deliveries: &[LayerDeliveries; 2],
        eye: DVec2,
        frame: u32,
    ) -> Answer {
        let GpuContext { device, queue, .. } = &self.gpu;
        let finest = selection.tiles.iter().map(|tile| tile.level).max().unwrap();
        let count = selection.tiles.len() as u32;
        let mut words = vec![count, 0, 0, 0, u32::from(finest), 0, 0, 0];
        for tile in &selection.tiles {
            words.extend([u32::from(tile.level), tile.row, tile.column, 0]);
        }
        queue.write_buffer(&self.selected, 0, bytemuck::cast_slice(&words));
        self.bindings.frame.set_uniforms(queue, &FrameUniforms::default());
        let mut encoder = device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_compute_pass(&Default::default());
        let sent = self.management.manage(queue, &mut pass, frame, deliveries);
        let delivered = deliveries.iter().map(|layer| layer.uploaded.len() + layer.failed.len());
        assert_eq!(sent, 24 + 8 * delivered.sum::<usize>() as u64);
        self.management.place(queue, &mut pass, eye);
        drop(pass);
        self.management.copy_ranges(&mut encoder, &self.bindings.frame);
        let report = readback_buffer(device, ManageTilesPass::REPORT_BYTES);
        let listed = [ManageTilesPass::MOST_ASKED; 2];
        let bytes = self.management.copy_report(&mut encoder, &report, listed);
        assert_eq!(bytes, ManageTilesPass::REPORT_BYTES);
        queue.submit([encoder.finish()]);
        let report = TileReport::from_bytes(&mapped(&self.gpu, &report), listed);
        let uniforms = read::<u32>(&self.gpu, self.bindings.frame.uniforms());
        let ranges = uniforms[uniforms.len() - 8..].chunks(4).map(|words| TableRange {
            first_entry: words[0],
            entry_count: words[1],
            first_node: words[2],
            root_word: words[3],
        });
        Answer {
            report,
            slots: read(&self.gpu, self.management.slots()),
            ranges: ranges.collect::<Vec<_>>().try_into().unwrap(),
            entries: read(&self.gpu, &self.cache.table.entries),
            nodes: read(&self.gpu, &self.cache.table.nodes),
        }
    }
}

fn readback_buffer(device: &wgpu::Device, size: u64) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size,
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    })
}

fn read<T: bytemuck::Pod>(gpu: &GpuContext, buffer: &wgpu::Buffer) -> Vec<T> {
    let copy = readback_buffer(&gpu.device, buffer.size());
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    encoder.copy_buffer_to_buffer(buffer, 0, &copy, 0, buffer.size());
    gpu.queue.submit([encoder.finish()]);
    bytemuck::pod_collect_to_vec(&mapped(gpu, &copy))
}

/// A slot as the shader holds it.
fn slot(held: Option<HeldTile>) -> Slot {
    held.map_or_else(Slot::default, |held| Slot {
        level: u32::from(held.tile.level),
        row: held.tile.row,
        column: held.tile.column,
        state: match held.state {
            SlotState::Reserved => 1,
            SlotState::Failed => 2,
            SlotState::Resident => 3,
        },
        last_wanted: held.last_wanted as u32,
    })
}

impl Answer {
    /// Compares a layer with what the rules give.
    fn check_layer(&self, layer: usize, model: &ManagedSlots, expected: &ManagedFrame) {
        let first = layer * ManageTilesPass::MOST_SLOTS as usize;
        let slots = model.slots.iter().map(|&held| slot(held)).collect::<Vec<_>>();
        assert_eq!(self.slots[first..first + slots.len()], slots, "layer {layer}");
        let report = &self.report.layers[layer];
        let counts = (report.missing as usize, report.resident as usize);
        assert_eq!(counts, (expected.missing, expected.resident), "layer {layer}");
        assert_eq!(report.asked, expected.asked, "layer {layer}");
        assert_eq!(report.listed as usize, expected.asked.len());
    }

    /// Compares a layer's table with the one built on the CPU: entry for entry, and the answers of both
    /// quadtrees at and around the tiles' corners.
    fn check_table(&self, layer: usize, expected: &OffsetTable, random: &mut Random) {
        let range = self.ranges[layer];
        let entries = self.entries_of(layer);
        let tiles = entries.iter().map(entry_tile).collect::<Vec<_>>();
        assert_eq!(tiles, expected.entries.iter().map(|entry| entry.tile).collect::<Vec<_>>());
        let nodes = self.nodes[range.first_node as usize..].to_vec();
        let (entries, root_word) = (expected.entries.clone(), range.root_word);
        let built = OffsetTable { entries, nodes, root_word };
        for _ in 0..200 {
            let tile = tiles[(random.next() as usize) % tiles.len()];
            let shift = 30 - u32::from(tile.level);
            let mut jitter = || (random.next() % 3) as i32 - 1;
            let x = ((tile.column << shift) as i32).saturating_add(jitter());
            let y = ((tile.row << shift) as i32).saturating_add(jitter());
            let near = FixedPosition { x, y };
            let anywhere = FixedPosition::from_root_fraction(random.unit(), random.unit());
            for place in [near, anywhere] {
                assert_eq!(built.find_descend(place), expected.find_descend(place), "{place:?}");
            }
        }
    }

    fn entries_of(&self, layer: usize) -> &[TileEntry] {
        let TableRange { first_entry, entry_count, .. } = self.ranges[layer];
        &self.entries[first_entry as usize..][..entry_count as usize]
    }
}

fn entry_tile(entry: &TileEntry) -> TileId {
    TileId::new(entry.level as u8, entry.row, entry.column)
}

/// Random views and deliveries that come late, in part, for slots that are others' by now, or not at all.
fn fly(slots: (u32, u32), frames: u32, seed: u64) {
    let Some(gpu) = gpu() else { return };
    let mut random = Random(seed);
    let scheme = TilingScheme { origin: dvec2(500_000.0, 6_800_000.0), root_size_m: 60_000.0 };
    let tree = random_tree(&mut random, scheme);
    let mut bench = Bench::new(gpu, tree, slots);
    let layers = [Some(&bench.tree.heights), bench.tree.colours.as_ref()];
    let pool = layers.into_iter().flatten().flat_map(|layer| layer.present.iter());
    let mut pool = pool.collect::<Vec<_>>();
    pool.sort_unstable();
    pool.dedup();
    let mut models = [0, 1].map(|_| ManagedSlots::new(bench.slot_count()));
    let mut asked = [0, 1].map(|_| vec![TileInSlot::new(TileId::ROOT, 0)]);
    let mut selection = Selection { tiles: vec![TileId::ROOT], statistics: Default::default() };
    let mut most_missing = 0;
    for frame in 1..=frames {
        if frame > 1 && random.next().is_multiple_of(3) {
            selection = bench.random_selection(&mut random, &pool);
        }
        let deliveries = [0, 1].map(|layer: usize| deliver(&mut asked[layer], frame, &mut random));
        let eye = scheme.root_extent().centre();
        let answer = bench.frame(&selection, &deliveries, eye, frame);
        assert_eq!(answer.report.selected as usize, selection.tiles.len());
        let tree = &bench.tree;
        let wanted = [selection.height_tiles(tree), selection.colour_tiles(tree)];
        for (layer, wanted) in wanted.iter().enumerate() {
            let LayerDeliveries { uploaded, failed } = &deliveries[layer];
            let model = &mut models[layer];
            let expected = model.frame(wanted, uploaded, failed, u64::from(frame));
            answer.check_layer(layer, model, &expected);
            most_missing = most_missing.max(expected.missing);
            let table = OffsetTable::build(expected.shown.iter().copied());
            answer.check_table(layer, &table, &mut random);
            // What a late list may still say.
            asked[layer].retain(|asked| !uploaded.contains(asked) && !failed.contains(asked));
            asked[layer].extend(expected.asked);
        }
    }
    assert!(most_missing > slots.0 as usize, "too little is ever missing: {most_missing}");
}

/// A part of what has been asked for, one tile a slot; everything in the first frame.
fn deliver(asked: &mut [TileInSlot], frame: u32, random: &mut Random) -> LayerDeliveries {
    let mut deliveries = LayerDeliveries::default();
    let mut taken = Vec::new();
    for &tile in asked.iter() {
        let comes = frame == 1 || random.next().is_multiple_of(3);
        if taken.contains(&tile.slot()) || !comes || taken.len() == 32 {
            continue;
        }
        taken.push(tile.slot());
        let fails = frame > 1 && random.next().is_multiple_of(8);
        if fails { &mut deliveries.failed } else { &mut deliveries.uploaded }.push(tile);
    }
    deliveries
}

#[test]
fn a_small_cache_follows_the_rules_frame_by_frame() {
    fly((3, 3), 120, 1);
}

#[test]
fn a_cache_of_more_slots_than_a_workgroup_has_lanes_follows_the_rules_too() {
    fly((18, 17), 60, 2);
}

/// Entries seen from eyes near and far against the same differences taken in f64.
#[test]
fn tiles_are_placed_to_the_last_bit_of_a_float() {
    let eyes = [dvec2(0.43, 0.29), dvec2(0.5, 0.5), dvec2(0.999_999, 1.0e-7), dvec2(-40.0, 3.0)];
    for (origin, root_size_m) in
        [(dvec2(500_000.0, 6_800_000.0), 60_000.0), (dvec2(-2.0e7, 2.0e7), 4.007_501_668_557_849e7)]
    {
        let Some(gpu) = gpu() else { return };
        let scheme = TilingScheme { origin, root_size_m };
        let mut random = Random(3);
        let mut bench = Bench::new(gpu, random_tree(&mut random, scheme), (12, 12));
        let colours = bench.tree.colours.as_ref().unwrap().present.clone();
        let layers = [bench.tree.heights.present.iter(), colours.iter()];
        let pool = layers.into_iter().flatten().collect::<Vec<_>>();
        let selection = bench.random_selection(&mut random, &pool);
        let mut asked = [0, 1].map(|_| vec![TileInSlot::new(TileId::ROOT, 0)]);
        for frame in 1..12 {
            let eye = eyes[frame as usize % eyes.len()];
            let eye = scheme.origin + dvec2(eye.x, -eye.y) * root_size_m;
            let deliveries = asked.map(|uploaded| LayerDeliveries { uploaded, failed: Vec::new() });
            let answer = bench.frame(&selection, &deliveries, eye, frame);
            bench.check_places(&answer, eye);
            asked = answer.report.layers.map(|layer| layer.asked);
        }
    }
}

impl Bench {
    fn check_places(&self, answer: &Answer, eye: DVec2) {
        let tree = &self.tree;
        let colours = tree.colours.as_ref().unwrap();
        let layers = [
            (tree.heights.layout, self.cache.heights.grid, ToldFrom::NearEye),
            (colours.layout, self.cache.colours.grid, ToldFrom::Corner),
        ];
        for (index, (layout, grid, told_from)) in layers.into_iter().enumerate() {
            for entry in answer.entries_of(index) {
                let tile = entry_tile(entry);
                let held = answer.slots[index * ManageTilesPass::MOST_SLOTS as usize..].iter();
                let is_tile = |slot: &Slot| {
                    [slot.level, slot.row, slot.column] == [entry.level, entry.row, entry.column]
                        && slot.state == 3
                };
                let slot = held.take(self.slot_count() as usize).position(is_tile).unwrap();
                let texel = told_from.texel(&tree.scheme, &layout, tile, eye);
                let corner = grid.slot_origin_texels(slot as u32).map(|c| c + layout.gutter_texels);
                let expected = TilePlace::new(&tree.scheme, &layout, tile, eye, texel, corner);
                assert_eq!(entry.place.atlas_texel, expected.atlas_texel, "{tile} from {eye}");
                assert_eq!(entry.place.texels_per_m, expected.texels_per_m, "{tile}");
                let texel_m = layout.texel_size_m(&tree.scheme, tile.level);
                let from_corner = dvec2(f64::from(texel[0]), -f64::from(texel[1])) * texel_m;
                let exact = tree.scheme.tile_origin(tile) + from_corner - eye;
                for (placed, exact) in entry.place.origin_from_eye_m.iter().zip(exact.to_array()) {
                    // Half a last bit and a little, and a unit of the root.
                    let bound_m = exact.abs() * 2.0_f64.powi(-24) * 1.04
                        + tree.scheme.root_size_m * 2.0_f64.powi(-46)
                        + eye.abs().max_element() * f64::EPSILON;
                    let error_m = (f64::from(*placed) - exact).abs();
                    assert!(error_m <= bound_m, "{tile}: {placed} instead of {exact}");
                }
            }
        }
    }
}
