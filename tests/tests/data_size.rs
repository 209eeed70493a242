//! What a frame costs does not grow with the data: the same flight over the same ground, once in a
//! source of 2^13 texels a side and once in one of 2^18 of which the first is a tile.
//!
//! What does grow is a tile a level: the list of the selected tiles holds the ancestors that no four
//! children stand in for, and the larger source has five levels of them more.

#![allow(clippy::unwrap_used, reason = "a step that fails fails the test")]
#![allow(clippy::print_stdout, reason = "measured values are to be seen")]

use std::collections::BTreeSet;
use std::sync::Arc;

use glam::dvec2;
use terrain_core::dataset::HeightRanges;
use terrain_core::measure::FrameRecord;
use terrain_core::selection::{SelectionConfig, Strategy, TileTree, select_by_frustum};
use terrain_core::tiling::TileId;
use terrain_core::{CameraView, RendererSettings};
use terrain_tests::{AnalyticSource, Bench, NestedSources};

const SIZE_PX: [u32; 2] = [320, 180];
/// 2^18 instead of 2^13 texels.
const EXTRA_LEVELS: u8 = 5;
const SOURCES: NestedSources = NestedSources { tile_sizes_texels: [128, 128] };

/// Frames of a straight flight, 60 m a frame, that keeps within a quarter of the smaller source: at its
/// middle lines its own level 0 comes and goes as a tile of the larger one.
fn flight(pitch_deg: f64) -> impl Iterator<Item = CameraView> {
    (0..40).map(move |frame| CameraView {
        eye: dvec2(-13_000.0, 6_000.0 + 60.0 * f64::from(frame)).extend(2_500.0),
        heading_deg: 5.0,
        pitch_deg,
        fov_y_deg: 50.0,
        viewport_px: SIZE_PX,
    })
}

/// Room for all that the views want.
fn settings(strategy: Strategy) -> RendererSettings {
    RendererSettings {
        strategy,
        cache_columns: 12,
        cache_rows: 12,
        max_tiles: 144,
        ..Default::default()
    }
}

/// The selected tiles as the smallest source has them, and how many coarser ones there are.
fn selected(bench: &Bench, extra_levels: u8) -> (BTreeSet<TileId>, usize) {
    let tiles = &bench.renderer.selection().tiles;
    let same: BTreeSet<_> =
        tiles.iter().filter_map(|tile| NestedSources::in_smallest(*tile, extra_levels)).collect();
    let coarser = tiles.len() - same.len();
    (same, coarser)
}

