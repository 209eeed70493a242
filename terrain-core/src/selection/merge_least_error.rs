use super::TileList;
use super::tile_list::{Child, Node};
use crate::tiling::TileId;

/// Instead of step 4 of the paper's tile selection: merging the tiles whose parent shows the smallest error
/// until at most `max_tiles` (0 is taken as 1) are on the list. Returns the number of merges.
///
/// The list must have been regularised by [`Shortening::LeastError`](super::Shortening::LeastError). While
/// it is too long:
/// 1. Of the tiles that were split, find the one with the smallest error: the size of its texel in pixels
///    at its nearest point, which is what [`subdivide()`](super::subdivide()) splits by.
/// 2. Take its children off the list; put it on, where it is not.
///
/// A tile's error is at least twice that of any of its children, so these have been merged before, and what
/// is left is the list that a larger `texel_px` would have given: one bound on the error for all. The
/// paper's way takes the farthest tiles instead, which are the coarsest already. Of equal errors the finest
/// tile goes first, and of those the one last by row and column.
///
/// A budget held by merging what costs the least: M. Duchaineau et al., "ROAMing Terrain: Real-time
/// Optimally Adapting Meshes", 1997.
pub(super) fn merge_least_error(list: &mut TileList, max_tiles: usize) -> usize {
    let max_tiles = max_tiles.max(1);
    if list.len() <= max_tiles {
        return 0;
    }
    let has_seen_children = |node: &Node| {
        node.children.into_iter().filter_map(Child::node).any(|child| !list.node(child).is_hidden)
    };
    let nodes = (0u32..).zip(list.nodes());
    let split = nodes.filter(|(_, node)| !node.is_hidden && has_seen_children(node));
    let mut queue =
        split.map(|(index, node)| (distance_in_texels(node), index)).collect::<Vec<_>>();
    queue.sort_unstable();
    let mut merges = 0;
    while list.len() > max_tiles
        && let Some((_, index)) = queue.pop()
    {
        for child in list.node(index).children.into_iter().filter_map(Child::node) {
            list.set_listed(child, false);
        }
        list.set_listed(index, true);
        merges += 1;
    }
    merges
}

/// The square of the distance counted in the tile's own texels, but for a factor all share: the reciprocal
/// of the error's square, exact. At most 2^112. At equal distance by level, row and column.
fn distance_in_texels(node: &Node) -> (u128, TileId) {
    (u128::from(node.distance) << (2 * node.tile.level), node.tile)
}
