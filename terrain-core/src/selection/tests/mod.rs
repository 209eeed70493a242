//! The stages of the paper's selection against literal versions of its sentences; what holds for every
//! strategy is in `invariants`, the frustum's selection against brute force in `frustum`.

pub(crate) mod cases;
mod frustum;
mod invariants;
mod least_error;
mod seen;
mod sight;

use std::collections::BTreeSet;

use glam::DVec2;
use proptest::prelude::{ProptestConfig, any, prop, prop_assert_eq, proptest};

use self::cases::{Case, SCHEME, cases, height_ranges, low_over_the_middle, tree};
use self::invariants::check_order;
use super::eye_units::EyeUnits;
use super::ground_units::FixedBox;
use super::{
    LayerTree, SeenGround, SelectionConfig, Strategy, TileList, TileTree, VisibleRegion,
    merge_farthest, regularize, subdivide,
};
use crate::tiling::{Extent, LayerLayout, TileId, TileSet};

type List = BTreeSet<TileId>;

fn all_tiles(tree: &TileTree) -> impl Iterator<Item = TileId> {
    (0..=tree.finest_level()).flat_map(|level| {
        let tiles = 1_u32 << level;
        (0..tiles * tiles).map(move |i| TileId::new(level, i / tiles, i % tiles))
    })
}

/// Side of a unit of distances in metres, for the eyes of the cases, all less than two roots away.
fn unit_m(case: &Case) -> f64 {
    let root_m = SCHEME.root_size_m;
    let from_corner = (case.view.eye - SCHEME.origin.extend(0.0)).abs().max_element();
    let unit_m = root_m / f64::from(1 << 30);
    if from_corner > root_m { 2.0 * unit_m } else { unit_m }
}

/// Squared distance of a tile's box from the eye in units, from corners in metres.
fn squared_units(case: &Case, tile: TileId) -> u64 {
    let unit_m = unit_m(case);
    let size_m = SCHEME.root_size_m / f64::from(1 << tile.level);
    let (west, north) = (f64::from(tile.column) * size_m, f64::from(tile.row) * size_m);
    let heights = case.tree.height_ranges.range(tile).unwrap();
    let heights = [heights.min_m, heights.max_m];
    let [low, high] = heights.map(|height| f64::from(height) * case.config.vertical_exaggeration);
    let eye = case.view.eye - SCHEME.origin.extend(0.0);
    let squared_gap = |from: i64, to: i64, eye_m: f64| {
        let eye = (eye_m / unit_m).round() as i64;
        let gap = if eye < from { from - eye } else { (eye - to).max(0) };
        (gap * gap) as u64
    };
    let beside = |from_m: f64, eye_m: f64| {
        let to_m = from_m + size_m;
        squared_gap((from_m / unit_m).floor() as i64, (to_m / unit_m).ceil() as i64, eye_m)
    };
    // Casts cut off what is behind the point.
    let (low, high) = ((low / unit_m - 1.0) as i64, (high / unit_m + 1.0) as i64);
    beside(west, eye.x) + beside(north, -eye.y) + squared_gap(low, high, eye.z)
}

/// What the selection takes the distance in metres to be.
fn distance_m(case: &Case, tile: TileId) -> f64 {
    (squared_units(case, tile) as f64).sqrt() * unit_m(case)
}

/// Whether a tile and the region's box, widened to whole units, share a point.
fn touches(region: &VisibleRegion, tile: TileId) -> bool {
    let FixedBox { min, max } = region.fixed_box(&SCHEME);
    let side = 1_i64 << (30 - tile.level);
    [(tile.column, 0), (tile.row, 1)].into_iter().all(|(index, axis)| {
        let first = i64::from(index) * side;
        (first..=first + side).contains(&i64::from(min[axis]))
            || (i64::from(min[axis])..=i64::from(max[axis])).contains(&first)
    })
}

/// Step 2, tile by tile: on the list is what exists, meets the region and has only split ancestors.
fn subdivided_by_hand(case: &Case) -> List {
    let mut list = List::from([TileId::ROOT]);
    let Some(region) = case.region else { return list };
    let texel_px = |tile: TileId| {
        let angle_rad = case.tree.texel_size_m(tile.level) / distance_m(case, tile);
        angle_rad / case.view.pixel_angle_rad()
    };
    let is_split = |tile: TileId| texel_px(tile) > case.config.texel_px;
    let is_there = |tile: TileId| case.tree.contains(tile) && touches(&region, tile);
    list.extend(all_tiles(&case.tree).filter(|tile| {
        (1..=tile.level)
            .all(|level| is_there(tile.ancestor_at(level)) && is_split(tile.ancestor_at(level - 1)))
    }));
    list
}

