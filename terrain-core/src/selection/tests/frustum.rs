//! The frustum's selection against brute force: every point in view by itself, and every split by itself.

use std::collections::BTreeMap;

use glam::dvec2;
use proptest::prelude::{ProptestConfig, prop_assert, prop_assert_eq, proptest};

use super::cases::{Case, SCHEME, cases, low_over_the_middle, tree};
use super::invariants::{check_order, finest_at};
use super::{List, sight, squared_units, unit_m};
use crate::CameraView;
use crate::selection::{SelectionConfig, Strategy, UnknownStrategy};
use crate::tiling::{Extent, TileId};

fn selected(case: &Case) -> List {
    case.select(Strategy::CpuFrustum).tiles.into_iter().collect()
}

fn without_limit(case: &Case) -> Case {
    let config = SelectionConfig { max_tiles: usize::MAX, ..case.config };
    Case { config, ..case.clone() }
}

/// Points of ground in view: over a grid of the root, at heights the finest box there allows.
fn seen_ground(case: &Case) -> Vec<(TileId, f64)> {
    let root = SCHEME.root_extent();
    let mut seen = Vec::new();
    for number in 0..64 * 64 {
        let part = dvec2(f64::from(number % 64) + 0.37, f64::from(number / 64) + 0.61) / 64.0;
        let place = root.min + part * root.size_m();
        let leaf = SCHEME.tile_at(case.tree.finest_level(), place);
        let Some((leaf, range)) = leaf.zip(leaf.and_then(|t| case.tree.height_ranges.range(t)))
        else {
            continue;
        };
        for height_m in [range.min_m, 0.5 * (range.min_m + range.max_m), range.max_m] {
            let point = place.extend(f64::from(height_m) * case.config.vertical_exaggeration);
            if sight::is_in_picture(&case.view, point) {
                seen.push((leaf, point.distance(case.view.eye)));
            }
        }
    }
    seen
}

/// Splits the tiles of the selection without a limit again, the largest error first, for as long as
/// the children of the next fit.
fn limited_by_hand(case: &Case) -> List {
    let mut children: BTreeMap<TileId, Vec<TileId>> = BTreeMap::new();
    for tile in selected(&without_limit(case)) {
        if let Some(parent) = tile.parent() {
            children.entry(parent).or_default().push(tile);
        }
    }
    // Squares of distances in texels, but for a factor: in the order of falling error.
    let in_texels =
        |tile: TileId| u128::from(squared_units(case, tile)) << (2 * u32::from(tile.level));
    let mut splits: Vec<_> = children.into_iter().collect();
    splits.sort_by_key(|(tile, _)| (in_texels(*tile), *tile));
    let mut list = List::from([TileId::ROOT]);
    for (_, children) in splits {
        if list.len() + children.len() > case.config.max_tiles.max(1) {
            break;
        }
        list.extend(children);
    }
    list
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn every_visible_texel_is_fine_enough(case in cases()) {
        let case = without_limit(&case);
        let set = selected(&case);
        for (leaf, distance_m) in seen_ground(&case) {
            let Some(drawn) = finest_at(&set, leaf) else { continue };
            // Eye and box are rounded to units.
            let texel_rad = case.tree.texel_size_m(drawn.level) / (distance_m + 4.0 * unit_m(&case));
            let texel_px = texel_rad / case.view.pixel_angle_rad();
            let has_finer = drawn.level < leaf.level
                && case.tree.contains(leaf.ancestor_at(drawn.level + 1));
            prop_assert!(
                texel_px <= case.config.texel_px * (1.0 + 1.0e-9) || !has_finer,
                "{} in the view of {} is {} px a texel", drawn, leaf, texel_px
            );
        }
    }

    #[test]
    fn a_limit_keeps_the_splits_of_the_largest_errors(case in cases()) {
        prop_assert_eq!(selected(&case), limited_by_hand(&case));
    }
}

#[test]
fn detail_falls_with_distance_and_what_is_behind_the_eye_stays_coarse() {
    let config = SelectionConfig { max_tiles: 64, ..SelectionConfig::default() };
    let case = low_over_the_middle(tree(1, 6, Some(6), 100), config);
    let set = selected(&case);
    let eye = case.view.eye.truncate();
    let levels = [100.0, 8_000.0, 29_000.0, -3_000.0].map(|north_m| {
        let leaf = SCHEME.tile_at(5, eye + dvec2(0.0, north_m));
        leaf.and_then(|leaf| finest_at(&set, leaf)).map_or(0, |tile| tile.level)
    });
    assert!(levels[0] == 5 && levels[1] < 5 && levels[2] < levels[1], "{levels:?}");
    assert!(levels[3] <= 1, "{levels:?}");
}

#[test]
fn ground_outside_the_data_is_not_seen() {
    let mut case = low_over_the_middle(tree(1, 5, None, 100), SelectionConfig::default());
    case.config.max_tiles = usize::MAX;
    let all = selected(&case);
    // Data only in the south, which lies behind the eye but for a strip of tiles that hold some of both.
    let root = SCHEME.root_extent();
    case.tree.data_extent = Extent::new(root.min, dvec2(root.max.x, case.view.eye.y - 50.0));
    assert!(all.len() > 30 && selected(&case) == List::from([TileId::ROOT]), "{}", all.len());
}

#[test]
fn the_sky_and_absurd_settings_are_states() {
    let mut case = low_over_the_middle(tree(3, 7, Some(10), 100), SelectionConfig::default());
    case.view.pitch_deg = 80.0;
    assert_eq!(selected(&case), List::from([TileId::ROOT]));
    case.view.pitch_deg = -10.0;
    for texel_px in [0.0, -1.0, f64::NAN, f64::INFINITY, 1.0e-300] {
        for max_tiles in [0, 36, usize::MAX] {
            case.config = SelectionConfig { max_tiles, texel_px, ..case.config };
            let selection = case.select(Strategy::CpuFrustum);
            let most = max_tiles.clamp(1, 1 << 16);
            assert!((1..=most).contains(&selection.tiles.len()), "{texel_px} {max_tiles}");
            assert_eq!(check_order(&case, &selection), Ok(()));
        }
    }
    case.view = CameraView { eye: glam::DVec3::NAN, ..case.view };
    assert_eq!(selected(&case), List::from([TileId::ROOT]));
}

#[test]
fn names_are_read_as_they_are_written() {
    for strategy in Strategy::ALL {
        assert_eq!(strategy.to_string().parse(), Ok(strategy));
        let json = serde_json::to_string(&strategy).unwrap();
        assert_eq!(json, format!("\"{strategy}\""));
    }
    let unknown = "guess".parse::<Strategy>();
    assert_eq!(unknown, Err(UnknownStrategy("guess".to_owned())));
    let told = unknown.map_err(|error| error.to_string());
    let expected = "there is no strategy \"guess\"; there are rtt-quadtree, rtt-quadtree-gpu, \
                    cpu-frustum, cpu-mesh, clipmap, page-table, texture-map";
    assert_eq!(told, Err(expected.to_owned()));
}
