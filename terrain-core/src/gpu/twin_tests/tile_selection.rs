//! The selection on the GPU against the one on the CPU: the same images, trees and views, the same tiles.

use glam::{DVec2, DVec3, dvec2, dvec3};

use super::gpu;
use crate::CameraView;
use crate::gpu::{CoordinatePass, GpuContext, SelectionRequest, TileSelection};
use crate::selection::tests::cases::{SCHEME, height_ranges, layer, mixed, tree};
use crate::selection::{
    CoordinateImage, LayerTree, SeenGround, Selection, SelectionConfig, SelectionStatistics,
    Shortening, TileTree, VisibleRegion, select, visible_region,
};
use crate::tiling::{LayerLayout, TileId, TileSet};

const IMAGE_PX: [u32; 2] = [40, 24];
const MOST_TILES: usize = 70_000;

/// Numbers evenly spread from 0 to 1, the same for the same seed.
struct Dice(u64);

impl Dice {
    fn part(&mut self) -> f64 {
        self.0 += 1;
        (mixed(self.0, TileId::ROOT) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, from: f64, to: f64) -> f64 {
        from + self.part() * (to - from)
    }

    fn of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[(self.part() * choices.len() as f64) as usize]
    }
}

struct OnGpu<'a> {
    gpu: &'a GpuContext,
    image: wgpu::Texture,
    selection: TileSelection,
}

impl<'a> OnGpu<'a> {
    fn new(gpu: &'a GpuContext, tree: &TileTree) -> Self {
        let image = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d {
                width: IMAGE_PX[0],
                height: IMAGE_PX[1],
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: CoordinatePass::REGION_FORMAT,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let selection = TileSelection::new(&gpu.device, tree, &image, MOST_TILES);
        Self { gpu, image, selection }
    }

    /// Sky is what the coordinate pass clears to.
    fn show(&self, image: &CoordinateImage) {
        let or_sky = |offset: &[f32; 2]| {
            if offset[0].is_nan() { [CoordinatePass::SKY; 2] } else { *offset }
        };
        let texels: Vec<[f32; 2]> = image.offsets.iter().map(or_sky).collect();
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(8 * IMAGE_PX[0]),
            rows_per_image: None,
        };
        let texture = self.image.as_image_copy();
        let bytes = bytemuck::cast_slice(&texels);
        self.gpu.queue.write_texture(texture, bytes, layout, self.image.size());
    }

    fn encoder(&self) -> wgpu::CommandEncoder {
        self.gpu.device.create_command_encoder(&Default::default())
    }

    fn see(&self, image: &CoordinateImage, joins: bool) {
        self.show(image);
        let mut encoder = self.encoder();
        self.selection.see(&mut encoder, joins);
        self.gpu.queue.submit([encoder.finish()]);
    }

    fn select(&mut self, tree: &TileTree, request: &SelectionRequest<'_>) -> Selection {
        let mut encoder = self.encoder();
        self.selection.select(&self.gpu.queue, &mut encoder, tree, request);
        self.gpu.queue.submit([encoder.finish()]);
        let words = read_words(self.gpu, self.selection.selected());
        let tiles = words[8..].chunks_exact(4).take(words[0] as usize);
        let statistics = SelectionStatistics {
            subdivided: words[1] as usize,
            regularized_away: words[2] as usize,
            merges: words[3] as usize,
            finest_level: words[4] as u8,
            hidden: words[5] as usize,
        };
        let tiles = tiles.map(|tile| TileId::new(tile[0] as u8, tile[1], tile[2])).collect();
        Selection { tiles, statistics }
    }
}

fn read_words(gpu: &GpuContext, buffer: &wgpu::Buffer) -> Vec<u32> {
    let copy = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: buffer.size(),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    encoder.copy_buffer_to_buffer(buffer, 0, &copy, 0, buffer.size());
    gpu.queue.submit([encoder.finish()]);
    copy.slice(..).map_async(wgpu::MapMode::Read, |_| ());
    gpu.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    gpu.check().unwrap();
    bytemuck::pod_collect_to_vec(&copy.slice(..).get_mapped_range().unwrap())
}

fn random_view(dice: &mut Dice) -> CameraView {
    let root = SCHEME.root_extent();
    let place = root.min + dvec2(dice.between(-0.2, 1.2), dice.between(-0.2, 1.2)) * root.size_m();
    // Now and then from space.
    let height_m = dice.between(0.0, 1.0).powi(4) * dice.of(&[6_000.0, 6_000.0, 900_000.0]);
    CameraView {
        eye: place.extend(height_m),
        heading_deg: dice.between(0.0, 360.0),
        pitch_deg: dice.between(-90.0, 40.0),
        fov_y_deg: dice.between(20.0, 100.0),
        viewport_px: [1280, 720],
    }
}

