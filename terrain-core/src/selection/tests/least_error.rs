//! Shortening by the least error against the same by hand: what of the subdivided list shows when the splits
//! of least error are undone one by one.

use proptest::prelude::{ProptestConfig, prop_assert, prop_assert_eq, proptest};

use super::cases::{Case, SCHEME, cases};
use super::invariants::finest_at;
use super::{List, is_empty_by_hand, squared_units, subdivided_by_hand, touches};
use crate::selection::{SelectionConfig, Shortening, Strategy};
use crate::tiling::TileId;

/// The tiles of the list that some ground in view is drawn with, and level 0.
fn shown_by_hand(case: &Case, list: &List) -> List {
    let is_in_view = |tile: TileId| case.region.is_some_and(|region| touches(&region, tile));
    let is_hidden_by = |child: TileId| {
        list.contains(&child) || is_empty_by_hand(&case.tree, child) || {
            case.tree.contains(child) && !is_in_view(child)
        }
    };
    let shows = |tile: &TileId| {
        let is_split = tile.level < case.tree.finest_level()
            && tile.children().iter().any(|child| list.contains(child));
        tile.level == 0 || !is_split || !tile.children().into_iter().all(is_hidden_by)
    };
    list.iter().copied().filter(shows).collect()
}

/// The list for the case and how many splits were undone.
fn shortened_by_hand(case: &Case) -> (List, usize) {
    let mut list = subdivided_by_hand(case);
    let mut undone = 0;
    loop {
        let shown = shown_by_hand(case, &list);
        if shown.len() <= case.config.max_tiles.max(1) {
            return (shown, undone);
        }
        let is_split = |tile: &&TileId| list.iter().any(|other| other.parent() == Some(**tile));
        let in_texels =
            |tile: TileId| u128::from(squared_units(case, tile)) << (2 * u32::from(tile.level));
        let split = list.iter().filter(is_split);
        let least = *split.max_by_key(|tile| (in_texels(**tile), **tile)).unwrap();
        list.retain(|tile| tile.level <= least.level || !least.covers(*tile));
        undone += 1;
    }
}

fn by_least_error(case: Case) -> Case {
    let config = SelectionConfig { shortening: Shortening::LeastError, ..case.config };
    Case { config, ..case }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn what_is_left_is_what_shows_when_the_least_splits_are_undone(case in cases()) {
        let case = by_least_error(case);
        let selection = case.select(Strategy::RttQuadtree);
        let (expected, undone) = shortened_by_hand(&case);
        prop_assert_eq!(selection.tiles.iter().copied().collect::<List>(), expected);
        prop_assert_eq!(selection.statistics.merges, undone);
    }

    #[test]
    fn where_all_fit_every_point_in_view_is_drawn_as_by_the_paper(case in cases()) {
        let config = SelectionConfig { max_tiles: 100_000, ..case.config };
        let paper = Case { config, ..case };
        let all = paper.select(Strategy::RttQuadtree).tiles.into_iter().collect::<List>();
        let by_error = by_least_error(paper);
        let shown = by_error.select(Strategy::RttQuadtree).tiles.into_iter().collect::<List>();
        prop_assert!(shown.is_subset(&all), "{:?} is not of {:?}", shown, all);
        let Some(region) = by_error.region else { return Ok(()) };
        let finest = by_error.tree.finest_level();
        let extent = region.extent();
        for number in 0..64 {
            let part = glam::dvec2(f64::from(number % 8), f64::from(number / 8)) / 7.0;
            let point = extent.min + part * extent.size_m();
            let leaf = SCHEME.tile_at(finest, point);
            if let Some(leaf) = leaf.filter(|leaf| !is_empty_by_hand(&by_error.tree, *leaf)) {
                prop_assert_eq!(finest_at(&shown, leaf), finest_at(&all, leaf));
            }
        }
    }
}
