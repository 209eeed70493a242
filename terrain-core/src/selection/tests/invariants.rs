//! What holds for every selection whatever the strategy, and what each strategy promises beyond it.

use glam::{DVec3, dvec2};
use proptest::prelude::{ProptestConfig, TestCaseError, prop_assert_eq, proptest};

use super::cases::{Case, SCHEME, cases};
use super::{
    List, distance_m, is_empty_by_hand, regularized_by_hand, sight, squared_units,
    subdivided_by_hand, touches,
};
use crate::selection::view_pyramid::WorldBox;
use crate::selection::{Selection, Strategy, VisibleRegion};
use crate::tiling::TileId;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn every_strategy_keeps_the_invariants(case in cases()) {
        for strategy in Strategy::ALL {
            let check = match strategy {
                Strategy::RttQuadtree | Strategy::RttQuadtreeGpu => check_scheduled,
                Strategy::CpuFrustum | Strategy::CpuMesh => check_by_frustum,
                Strategy::Clipmap | Strategy::PageTable | Strategy::TextureMap => continue,
            };
            let selection = case.select(strategy);
            check_common(&case, &selection).and_then(|()| check(&case, &selection)).map_err(
                |reason| TestCaseError::fail(format!("{strategy}: {reason}: {selection:?}")),
            )?;
            prop_assert_eq!(&case.select(strategy), &selection, "{} is not deterministic", strategy);
        }
    }
}

type Checked = Result<(), String>;

fn require(holds: bool, what: &str) -> Checked {
    if holds { Ok(()) } else { Err(what.to_owned()) }
}

fn set_of(selection: &Selection) -> List {
    selection.tiles.iter().copied().collect()
}

/// What holds for all strategies. Since level 0 is on the list and no tile twice, every point has one
/// finest tile: that is the disjoint cover.
fn check_common(case: &Case, selection: &Selection) -> Checked {
    let set = set_of(selection);
    require(set.len() == selection.tiles.len(), "a tile twice")?;
    require(selection.tiles.first() == Some(&TileId::ROOT), "level 0 is not the first")?;
    require(set.len() <= case.config.max_tiles.max(1), "more than MaxofTiles")?;
    let exist = set.iter().all(|&tile| tile.level == 0 || case.tree.contains(tile));
    require(exist, "a tile that does not exist")?;
    check_order(case, selection)?;
    let finest = set.iter().map(|tile| tile.level).max();
    require(finest == Some(selection.statistics.finest_level), "a wrong finest level")
}

/// Coarsest level first, within a level nearest first.
pub fn check_order(case: &Case, selection: &Selection) -> Checked {
    let priority = |tile: &TileId| (tile.level, squared_units(case, *tile));
    let in_order = selection.tiles.windows(2).all(|pair| priority(&pair[0]) <= priority(&pair[1]));
    require(in_order, "not in order of priority")
}

/// `rtt-quadtree`: no parent beside its four children; within the region, and all of it covered.
fn check_scheduled(case: &Case, selection: &Selection) -> Checked {
    let set = set_of(selection);
    let is_regular = regularized_by_hand(&case.tree, &set) == set;
    require(is_regular, "a parent beside its four children")?;
    let Some(region) = &case.region else {
        return require(set.len() == 1, "more than level 0 for an empty view");
    };
    let meets = |tile: &TileId| touches(region, *tile);
    require(set.iter().all(|tile| tile.level == 0 || meets(tile)), "a tile out of the region")?;
    check_cover(case, selection, region)
}

/// Within the region every point is drawn with the finest tile that subdivision gave it, or where
/// tiles were merged with a coarser one.
fn check_cover(case: &Case, selection: &Selection, region: &VisibleRegion) -> Checked {
    let (set, wanted) = (set_of(selection), subdivided_by_hand(case));
    let extent = region.extent();
    for number in 0..64 {
        let part = dvec2(f64::from(number % 8) + 0.5, f64::from(number / 8) + 0.5) / 8.0;
        let point = extent.min + part * extent.size_m();
        let Some(leaf) = SCHEME.tile_at(case.tree.finest_level(), point) else { continue };
        if is_empty_by_hand(&case.tree, leaf) {
            continue;
        }
        let (Some(drawn), Some(wanted)) = (finest_at(&set, leaf), finest_at(&wanted, leaf)) else {
            return Err(format!("nothing covers {point}"));
        };
        if drawn.level > wanted.level || (selection.statistics.merges == 0 && drawn != wanted) {
            return Err(format!("{point} is drawn with {drawn} instead of {wanted}"));
        }
    }
    Ok(())
}

/// The finest tile of the list that covers `leaf`.
pub fn finest_at(list: &List, leaf: TileId) -> Option<TileId> {
    (0..=leaf.level).rev().map(|level| leaf.ancestor_at(level)).find(|tile| list.contains(tile))
}

/// `cpu-frustum`: parents stay beside their children, all of them, so every tile's ancestors are on the
/// list; every tile but level 0 meets the frustum with its own box, and none was split needlessly.
fn check_by_frustum(case: &Case, selection: &Selection) -> Checked {
    let set = set_of(selection);
    for tile in &selection.tiles {
        let Some(parent) = tile.parent() else { continue };
        require(set.contains(&parent), "a tile without its parent")?;
        let distance_m = distance_m(case, parent);
        let texel_rad = case.tree.texel_size_m(parent.level) / distance_m;
        let texel_px = texel_rad / case.view.pixel_angle_rad();
        require(texel_px > case.config.texel_px * (1.0 - 1.0e-9), "split though fine enough")?;
        let is_seen = sight::is_seen(&case.view, &box_of(case, *tile), 1.0e-6);
        require(is_seen, "a tile out of the frustum")?;
    }
    Ok(())
}

/// The box of a tile's ground; all of the root holds data.
fn box_of(case: &Case, tile: TileId) -> WorldBox {
    let extent = SCHEME.tile_extent(tile);
    let factor = case.config.vertical_exaggeration;
    let [low_m, high_m] =
        case.tree.height_ranges.range(tile).map_or([f64::NAN; 2], |r| {
            [r.min_m, r.max_m].map(|height_m| f64::from(height_m) * factor)
        });
    WorldBox {
        min: DVec3::new(extent.min.x, extent.min.y, low_m),
        max: DVec3::new(extent.max.x, extent.max.y, high_m),
    }
}
