use super::eye_units::EyeUnits;
use super::sort_keys::PriorityOrder;
use super::{Shortening, TileTree};
use crate::tiling::TileId;

/// The paper's list of chosen tiles, kept as the part of the quadtree it was chosen from.
///
/// Every tile on the list has all its ancestors in the arena, listed or not, so that the stages
/// find parents, siblings and children by index instead of by search. Level 0 is always listed.
#[derive(Clone, Debug)]
pub struct TileList {
    /// Ancestors stand before their descendants; the root is node 0.
    nodes: Vec<Node>,
    listed: usize,
    hidden: usize,
    shortening: Shortening,
}

/// One tile of the list's quadtree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    pub tile: TileId,
    /// Squared distance from the eye in units, as [`TileTree::squared_distance`] has it; at least the
    /// parent's, whose ground holds the tile's.
    pub distance: u64,
    /// Index of the parent; the root's own for the root.
    pub parent: u32,
    /// The children in the order of [`TileId::children`].
    pub children: [Child; 4],
    pub is_listed: bool,
    /// In the box round what was seen but not seen itself: never on the list, nor what is below it.
    pub is_hidden: bool,
}

/// What a list knows of a tile's child: its node, or why there is none. Four bytes, so that a whole
/// list of a thousand tiles stays in the processor's nearest cache.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Child(u32);

impl Child {
    /// Never considered: its parent was not split, or a coarser tile holds its ground's data.
    pub const UNKNOWN: Self = Self(u32::MAX);
    /// There is no data there in any layer, at any level: nothing is missing without it.
    pub const EMPTY: Self = Self(u32::MAX - 1);
    /// Outside the region.
    pub const OUT_OF_VIEW: Self = Self(u32::MAX - 2);

    /// Index of the child's node, where there is one.
    pub fn node(self) -> Option<u32> {
        (self.0 < Self::OUT_OF_VIEW.0).then_some(self.0)
    }
}

impl TileList {
    /// Index of the root's node.
    pub(super) const ROOT: u32 = 0;

    /// The list that holds level 0 alone.
    pub(super) fn new(tree: &TileTree, eye: &EyeUnits, shortening: Shortening) -> Self {
        let root = Node {
            tile: TileId::ROOT,
            distance: tree.squared_distance(TileId::ROOT, eye),
            parent: Self::ROOT,
            children: [Child::UNKNOWN; 4],
            is_listed: true,
            is_hidden: false,
        };
        Self { nodes: vec![root], listed: 1, hidden: 0, shortening }
    }

    /// The list of level 0 and these tiles. Tiles that do not exist are left out.
    #[cfg(test)]
    pub(super) fn of_tiles(tree: &TileTree, eye: &EyeUnits, tiles: &[TileId]) -> Self {
        let mut list = Self::new(tree, eye, Shortening::Farthest);
        for &tile in tiles.iter().filter(|&&tile| tree.contains(tile)) {
            let mut node = Self::ROOT;
            for level in 1..=tile.level {
                node = list.child_node(tree, node, tile.ancestor_at(level), eye);
            }
            list.set_listed(node, true);
        }
        list
    }

    /// Number of tiles on the list, level 0 counted.
    pub fn len(&self) -> usize {
        self.listed
    }

    /// Number of tiles that only the box round what was seen would have brought on the list.
    pub fn hidden(&self) -> usize {
        self.hidden
    }

    /// Never: level 0 is always on the list.
    pub fn is_empty(&self) -> bool {
        self.listed == 0
    }

    /// The tiles on the list; level 0 first, every tile after its ancestors.
    pub fn tiles(&self) -> impl Iterator<Item = TileId> + '_ {
        self.nodes.iter().filter(|node| node.is_listed).map(|node| node.tile)
    }

    /// The tiles on the list by priority, not yet sorted.
    pub(super) fn priorities(&self) -> Vec<PriorityOrder> {
        let listed = self.nodes.iter().filter(|node| node.is_listed);
        listed.map(|node| PriorityOrder::new(node.distance, node.tile)).collect()
    }

    pub(super) fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    pub(super) fn node(&self, index: u32) -> &Node {
        &self.nodes[index as usize]
    }

    pub(super) fn set_child(&mut self, parent: u32, quadrant: usize, child: Child) {
        self.nodes[parent as usize].children[quadrant] = child;
    }

    /// Adds a node for a child of `parent`, not yet on the list.
    pub(super) fn add_child(&mut self, parent: u32, tile: TileId, distance: u64) -> u32 {
        let index = self.nodes.len() as u32;
        self.nodes.push(Node {
            tile,
            distance: distance.max(self.node(parent).distance),
            parent,
            children: [Child::UNKNOWN; 4],
            is_listed: false,
            is_hidden: false,
        });
        self.set_child(parent, tile.quadrant() as usize, Child(index));
        index
    }

    /// Keeps a tile that is not on the list from ever being on it.
    pub(super) fn hide(&mut self, index: u32) {
        self.nodes[index as usize].is_hidden = true;
        self.hidden += 1;
    }

    /// Puts a tile on the list or takes it off. The root stays whatever is asked.
    pub(super) fn set_listed(&mut self, index: u32, is_listed: bool) {
        let node = &mut self.nodes[index as usize];
        if index == Self::ROOT || node.is_listed == is_listed {
            return;
        }
        node.is_listed = is_listed;
        self.listed = if is_listed { self.listed + 1 } else { self.listed - 1 };
    }

    /// Whether all four children are on the list, where those without any data count as listed, and by
    /// [`Shortening::LeastError`] those out of view as well; at least one of them has to be listed.
    pub(super) fn is_covered_by_children(&self, index: u32) -> bool {
        let children = self.node(index).children;
        let counts_unseen = self.shortening == Shortening::LeastError;
        let is_listed = |child: Child| child.node().is_some_and(|node| self.node(node).is_listed);
        let is_unseen = |child: Child| match child.node() {
            Some(node) => self.node(node).is_hidden,
            None => child == Child::OUT_OF_VIEW,
        };
        let is_covered = |child: Child| {
            is_listed(child) || child == Child::EMPTY || counts_unseen && is_unseen(child)
        };
        children.into_iter().all(is_covered) && children.into_iter().any(is_listed)
    }

    /// The node of `tile`, a child of `parent`'s tile, added together with what is known of its
    /// siblings where it is new.
    #[cfg(test)]
    fn child_node(&mut self, tree: &TileTree, parent: u32, tile: TileId, eye: &EyeUnits) -> u32 {
        if let Some(node) = self.node(parent).children[tile.quadrant() as usize].node() {
            return node;
        }
        for (quadrant, sibling) in self.node(parent).tile.children().into_iter().enumerate() {
            if tree.is_empty_ground(sibling) {
                self.set_child(parent, quadrant, Child::EMPTY);
            }
        }
        self.add_child(parent, tile, tree.squared_distance(tile, eye))
    }
}