/// What a view might see: rays to ground whose height changes from one part of the picture to the next
/// by leaps, as it does from a ridge to what lies behind it.
fn image_of(view: &CameraView, dice: &mut Dice) -> CoordinateImage {
    let [width, height] = IMAGE_PX;
    let leaps: Vec<f64> = (0..height).map(|_| dice.between(0.0, 0.95)).collect();
    let scale = dvec2(1280.0, 720.0) / dvec2(f64::from(width), f64::from(height));
    let root = SCHEME.root_extent();
    let offset = |i: u32| {
        let pixel = (dvec2(f64::from(i % width), f64::from(i / width)) + 0.5) * scale;
        let ray = view.ray_direction(pixel.x, pixel.y);
        let ground_m = view.eye.z * leaps[(i / width / 6 + (i % width) / 13) as usize];
        let ahead: DVec3 = ray * ((ground_m - view.eye.z) / ray.z);
        let point = view.eye.truncate() + ahead.truncate();
        let is_ground = ray.z < 0.0 && root.contains(point);
        if is_ground { ahead.truncate().as_vec2().to_array() } else { [f32::NAN; 2] }
    };
    image(view, (0..width * height).map(offset).collect())
}

fn image(view: &CameraView, offsets: Vec<[f32; 2]>) -> CoordinateImage {
    let [width, height] = IMAGE_PX;
    let origin = view.eye.truncate();
    CoordinateImage { width, height, origin, offsets, frame: 0, view: *view }
}

/// One path down to the deepest level, and its siblings as far as `siblings`.
fn deep_tree(deepest: u8, siblings: u8) -> TileTree {
    let target = TileId::new(deepest, (1 << deepest) / 3, (1 << deepest) / 5 * 2);
    let mut present: TileSet = (0..=deepest).map(|level| target.ancestor_at(level)).collect();
    for level in 0..siblings {
        for child in target.ancestor_at(level).children() {
            present.insert(child);
        }
    }
    let layout = LayerLayout { tile_size_texels: 128, gutter_texels: 4, level_count: deepest + 1 };
    TileTree { heights: LayerTree { layout, present }, ..tree(1, 4, None, 100) }
}

/// The trees of the cases: full, sparse, empty but for the root, one layer and two of different depths,
/// and deep ones.
fn trees() -> Vec<TileTree> {
    let mut trees = vec![
        tree(1, 6, None, 130),
        tree(2, 7, Some(7), 100),
        tree(3, 4, Some(7), 60),
        tree(4, 7, Some(5), 25),
        tree(5, 1, None, 100),
        deep_tree(24, 24),
        deep_tree(18, 12),
    ];
    let colours = layer(8, 384, |tile| mixed(9, tile.ancestor_at(4)) > u64::MAX / 3);
    trees.push(TileTree {
        colours: Some(colours),
        height_ranges: height_ranges(7, 1),
        ..tree(6, 8, None, 90)
    });
    trees
}

fn random_config(dice: &mut Dice) -> SelectionConfig {
    SelectionConfig {
        max_tiles: dice.of(&[1, 2, 7, 36, 64, 256, 100_000]),
        texel_px: dice.of(&[0.1, 0.4, 1.0, 3.0, 30.0]) * dice.between(0.8, 1.25),
        vertical_exaggeration: dice.of(&[1.0, 1.0, 0.01, 3.0, 1_000.0]),
        shortening: dice.of(&Shortening::ALL),
    }
}

#[test]
fn the_gpu_selects_the_tiles_the_cpu_does() {
    let Some(gpu) = gpu() else { return };
    let (mut merges, mut hidden, mut most) = (0, 0, 0);
    for (number, tree) in trees().iter().enumerate() {
        let mut on_gpu = OnGpu::new(&gpu, tree);
        let mut dice = Dice(1_000 * number as u64);
        for turn in 0..40 {
            let (seen_by, config) = (random_view(&mut dice), random_config(&mut dice));
            let image = image_of(&seen_by, &mut dice);
            // The camera has moved on since, or not.
            let moved = dvec3(dice.between(-900.0, 900.0), dice.between(-900.0, 900.0), 20.0);
            let view = CameraView { eye: seen_by.eye + moved * f64::from(turn % 2), ..seen_by };
            on_gpu.see(&image, false);
            for is_exact in [false, true] {
                let region = visible_region(&image);
                let seen = region
                    .as_ref()
                    .map(|region| SeenGround { region, image: is_exact.then_some(&image) });
                let expected = select(tree, seen, &view, &config);
                let request = SelectionRequest {
                    view: &view,
                    config: &config,
                    image_origin: image.origin,
                    is_exact,
                };
                let found = on_gpu.select(tree, &request);
                let case =
                    format!("tree {number}, turn {turn}, exact {is_exact}, {config:?}, {view:?}");
                assert_eq!(found.statistics, expected.statistics, "{case}");
                assert_eq!(found.tiles, expected.tiles, "{case}");
                merges += expected.statistics.merges;
                hidden += expected.statistics.hidden;
                most = most.max(expected.statistics.subdivided);
            }
        }
    }
    // The cases are worth something.
    assert!(merges > 5_000 && hidden > 5_000 && most > 3_000, "{merges} {hidden} {most}");
}

