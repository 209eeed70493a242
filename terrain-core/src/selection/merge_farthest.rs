use std::collections::BinaryHeap;

use super::TileList;
use super::sort_keys::FarthestOrder;
use super::tile_list::{Child, Node};

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
/// [`regularize()`](super::regularize()) on the whole of a list that was regularised before.
pub fn merge_farthest(list: &mut TileList, max_tiles: usize) -> usize {
    let max_tiles = max_tiles.max(1);
    if list.len() <= max_tiles {
        return 0;
    }
    let mut merges = 0;
    let mut queue = FarthestFirst::new(list, list.len() - max_tiles);
    while list.len() > max_tiles {
        // Every listed tile but the root has its siblings' farthest or itself in the queue, so it
        // lasts as long as there is one.
        let Some(candidate) = queue.pop() else { break };
        let parent = list.node(candidate.index).parent;
        if !list.node(candidate.index).is_listed {
            // Left the list after it came into the queue; some of its siblings may have stayed.
            queue.returned.extend(farthest_child(list, parent));
            continue;
        }
        if replace_by_parent(list, parent) {
            queue.returned.push(Candidate::new(parent, list.node(parent)));
        }
        merges += 1;
    }
    merges
}

/// The one of a tile's listed children that goes first.
fn farthest_child(list: &TileList, parent: u32) -> Option<Candidate> {
    let children = list.node(parent).children.into_iter().filter_map(Child::node);
    let listed = children.filter(|&child| list.node(child).is_listed);
    listed.map(|child| Candidate::new(child, list.node(child))).max()
}

/// Takes the children of `parent` off the list, puts it on and regularises; returns whether it came
/// on the list anew and takes part in further merges.
fn replace_by_parent(list: &mut TileList, parent: u32) -> bool {
    for child in list.node(parent).children.into_iter().filter_map(Child::node) {
        list.set_listed(child, false);
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

/// The tiles of a list but the root, farthest first.
///
/// Of siblings only the farthest is kept: the others leave the list together with it. Sorting a part
/// of them once is faster than a heap of all: most merges take tiles that were on the list from the
/// beginning, and only as many as the list is too long by.
struct FarthestFirst {
    /// Nearer than all of `sorted`, in no order.
    rest: Vec<Candidate>,
    /// Farthest last.
    sorted: Vec<Candidate>,
    /// Tiles that came after: parents that merging put on the list, siblings of tiles that left it.
    returned: BinaryHeap<Candidate>,
}

impl FarthestFirst {
    /// `excess`: by how many the list is too long.
    fn new(list: &TileList, excess: usize) -> Self {
        let mut rest: Vec<Candidate> = Vec::with_capacity(list.len() / 2);
        let mut last_parent = None;
        for (index, node) in (0u32..).zip(list.nodes()).skip(1).filter(|(_, node)| node.is_listed) {
            let candidate = Candidate::new(index, node);
            match rest.last_mut() {
                // Siblings mostly stand side by side; where they do not, one more is no harm.
                Some(sibling) if last_parent == Some(node.parent) => {
                    if candidate > *sibling {
                        *sibling = candidate;
                    }
                }
                _ => rest.push(candidate),
            }
            last_parent = Some(node.parent);
        }
        let mut queue = Self { rest, sorted: Vec::new(), returned: BinaryHeap::new() };
        // Four siblings make one parent: a merge makes the list shorter by three.
        queue.sort_farthest(excess / 3 + 1);
        queue
    }

    /// Moves the farthest `count` of the rest to the sorted ones, which must have run out.
    fn sort_farthest(&mut self, count: usize) {
        if count < self.rest.len() {
            let nearest = self.rest.len() - count;
            self.rest.select_nth_unstable(nearest);
            self.sorted = self.rest.split_off(nearest);
        } else {
            self.sorted = std::mem::take(&mut self.rest);
        }
        self.sorted.sort_unstable();
    }

    fn pop(&mut self) -> Option<Candidate> {
        if self.sorted.is_empty() {
            self.sort_farthest(self.rest.len());
        }
        if self.returned.peek() > self.sorted.last() {
            self.returned.pop()
        } else {
            self.sorted.pop()
        }
    }
}

/// A tile that may be merged away; the greatest is the next to go.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Candidate {
    order: FarthestOrder,
    index: u32,
}

impl Candidate {
    fn new(index: u32, node: &Node) -> Self {
        Self { order: FarthestOrder::new(node.distance, node.tile), index }
    }
}