/// Everything but the tables that a frame counts, and that has to be the same.
fn counted(record: &FrameRecord) -> [(&'static str, u64); 7] {
    [
        ("bytes of heights", record.upload_dem_bytes),
        ("bytes of colours", record.upload_dom_bytes),
        ("bytes of meshes", record.upload_mesh_bytes),
        ("bytes read back", record.readback_bytes),
        ("new tiles", record.tiles_new),
        ("blocks", record.blocks_drawn),
        ("triangles", record.triangles_drawn),
    ]
}

/// What two sources cost on the flight: sums over all frames but the first, which fills caches.
#[derive(Default)]
struct Costs {
    bytes: [u64; 2],
    tiles: [u64; 2],
    triangles: [u64; 2],
}

impl Costs {
    fn add(&mut self, records: &[FrameRecord; 2]) {
        for (index, record) in records.iter().enumerate() {
            self.bytes[index] += record.upload_bytes + record.readback_bytes;
            self.tiles[index] += record.tiles_selected;
            self.triangles[index] += record.triangles_drawn;
        }
    }

    /// Says by how many percent the costs have grown; returns that of the bytes.
    fn growth(&self, strategy: Strategy) -> f64 {
        // Of what one has none of, so has the other.
        let growth = |[small, large]: [u64; 2]| match small == large {
            true => 0.0,
            false => 100.0 * (large as f64 / small as f64 - 1.0),
        };
        let [bytes, tiles, triangles] = [self.bytes, self.tiles, self.triangles].map(growth);
        println!(
            "{strategy}: {bytes:.1} % more bytes, {tiles:.1} % more tiles on the list, \
             {triangles:.1} % more triangles"
        );
        bytes
    }
}

/// A renderer of each source; `None` where there is no GPU.
fn benches(sources: &[Arc<AnalyticSource>; 2], strategy: Strategy) -> Option<[Bench; 2]> {
    let bench = |source: &Arc<AnalyticSource>| {
        Bench::new(Arc::clone(source) as _, settings(strategy)).unwrap()
    };
    Some([bench(&sources[0])?, bench(&sources[1])?])
}

#[test]
fn over_the_same_ground_a_frame_costs_the_same_but_for_an_ancestor_a_level() {
    let sources = [0, EXTRA_LEVELS].map(|extra| SOURCES.source(extra));
    for strategy in [Strategy::RttQuadtree, Strategy::RttQuadtreeGpu, Strategy::CpuFrustum] {
        let Some([mut small, mut large]) = benches(&sources, strategy) else { return };
        let mut costs = Costs::default();
        for (frame, view) in flight(-55.0).enumerate() {
            let records = [small.settle(&view).unwrap(), large.settle(&view).unwrap()];
            let (same, own_coarser) = selected(&small, 0);
            let (also, coarser) = selected(&large, EXTRA_LEVELS);
            assert_eq!(same, also, "{strategy}, frame {frame}: other tiles");
            assert!(coarser <= own_coarser + usize::from(EXTRA_LEVELS), "{strategy}: {coarser}");
            if frame > 0 {
                assert_eq!(counted(&records[0]), counted(&records[1]), "{strategy}, frame {frame}");
                costs.add(&records);
            }
        }
        let bytes = costs.growth(strategy);
        assert!(bytes < 5.0, "{strategy}: {bytes} %");
    }
}

/// What the flight costs over both sources; `None` where there is no GPU.
fn fly(strategy: Strategy) -> Option<Costs> {
    let sources = [0, EXTRA_LEVELS].map(|extra| SOURCES.source(extra));
    let [mut small, mut large] = benches(&sources, strategy)?;
    let mut costs = Costs::default();
    for (frame, view) in flight(-55.0).enumerate() {
        let records = [small.settle(&view).unwrap(), large.settle(&view).unwrap()];
        if frame > 0 {
            costs.add(&records);
        }
    }
    Some(costs)
}

/// The mesh made on the CPU covers all the data, in sight or not: more triangles where there is more
/// ground round the view. They are sent once, with the first frame.
#[test]
fn a_mesh_of_all_the_data_has_more_triangles_and_moves_the_same_bytes() {
    let Some(costs) = fly(Strategy::CpuMesh) else { return };
    let bytes = costs.growth(Strategy::CpuMesh);
    assert!(bytes.abs() < 5.0, "{bytes} %");
}

/// A clipmap's windows cover the same number of texels a level, however large the data, and each level's
/// move half as far as the next finer one's. Of the smaller source the three coarsest levels are whole in
/// their windows: the four that move send 1 + 1/2 + 1/4 + 1/8 times what the finest does, where any
/// number of levels sends twice as much at the most.
#[test]
fn windows_move_the_same_bytes_but_for_the_coarsest_levels() {
    let Some(costs) = fly(Strategy::Clipmap) else { return };
    let bytes = costs.growth(Strategy::Clipmap);
    let of_texels = 100.0 * (2.0 / 1.875 - 1.0);
    assert!(bytes < of_texels + 1.0, "{bytes} %");
}

#[test]
fn ranges_of_larger_tiles_split_more() {
    // As many levels as a dataset keeps the ranges of, and all but the finest.
    let few = SOURCES.source_without_ranges(EXTRA_LEVELS);
    let few = few.with_height_ranges(HeightRanges::MAX_LEVELS);
    let trees = [TileTree::of_source(&few), TileTree::of_source(&*SOURCES.source(EXTRA_LEVELS))];
    let config = SelectionConfig { max_tiles: 4_096, ..Default::default() };
    let tiles = trees.map(|tree| {
        let lists = flight(-55.0).map(|view| select_by_frustum(&tree, &view, &config));
        lists.map(|list| list.tiles.len()).sum::<usize>()
    });
    println!("{:.2} times the tiles: {tiles:?}", tiles[0] as f64 / tiles[1] as f64);
    assert!(tiles[0] > tiles[1]);
}

#[test]
fn towards_the_horizon_a_list_without_limit_grows_by_the_levels_and_not_by_the_size() {
    let config = SelectionConfig { max_tiles: 4_096, ..Default::default() };
    let counts: Vec<usize> = (0..=EXTRA_LEVELS)
        .map(|extra_levels| {
            let tree = TileTree::of_source(&*SOURCES.source(extra_levels));
            let lists = flight(-10.0).map(|view| select_by_frustum(&tree, &view, &config));
            lists.map(|list| list.tiles.len()).max().unwrap_or(0)
        })
        .collect();
    println!("tiles at 2^13 to 2^18 texels a side: {counts:?}");
    // A ring of tiles a level: each ring is twice as far out, and its tiles twice as large.
    for pair in counts.windows(2) {
        assert!(pair[1] <= pair[0] + 32, "{counts:?}");
    }
}
