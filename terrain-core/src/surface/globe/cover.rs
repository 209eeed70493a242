use std::cmp::Ordering;
use std::collections::{BinaryHeap, HashMap, HashSet};

use super::ground::GlobeGround;
use super::patch::CELLS_A_SIDE;
use super::patch_id::{PatchEdge, PatchId};
use super::patch_store::PatchStore;
use super::sight::GlobeSight;

/// What a cover is made to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoverSettings {
    /// A patch is split while its cells are seen larger than this many pixels,
    pub cell_px: f64,
    /// or their middle may be seen so many pixels off the curve of the globe.
    pub curve_px: f64,
    /// Most triangles in view.
    pub most_triangles: usize,
    /// Most patches that may be made anew; those that the least cover needs are.
    pub most_made: usize,
}

/// A patch to draw.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CoveredPatch {
    /// Which.
    pub id: PatchId,
    /// Bit n: behind the n-th of [`PatchEdge::ALL`] the mesh is coarser.
    pub coarse_edges: u8,
}

/// Patches that together show all of the globe that is in view.
pub struct GlobeCover {
    /// The nearest first.
    pub patches: Vec<CoveredPatch>,
    /// Whether more patches would have been made than were allowed: another cover of the view is finer.
    pub is_unfinished: bool,
    /// All patches that the globe is cut into, those out of view as well.
    #[cfg(test)]
    pub(super) all: Vec<PatchId>,
}

/// Cuts the globe into patches for a view: from whole faces on, the patch whose cells are seen largest, or farthest off the curve, is split, and
/// before it those neighbours that would differ by more than a level. Patches out of view stay as they are. The same
/// whatever was seen before, once it is finished.
pub fn cover(
    store: &mut PatchStore,
    ground: &GlobeGround,
    sight: &GlobeSight,
    settings: &CoverSettings,
) -> GlobeCover {
    store.begin();
    let mut cutting = Cutting {
        store,
        ground,
        sight,
        settings,
        made: 0,
        split: HashSet::new(),
        leaves: HashMap::new(),
        visible: 0,
        queue: BinaryHeap::new(),
        is_unfinished: false,
    };
    for face in PatchId::faces() {
        cutting.add(face);
    }
    while let Some(next) = cutting.queue.pop() {
        let is_leaf = cutting.leaves.contains_key(&next.id);
        if is_leaf && !cutting.try_split(next.id) {
            break;
        }
    }
    cutting.finish()
}

struct Cutting<'a> {
    store: &'a mut PatchStore,
    ground: &'a GlobeGround,
    sight: &'a GlobeSight,
    settings: &'a CoverSettings,
    made: usize,
    split: HashSet<PatchId>,
    /// The patches there are, and the error of those in view.
    leaves: HashMap<PatchId, Option<f64>>,
    visible: usize,
    queue: BinaryHeap<Coarse>,
    is_unfinished: bool,
}

/// A patch in view that is too coarse, in the order of its error.
struct Coarse {
    /// In parts of what is allowed.
    error: f64,
    id: PatchId,
}

impl Cutting<'_> {
    const TRIANGLES_A_PATCH: usize = 2 * (CELLS_A_SIDE * CELLS_A_SIDE) as usize;

    /// Adds a patch to those there are.
    fn add(&mut self, id: PatchId) {
        self.made += usize::from(!self.store.has(id));
        let (patch, _) = self.store.get(id, self.ground);
        let CoverSettings { cell_px, curve_px, .. } = *self.settings;
        let error = |patch| {
            let by_size = self.sight.cell_px(patch) / cell_px;
            by_size.max(self.sight.curve_px(patch) / curve_px)
        };
        let error = self.sight.sees(patch).then(|| error(patch));
        self.leaves.insert(id, error);
        let Some(error) = error else { return };
        self.visible += 1;
        if error > 1.0 && id.level < PatchId::FINEST_LEVEL {
            self.queue.push(Coarse { error, id });
        }
    }

    /// Splits a patch, before it what must be; returns whether it could be done within the limits. What was split
    /// before a limit was met stays so.
    fn try_split(&mut self, id: PatchId) -> bool {
        if self.split.contains(&id) {
            return true;
        }
        for edge in PatchEdge::ALL {
            let parent = id.neighbour(edge).parent();
            if parent.is_some_and(|parent| !self.try_split(parent)) {
                return false;
            }
        }
        let children = id.children();
        let is_in_view = self.leaves.get(&id).copied().flatten().is_some();
        let others = self.visible - usize::from(is_in_view);
        if (others + children.len()) * Self::TRIANGLES_A_PATCH > self.settings.most_triangles {
            return false;
        }
        let to_make = children.iter().filter(|&&child| !self.store.has(child)).count();
        if to_make > 0 && self.made + to_make > self.settings.most_made {
            self.is_unfinished = true;
            return false;
        }
        self.leaves.remove(&id);
        self.visible = others;
        self.split.insert(id);
        for child in children {
            self.add(child);
        }
        true
    }

    fn finish(self) -> GlobeCover {
        let mut seen: Vec<_> =
            self.leaves.iter().filter_map(|(&id, error)| Some(((*error)?, id))).collect();
        // Cells of near patches are seen about as large as those of far ones: the finest are the nearest.
        seen.sort_unstable_by(|a, b| {
            b.1.level.cmp(&a.1.level).then(b.0.total_cmp(&a.0)).then(a.1.cmp(&b.1))
        });
        let is_coarser = |id: PatchId, edge| {
            let parent = id.neighbour(edge).parent();
            parent.is_some_and(|parent| !self.split.contains(&parent))
        };
        let patches = seen.into_iter().map(|(_, id)| {
            let bits =
                (0..).zip(PatchEdge::ALL).map(|(bit, edge)| u8::from(is_coarser(id, edge)) << bit);
            CoveredPatch { id, coarse_edges: bits.sum() }
        });
        GlobeCover {
            patches: patches.collect(),
            is_unfinished: self.is_unfinished,
            #[cfg(test)]
            all: self.leaves.keys().copied().collect(),
        }
    }
}

impl Ord for Coarse {
    fn cmp(&self, other: &Self) -> Ordering {
        self.error.total_cmp(&other.error).then(other.id.cmp(&self.id))
    }
}

impl PartialOrd for Coarse {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Coarse {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Coarse {}
