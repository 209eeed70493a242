//! Datasets, regions and views to select tiles for: the cases every strategy is tried on.

use glam::{DVec2, dvec2, dvec3};
use proptest::prelude::*;

use crate::CameraView;
use crate::dataset::{HeightRange, HeightRanges, Shape};
use crate::selection::{
    LayerTree, SeenGround, Selection, SelectionConfig, Shortening, Strategy as TileStrategy,
    TileTree, VisibleRegion,
};
use crate::tiling::{Extent, LayerLayout, TileId, TileSet, TilingScheme};

/// Everything a strategy must give a selection for.
#[derive(Clone, Debug)]
pub struct Case {
    pub tree: TileTree,
    pub region: Option<VisibleRegion>,
    pub view: CameraView,
    pub config: SelectionConfig,
}

impl Case {
    /// The case's selection by a strategy.
    pub fn select(&self, strategy: TileStrategy) -> Selection {
        let implementation = strategy.implementation().expect("a strategy of tiles");
        let region = self.region.as_ref().filter(|_| implementation.needs_region());
        let seen = region.map(SeenGround::of_box);
        implementation.select(&self.tree, seen, &self.view, &self.config)
    }
}

pub const SCHEME: TilingScheme =
    TilingScheme { origin: DVec2 { x: 412_000.5, y: 6_850_000.25 }, root_size_m: 61_440.0 };

/// A pyramid over the finest tiles of which `is_present` says yes.
pub fn layer(
    level_count: u8,
    tile_size_texels: u32,
    is_present: impl Fn(TileId) -> bool,
) -> LayerTree {
    let finest = level_count - 1;
    let mut present = TileSet::new();
    for row in 0..1 << finest {
        for column in 0..1 << finest {
            let tile = TileId::new(finest, row, column);
            if is_present(tile) {
                (0..=finest).for_each(|level| {
                    present.insert(tile.ancestor_at(level));
                });
            }
        }
    }
    LayerTree { layout: LayerLayout { tile_size_texels, gutter_texels: 4, level_count }, present }
}

/// A mix of the bits of `seed` and a tile, evenly spread.
pub fn mixed(seed: u64, tile: TileId) -> u64 {
    let key = (u64::from(tile.level) << 56) ^ (u64::from(tile.row) << 28) ^ u64::from(tile.column);
    let mut z = seed.wrapping_add(key.wrapping_mul(0x9e37_79b9_7f4a_7c15));
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Heights by level, each child's range within its parent's.
pub fn height_ranges(seed: u64, levels: u8) -> HeightRanges {
    let range = |tile: TileId| {
        let mut range = HeightRange { min_m: 0.0, max_m: 2_400.0 };
        for level in 1..=tile.level {
            let part = (mixed(seed, tile.ancestor_at(level)) % 100) as f32 / 100.0;
            let size = range.max_m - range.min_m;
            range.min_m += 0.3 * size * part;
            range.max_m -= 0.3 * size * (1.0 - part);
        }
        Some(range)
    };
    let level = |level: u8| {
        let tiles = 1_u32 << level;
        (0..tiles * tiles).map(|i| range(TileId::new(level, i / tiles, i % tiles))).collect()
    };
    HeightRanges { levels: (0..levels).map(level).collect() }
}

/// `density` in 0..=100: the part of the finest tiles that hold data.
pub fn tree(seed: u64, height_levels: u8, colour_levels: Option<u8>, density: u64) -> TileTree {
    let is_present = |salt: u64| move |tile| mixed(seed ^ salt, tile) % 100 < density;
    TileTree {
        scheme: SCHEME,
        data_extent: SCHEME.root_extent(),
        shape: Shape::Plane,
        heights: layer(height_levels, 128, is_present(1)),
        colours: colour_levels.map(|levels| layer(levels, 384, is_present(2))),
        height_ranges: height_ranges(seed, height_levels.min(3)),
    }
}

pub fn cases() -> impl Strategy<Value = Case> {
    let trees = (any::<u64>(), 1u8..=5, prop::option::of(1u8..=6), 0u64..=130)
        .prop_map(|(seed, heights, colours, density)| tree(seed, heights, colours, density));
    // In parts of the root, from its south-west corner; some regions and eyes outside of it.
    let part = -0.2..1.2f64;
    let corners = ((part.clone(), part.clone()), (part.clone(), part.clone()));
    let region = prop::option::weighted(0.9, corners);
    let camera = (0.0..360.0f64, -90.0..40.0f64, 20.0..100.0f64);
    let view = ((part.clone(), part), 0.0..6_000.0f64, camera);
    let config = (prop_oneof![0usize..40, Just(400)], 0.3..30.0f64, 0.5..3.0f64);
    (trees, region, view, config).prop_map(|(tree, region, view, config)| {
        let root = SCHEME.root_extent();
        let world = |(x, y): (f64, f64)| root.min + dvec2(x, y) * root.size_m();
        let region = region.map(|(a, b)| {
            let extent = Extent::new(world(a).min(world(b)), world(a).max(world(b)));
            VisibleRegion::of_extent(&extent)
        });
        let (eye, height_m, (heading_deg, pitch_deg, fov_y_deg)) = view;
        let view = CameraView {
            eye: world(eye).extend(height_m),
            heading_deg,
            pitch_deg,
            fov_y_deg,
            viewport_px: [1280, 720],
        };
        let (max_tiles, texel_px, vertical_exaggeration) = config;
        let shortening = Shortening::Farthest;
        let config = SelectionConfig { max_tiles, texel_px, vertical_exaggeration, shortening };
        Case { tree, region, view, config }
    })
}

/// An eye 200 m over the middle of the root, and the region of all of it.
pub fn low_over_the_middle(tree: TileTree, config: SelectionConfig) -> Case {
    let root = SCHEME.root_extent();
    let view = CameraView {
        eye: root.centre().extend(2_600.0) + dvec3(11.0, 17.0, 0.0),
        heading_deg: 0.0,
        pitch_deg: -10.0,
        fov_y_deg: 50.0,
        viewport_px: [1280, 720],
    };
    let region = Some(VisibleRegion::of_extent(&root));
    Case { tree, region, view, config }
}