#[test]
fn absurd_settings_end_the_same_on_both_sides() {
    let Some(gpu) = gpu() else { return };
    let tree = tree(3, 7, Some(10), 100);
    let mut on_gpu = OnGpu::new(&gpu, &tree);
    let mut dice = Dice(5);
    let eye = SCHEME.root_extent().centre().extend(2_600.0);
    let view = CameraView { eye, pitch_deg: -30.0, ..random_view(&mut dice) };
    let image = image_of(&view, &mut dice);
    on_gpu.see(&image, false);
    let region = visible_region(&image);
    for texel_px in [0.0, -1.0, f64::NAN, f64::INFINITY, 1.0e-300] {
        for max_tiles in [0, 36, usize::MAX] {
            let config = SelectionConfig { texel_px, max_tiles, ..SelectionConfig::default() };
            let seen = region.as_ref().map(SeenGround::of_box);
            let expected = select(&tree, seen, &view, &config);
            let request = SelectionRequest {
                view: &view,
                config: &config,
                image_origin: image.origin,
                is_exact: false,
            };
            assert_eq!(on_gpu.select(&tree, &request), expected, "{config:?}");
        }
    }
}

/// The box of the image as the GPU finds it.
fn box_on_gpu(on_gpu: &OnGpu<'_>, origin: DVec2) -> Option<VisibleRegion> {
    let words = read_words(on_gpu.gpu, on_gpu.selection.seen_ground());
    let float = |word: u32| f32::from_bits(if word >> 31 == 1 { word ^ (1 << 31) } else { !word });
    let [west, south, east, north] = [0, 1, 2, 3].map(|i| float(words[i]));
    (words[4] > 0).then(|| VisibleRegion {
        origin,
        min_m: [-west, -south],
        max_m: [east, north],
        covered_pixels: words[4],
    })
}

#[test]
fn the_gpu_finds_the_box_the_cpu_does() {
    let Some(gpu) = gpu() else { return };
    let tree = tree(1, 2, None, 100);
    let on_gpu = OnGpu::new(&gpu, &tree);
    let mut dice = Dice(77);
    let view = random_view(&mut dice);
    let pixels = (IMAGE_PX[0] * IMAGE_PX[1]) as usize;
    let sky = [f32::NAN; 2];
    for turn in 0..60 {
        let scale = dice.of(&[1.0e-3, 1.0, 1.0e5, 1.0e30]);
        let (density, lean) = (dice.of(&[0.0, 0.002, 0.3, 1.0]), dice.of(&[-1.0, -0.5, 0.0]));
        let mut coordinate = || ((dice.part() + lean) * scale) as f32;
        let mut offsets: Vec<_> = (0..pixels).map(|_| [coordinate(), coordinate()]).collect();
        for offset in &mut offsets {
            if dice.part() >= density {
                *offset = sky;
            }
        }
        if turn % 4 == 1 {
            offsets[7] = [f32::INFINITY, 3.0];
            offsets[pixels - 1] = [-5.0, f32::NEG_INFINITY];
            offsets[8] = [0.0, -0.0];
        }
        if turn == 0 {
            offsets.fill(sky);
            offsets[pixels - 1] = [-2.5, 8.0];
        }
        let image = image(&view, offsets);
        let expected = visible_region(&image);
        on_gpu.see(&image, false);
        assert_eq!(box_on_gpu(&on_gpu, image.origin), expected, "turn {turn}");
        // What another image shows joins it.
        let other = image_of(&view, &mut dice);
        on_gpu.see(&other, true);
        let both = box_on_gpu(&on_gpu, image.origin).map(|region| region.extent());
        let expected = VisibleRegion::union(expected, visible_region(&other));
        assert_eq!(both, expected.map(|region| region.extent()), "turn {turn}, both");
    }
}