/// Whether no finest tile of any layer holds data on the tile's ground.
fn is_empty_by_hand(tree: &TileTree, tile: TileId) -> bool {
    let layers = [Some(&tree.heights), tree.colours.as_ref()];
    layers.into_iter().flatten().all(|layer| {
        let finest = layer.layout.finest_level();
        let holds = |t: &TileId| t.level == finest && (t.covers(tile) || tile.covers(*t));
        !layer.present.iter().any(|t| holds(&t))
    })
}

/// Step 3, as the paper has it, on a list as it came in.
fn regularized_by_hand(tree: &TileTree, list: &List) -> List {
    let is_redundant = |tile: TileId| {
        tile.level > 0
            && tile.level < tree.finest_level()
            && tile.children().iter().any(|child| list.contains(child))
            && tile
                .children()
                .iter()
                .all(|&child| list.contains(&child) || is_empty_by_hand(tree, child))
    };
    list.iter().copied().filter(|&tile| !is_redundant(tile)).collect()
}

/// Step 4, as the paper has it, searching the list anew for every merge.
fn merged_by_hand(case: &Case, mut list: List) -> (List, usize) {
    let mut merges = 0;
    while list.len() > case.config.max_tiles.max(1) {
        let farther = |a: &&TileId, b: &&TileId| {
            squared_units(case, **a).cmp(&squared_units(case, **b)).then(a.cmp(b))
        };
        let candidates = list.iter().filter(|tile| tile.level > 0);
        let parent = candidates.max_by(farther).and_then(|tile| tile.parent()).unwrap();
        for sibling in parent.children() {
            list.remove(&sibling);
        }
        list.insert(parent);
        list = regularized_by_hand(&case.tree, &list);
        merges += 1;
    }
    (list, merges)
}

fn listed(list: &TileList) -> List {
    let tiles: Vec<_> = list.tiles().collect();
    let set: List = tiles.iter().copied().collect();
    assert_eq!((tiles.len(), list.len()), (set.len(), set.len()), "a tile counted twice");
    set
}

fn eye_units(case: &Case) -> EyeUnits {
    EyeUnits::new(&case.tree, case.view.eye, case.config.vertical_exaggeration)
}

fn subdivided(case: &Case) -> TileList {
    let seen = case.region.as_ref().map(SeenGround::of_box);
    subdivide(&case.tree, seen, &case.view, &case.config)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn every_stage_agrees_with_the_same_by_hand(case in cases()) {
        let mut list = subdivided(&case);
        let by_hand = subdivided_by_hand(&case);
        prop_assert_eq!(&listed(&list), &by_hand, "subdivision");

        let removed = regularize(&mut list);
        let regular = regularized_by_hand(&case.tree, &by_hand);
        prop_assert_eq!(&listed(&list), &regular, "regularisation");
        prop_assert_eq!(removed, by_hand.len() - regular.len());

        let merges = merge_farthest(&mut list, case.config.max_tiles);
        let (merged, merges_by_hand) = merged_by_hand(&case, regular);
        prop_assert_eq!(&listed(&list), &merged, "merging");
        prop_assert_eq!(merges, merges_by_hand);
    }

    #[test]
    fn stages_work_on_lists_from_anywhere(
        case in cases(),
        picks in prop::collection::vec(any::<prop::sample::Index>(), 0..60),
    ) {
        let all: Vec<_> = all_tiles(&case.tree).collect();
        let tiles: Vec<_> = picks.iter().map(|pick| *pick.get(&all)).collect();
        let mut list = TileList::of_tiles(&case.tree, &eye_units(&case), &tiles);
        let mut by_hand: List = tiles.into_iter().filter(|&t| case.tree.contains(t)).collect();
        by_hand.insert(TileId::ROOT);
        prop_assert_eq!(&listed(&list), &by_hand);

        regularize(&mut list);
        by_hand = regularized_by_hand(&case.tree, &by_hand);
        prop_assert_eq!(&listed(&list), &by_hand, "regularisation");
        prop_assert_eq!(regularize(&mut list), 0, "regularisation is idempotent");

        merge_farthest(&mut list, case.config.max_tiles);
        prop_assert_eq!(&listed(&list), &merged_by_hand(&case, by_hand).0, "merging");
        prop_assert_eq!(regularize(&mut list), 0, "merging leaves a regular list");
    }

    #[test]
    fn each_layer_gets_the_finest_tiles_it_has(case in cases()) {
        let selection = case.select(Strategy::RttQuadtree);
        let by_hand = |layer: &LayerTree| {
            let mut tiles: Vec<TileId> = Vec::new();
            for tile in &selection.tiles {
                let finest = (0..=tile.level).rev().map(|level| tile.ancestor_at(level));
                let found = finest.into_iter().find(|&t| layer.present.iter().any(|p| p == t));
                tiles.extend(found.filter(|tile| !tiles.contains(tile)));
            }
            tiles
        };
        prop_assert_eq!(selection.height_tiles(&case.tree), by_hand(&case.tree.heights));
        let colours = case.tree.colours.as_ref().map(by_hand).unwrap_or_default();
        prop_assert_eq!(selection.colour_tiles(&case.tree), colours);
    }
}

