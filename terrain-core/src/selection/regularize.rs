use super::TileList;

/// Step 3 of the paper's tile selection: regularisation. Returns how many tiles it took off the
/// list.
///
/// Liu Hao et al., "Dynamic Scheduling and Real-time Rendering Method for Large-Scale Terrain",
/// section 3.1: where a parent and all four of its children are on the list, the parent is never
/// sampled, since the finest tile is taken wherever tiles overlap; it is removed.
///
/// Departures: all tiles are judged by the list as it came in, so a tile taken off still counts as
/// its own parent's child (its ground is covered by its children in turn). A child without any data
/// counts as listed; one that only ends earlier in one of the layers does not. By
/// [`Shortening::LeastError`](super::Shortening::LeastError) children that are not in view count as listed
/// too. Level 0 stays: it is the ground that never has a hole.
pub fn regularize(list: &mut TileList) -> usize {
    let before = list.len();
    // Ancestors stand first: when a node is judged its descendants are still as they came in.
    for index in 1..list.nodes().len() as u32 {
        if list.node(index).is_listed && list.is_covered_by_children(index) {
            list.set_listed(index, false);
        }
    }
    before - list.len()
}
