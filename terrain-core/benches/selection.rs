//! What the CPU does a frame: the scan for the visible region, the selection of tiles, the plans of
//! cache and table, the culling of the mesh.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use glam::{DVec2, dvec2, dvec3};
use terrain_core::CameraView;
use terrain_core::dataset::{HeightRange, HeightRanges, Shape};
use terrain_core::residency::{OffsetTable, TileCache};
use terrain_core::selection::{
    CoordinateImage, LayerTree, SeenGround, Selection, SelectionConfig, Strategy, TileTree,
    VisibleRegion, merge_farthest, regularize, select, select_by_frustum, subdivide,
    visible_region,
};
use terrain_core::surface::{CircularMesh, CircularMeshSettings};
use terrain_core::tiling::{Extent, LayerLayout, TileId, TileSet, TilingScheme};

/// Tiles of the final selections.
const SIZES: [usize; 3] = [36, 256, 2_000];
/// Levels of both layers: 65,536 x 65,536 heights and 196,608 x 196,608 colours.
const LEVELS: u8 = 10;

fn full_layer(tile_size_texels: u32) -> LayerTree {
    let mut present = TileSet::new();
    for level in 0..LEVELS {
        for row in 0..1 << level {
            for column in 0..1 << level {
                present.insert(TileId::new(level, row, column));
            }
        }
    }
    let layout = LayerLayout { tile_size_texels, gutter_texels: 4, level_count: LEVELS };
    LayerTree { layout, present }
}

fn tree() -> TileTree {
    let scheme = TilingScheme { origin: dvec2(4.0e5, 7.0e6), root_size_m: 1_966_080.0 };
    let range = Some(HeightRange { min_m: 0.0, max_m: 2_469.0 });
    TileTree {
        scheme,
        data_extent: scheme.root_extent(),
        shape: Shape::Plane,
        heights: full_layer(128),
        colours: Some(full_layer(384)),
        height_ranges: HeightRanges { levels: vec![vec![range]] },
    }
}

/// An eye 500 m over the mountains, and a region of 400 km before it.
fn view_and_region(tree: &TileTree) -> (CameraView, VisibleRegion) {
    let eye = tree.scheme.root_extent().centre() + dvec2(1_234.0, -5_678.0);
    let view = CameraView {
        eye: eye.extend(2_969.0),
        heading_deg: 0.0,
        pitch_deg: -10.0,
        fov_y_deg: 50.0,
        viewport_px: [1280, 720],
    };
    let extent = Extent::new(eye - dvec2(200_000.0, 500.0), eye + dvec2(200_000.0, 400_000.0));
    (view, VisibleRegion::of_extent(&extent))
}

/// The threshold at which the paper's selection comes nearest below `tiles` without any merging.
fn config_for(tree: &TileTree, tiles: usize) -> SelectionConfig {
    config_of(Strategy::RttQuadtree, tree, tiles)
}

/// The threshold at which the strategy's selection comes nearest below `tiles` without a limit.
fn config_of(strategy: Strategy, tree: &TileTree, tiles: usize) -> SelectionConfig {
    let (view, region) = view_and_region(tree);
    let config =
        |texel_px| SelectionConfig { max_tiles: usize::MAX, texel_px, ..Default::default() };
    let strategy = strategy.implementation();
    let selection = |texel_px| {
        let seen = SeenGround::of_box(&region);
        let chosen = strategy.map(|s| s.select(tree, Some(seen), &view, &config(texel_px)));
        chosen.unwrap_or_default()
    };
    let count = |texel_px| selection(texel_px).tiles.len();
    let (mut coarse, mut fine) = (1_000.0_f64, 0.01_f64);
    for _ in 0..40 {
        let middle = (coarse * fine).sqrt();
        if count(middle) > tiles {
            fine = middle;
        } else {
            coarse = middle;
        }
    }
    SelectionConfig { max_tiles: tiles, ..config(coarse) }
}

fn selection(criterion: &mut Criterion) {
    let tree = tree();
    let (view, region) = view_and_region(&tree);
    let mut group = criterion.benchmark_group("select");
    for tiles in SIZES {
        let fitting = config_for(&tree, tiles);
        group.bench_function(BenchmarkId::new("fitting", tiles), |bencher| {
            bencher.iter(|| {
                select(&tree, Some(SeenGround::of_box(&region)), &view, black_box(&fitting))
            });
        });
        // A finer threshold: four times as many tiles are listed as may stay.
        let merging = SelectionConfig { max_tiles: tiles, ..config_for(&tree, 4 * tiles) };
        group.bench_function(BenchmarkId::new("merging four to one", tiles), |bencher| {
            bencher.iter(|| {
                select(&tree, Some(SeenGround::of_box(&region)), &view, black_box(&merging))
            });
        });
    }
    group.finish();

    let mut group = criterion.benchmark_group("stages at 256 tiles of 1024");
    let config = SelectionConfig { max_tiles: 256, ..config_for(&tree, 1_024) };
    let listed = subdivide(&tree, Some(SeenGround::of_box(&region)), &view, &config);
    let mut regular = listed.clone();
    regularize(&mut regular);
    group.bench_function("subdivide", |bencher| {
        bencher.iter(|| {
            subdivide(&tree, Some(SeenGround::of_box(&region)), &view, black_box(&config))
        });
    });
    group.bench_function("regularize", |bencher| {
        bencher.iter_batched_ref(|| listed.clone(), regularize, criterion::BatchSize::SmallInput);
    });
    group.bench_function("merge_farthest", |bencher| {
        let merge = |list: &mut _| merge_farthest(list, 256);
        bencher.iter_batched_ref(|| regular.clone(), merge, criterion::BatchSize::SmallInput);
    });
    group.finish();
}