#[test]
fn detail_falls_with_distance_and_the_budget_goes_to_the_nearest() {
    let case = low_over_the_middle(tree(1, 6, Some(6), 100), SelectionConfig::default());
    let selection = case.select(Strategy::RttQuadtree);
    assert!(selection.statistics.merges > 0 && selection.tiles.len() <= 36);
    let level_at = |point: DVec2| {
        let leaf = SCHEME.tile_at(5, point).unwrap();
        selection.tiles.iter().filter(|tile| tile.covers(leaf)).map(|tile| tile.level).max()
    };
    let root = SCHEME.root_extent();
    let levels: Vec<_> = [0.0, 0.2, 0.8]
        .map(|part| level_at(case.view.eye.truncate().lerp(root.max - 1.0, part)))
        .into_iter()
        .flatten()
        .collect();
    assert!(levels[0] == 5 && levels[1] < 5 && levels[2] <= 2, "{levels:?}");
}

#[test]
fn a_merge_can_make_a_grandparent_redundant() {
    let case = low_over_the_middle(tree(1, 4, None, 100), SelectionConfig::default());
    // Of the children of 1/0/0 three are listed, and one tile below the fourth, the farthest of all.
    let grandparent = TileId::new(1, 0, 0);
    let [fourth, others @ ..] = grandparent.children();
    let tiles: Vec<_> = others.into_iter().chain([grandparent, fourth.children()[0]]).collect();
    let mut list = TileList::of_tiles(&case.tree, &eye_units(&case), &tiles);
    assert_eq!((regularize(&mut list), list.len()), (0, 6));
    assert_eq!(merge_farthest(&mut list, 5), 1);
    let expected = others.into_iter().chain([TileId::ROOT, fourth]).collect();
    assert_eq!(listed(&list), expected, "1/0/0 went when the fourth child came");
}

#[test]
fn a_point_on_a_border_belongs_to_the_tiles_on_both_sides() {
    let mut case = low_over_the_middle(tree(1, 2, None, 100), SelectionConfig::default());
    let centre = SCHEME.root_extent().centre();
    case.region = Some(VisibleRegion::of_extent(&Extent::new(centre, centre)));
    let selection = case.select(Strategy::RttQuadtree);
    let tiles: List = selection.tiles.into_iter().collect();
    assert_eq!(tiles, [TileId::ROOT].into_iter().chain(TileId::ROOT.children()).collect());
}

#[test]
fn a_pyramid_of_the_deepest_level_is_descended_to_its_end() {
    let deepest = crate::tiling::MAX_LEVEL;
    let target = TileId::new(deepest, 7_654_321, 11_222_333);
    let mut present: TileSet = (0..=deepest).map(|level| target.ancestor_at(level)).collect();
    for level in 0..deepest {
        for child in target.ancestor_at(level).children() {
            present.insert(child);
        }
    }
    let layout = LayerLayout { tile_size_texels: 128, gutter_texels: 4, level_count: deepest + 1 };
    let heights = LayerTree { layout, present };
    let mut case = low_over_the_middle(tree(1, 1, None, 100), SelectionConfig::default());
    case.tree = TileTree { heights, height_ranges: height_ranges(1, 1), ..case.tree };
    case.config.max_tiles = 1_000;
    case.view.eye = SCHEME.tile_extent(target).centre().extend(1.0);
    let selection = case.select(Strategy::RttQuadtree);
    assert_eq!(selection.statistics.finest_level, deepest);
    assert!(selection.tiles.contains(&target));
    assert_eq!(check_order(&case, &selection), Ok(()));
}

#[test]
fn absurd_settings_end_within_bounds() {
    for texel_px in [0.0, -1.0, f64::NAN, f64::INFINITY, 1.0e-300] {
        let config = SelectionConfig { texel_px, ..SelectionConfig::default() };
        let case = low_over_the_middle(tree(3, 7, Some(10), 100), config);
        let selection = case.select(Strategy::RttQuadtree);
        assert!(!selection.tiles.is_empty() && selection.tiles.len() <= 36, "{texel_px}");
        assert!(selection.statistics.subdivided < (1 << 16) + 4, "{texel_px}");
    }
    let mut lost = low_over_the_middle(tree(3, 4, None, 100), SelectionConfig::default());
    lost.view.eye.x = f64::NAN;
    assert!(lost.select(Strategy::RttQuadtree).tiles.contains(&TileId::ROOT));
}
