use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::TileList;
use super::tile_list::{Child, Node};
use crate::tiling::TileId;

/// Step 4 of the paper's tile selection: merging the farthest tile until at most `max_tiles` (the
/// paper's MaxofTiles; 0 is taken as 1) are on the list. Returns the number of merges.
///
/// Liu Hao et al., "Dynamic Scheduling and Real-time Rendering Method for Large-Scale Terrain",
/// section 3.1. While the list is too long:
/// 1. Find the tile farthest from the eye; level 0 takes no part.
/// 2. Take it and those of its siblings that are on the list (none to three) off the list.
/// 3. Put their parent on the list, where it is not.
/// 4. Regularise.
///
/// It ends: a merge never makes the list longer, and puts a coarser tile in the place of finer ones.
///
/// Departures: of tiles equally far the finest goes first, and of those the one last by row and
/// column, so that the outcome is determined. Step 4 looks at the one tile the merge can have made
/// redundant, the parent of the tile put on the list, with the same outcome as
/// [`regularize`](super::regularize) on the whole of a list that was regularised before.
pub fn merge_farthest(list: &mut TileList, max_tiles: usize) -> usize {
    let max_tiles = max_tiles.max(1);
    if list.len() <= max_tiles {
        return 0;
    }
    let mut merges = 0;
    let mut farthest: BinaryHeap<Candidate> = (0u32..)
        .zip(list.nodes())
        .skip(1)
        .filter(|(_, node)| node.is_listed)
        .map(|(index, node)| Candidate::new(index, node))
        .collect();
    while list.len() > max_tiles {
        // Every listed tile but the root is in the heap, so it lasts as long as there is one.
        let Some(candidate) = farthest.pop() else { break };
        if !list.node(candidate.index).is_listed {
            continue; // left the list after it came into the heap
        }
        let parent = list.node(candidate.index).parent;
        if replace_by_parent(list, parent) {
            farthest.push(Candidate::new(parent, list.node(parent)));
        }
        merges += 1;
    }
    merges
}

/// Takes the children of `parent` off the list, puts it on and regularises; returns whether it came
/// on the list anew and takes part in further merges.
fn replace_by_parent(list: &mut TileList, parent: u32) -> bool {
    for child in list.node(parent).children {
        if let Child::Node(child) = child {
            list.set_listed(child, false);
        }
    }
    if list.node(parent).is_listed {
        return false;
    }
    list.set_listed(parent, true);
    let grandparent = list.node(parent).parent;
    if list.node(grandparent).is_listed && list.is_covered_by_children(grandparent) {
        list.set_listed(grandparent, false);
    }
    true
}

/// A tile that may be merged away; the greatest is the next to go.
struct Candidate {
    distance_m: f64,
    tile: TileId,
    index: u32,
}

impl Candidate {
    fn new(index: u32, node: &Node) -> Self {
        Self { distance_m: node.distance_m, tile: node.tile, index }
    }
}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        self.distance_m.total_cmp(&other.distance_m).then(self.tile.cmp(&other.tile))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Candidate {}
