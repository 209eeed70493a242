use std::collections::BTreeSet;

use super::eye_units::EyeUnits;
use super::{
    Selection, SelectionConfig, SelectionStatistics, TileList, TileTree, merge_farthest, regularize,
};
use crate::CameraView;
use crate::tiling::TileId;

/// The selection for a view whose tiles are known: these tiles, and above each of them its ancestors as far as
/// four children do not stand in for them, so that what lies beside is one level coarser and not the coarsest
/// there is. Of more than [`SelectionConfig::max_tiles`] the farthest are merged.
pub(crate) fn select_listed(
    tree: &TileTree,
    tiles: impl IntoIterator<Item = TileId>,
    view: &CameraView,
    config: &SelectionConfig,
) -> Selection {
    let ancestors = |tile| std::iter::successors(Some(tile), |tile: &TileId| tile.parent());
    let tiles = tiles.into_iter().flat_map(ancestors).collect::<BTreeSet<_>>();
    let tiles = tiles.into_iter().collect::<Vec<_>>();
    let eye = EyeUnits::new(tree, view.eye, config.vertical_exaggeration);
    let mut list = TileList::of_tiles(tree, &eye, &tiles);
    let subdivided = list.len();
    let regularized_away = regularize(&mut list);
    let merges = merge_farthest(&mut list, config.max_tiles);
    let statistics =
        SelectionStatistics { subdivided, regularized_away, merges, ..Default::default() };
    Selection::in_order(list.priorities(), statistics)
}