/// What a coordinate pass of 160 x 90 would show of the view over level ground.
fn image(view: &CameraView, ground_m: f64) -> CoordinateImage {
    let (width, height) = (160, 90);
    let offset = |i: u32| {
        let pixel = [f64::from(i % width) + 0.5, f64::from(i / width) + 0.5].map(|at| 8.0 * at);
        let ray = view.ray_direction(pixel[0], pixel[1]);
        let ahead = ray.truncate() * (ground_m - view.eye.z) / ray.z;
        if ray.z < 0.0 { ahead.as_vec2().to_array() } else { [f32::NAN; 2] }
    };
    let offsets = (0..width * height).map(offset).collect();
    CoordinateImage { width, height, origin: view.eye.truncate(), offsets, frame: 0, view: *view }
}

fn by_what_pixels_saw(criterion: &mut Criterion) {
    let tree = tree();
    let (view, _) = view_and_region(&tree);
    let image = image(&view, 1_200.0);
    let Some(region) = visible_region(&image) else { return };
    let config = SelectionConfig { max_tiles: 256, ..Default::default() };
    let mut group = criterion.benchmark_group("select by 160 x 90 pixels");
    for (name, image) in [("box", None), ("exact", Some(&image))] {
        let seen = SeenGround { region: &region, image };
        group.bench_function(name, |bencher| {
            bencher.iter(|| select(&tree, Some(black_box(seen)), &view, &config));
        });
    }
    group.finish();
}

fn by_frustum(criterion: &mut Criterion) {
    let tree = tree();
    let (view, _) = view_and_region(&tree);
    let mut group = criterion.benchmark_group("select by frustum");
    for tiles in SIZES {
        let config = |tiles| config_of(Strategy::CpuFrustum, &tree, tiles);
        let fitting = config(tiles);
        group.bench_function(BenchmarkId::new("fitting", tiles), |bencher| {
            bencher.iter(|| select_by_frustum(&tree, &view, black_box(&fitting)));
        });
        let limited = SelectionConfig { max_tiles: tiles, ..config(4 * tiles) };
        group.bench_function(BenchmarkId::new("limited to a quarter", tiles), |bencher| {
            bencher.iter(|| select_by_frustum(&tree, &view, black_box(&limited)));
        });
    }
    group.finish();
}

fn residency(criterion: &mut Criterion) {
    let tree = tree();
    let (view, region) = view_and_region(&tree);
    let mut group = criterion.benchmark_group("residency");
    for (tiles, side) in [(36, 6), (256, 16), (2_000, 48)] {
        let config = config_for(&tree, tiles);
        let selection: Selection = select(&tree, Some(SeenGround::of_box(&region)), &view, &config);
        let mut cache = TileCache::new(side, side);
        cache.plan(&selection.tiles, &|_| Some(1), u64::MAX, 0);
        let mut frame = 0;
        group.bench_function(BenchmarkId::new("plan with all resident", tiles), |bencher| {
            bencher.iter(|| {
                frame += 1;
                cache.plan(black_box(&selection.tiles), &|_| None, 0, frame)
            });
        });
        group.bench_function(BenchmarkId::new("offset table", tiles), |bencher| {
            bencher.iter(|| OffsetTable::build(black_box(&cache).residents()));
        });
        group.bench_function(BenchmarkId::new("tiles of a layer", tiles), |bencher| {
            bencher.iter(|| black_box(&selection).colour_tiles(&tree));
        });
        let table = OffsetTable::build(cache.residents());
        let position = tree.scheme.fixed_from_world(region.extent().max - 1.0);
        group.bench_function(BenchmarkId::new("find, linear", tiles), |bencher| {
            bencher.iter(|| table.find_linear(black_box(position)));
        });
        group.bench_function(BenchmarkId::new("find, descending", tiles), |bencher| {
            bencher.iter(|| table.find_descend(black_box(position)));
        });
    }
    group.finish();
}

fn region_and_mesh(criterion: &mut Criterion) {
    let tree = tree();
    let (view, region) = view_and_region(&tree);
    let (width, height) = (512, 288);
    let offsets = (0..width * height)
        .map(|i| if i < width * height / 4 { [f32::NAN; 2] } else { [(i % 977) as f32, i as f32] })
        .collect();
    let origin = dvec3(4.0e5, 7.0e6, 0.0).truncate();
    let image = CoordinateImage { width, height, origin, offsets, frame: 0, view };
    criterion.bench_function("visible region of 512 x 288", |bencher| {
        bencher.iter(|| visible_region(black_box(&image)));
    });
    let settings = CircularMeshSettings { spacing_ratio: 0.0104, rho_max: 800.0 };
    criterion.bench_function("circular mesh", |bencher| {
        bencher.iter(|| CircularMesh::build(black_box(&settings)));
    });
    let mesh = CircularMesh::build(&settings);
    criterion.bench_function("visible blocks", |bencher| {
        bencher.iter(|| {
            mesh.visible_blocks(
                &view,
                500.0,
                DVec2::ZERO,
                0.0,
                2_469.0,
                black_box(&region.extent()),
            )
        });
    });
}

criterion_group!(benches, selection, by_what_pixels_saw, by_frustum, residency, region_and_mesh);
criterion_main!(benches);
