//! A triangulation of the ground made for the view, kept on the CPU and changed a little every frame.
//!
//! The root square is cut into right isosceles triangles, again and again at the middle of their longest
//! edge, where the ground in them would else look too far off. Two triangles that share their longest
//! edge are cut together, so that no vertex ever lies on another triangle's edge: there are no cracks
//! and no T-junctions. [`ViewMesh::refine`] starts from the last frame's mesh, cuts where the error in
//! pixels exceeds a tolerance and joins where it has fallen well below, and tells which vertices and
//! triangles have changed, so that nothing else need be sent.
//!
//! Sources. Right triangles cut by screen-space error: P. Lindstrom et al., "Real-Time, Continuous Level
//! of Detail Rendering of Height Fields", 1996. Cuts and joins carried from frame to frame, the worst
//! first: M. Duchaineau et al., "ROAMing Terrain: Real-time Optimally Adapting Meshes", 1997. Errors by
//! the ground itself, in the view only, changes sent alone: H. Hoppe, "Smooth View-Dependent
//! Level-of-Detail Control and its Application to Terrain Rendering", 1998. Balls as bounds: P.
//! Lindstrom and V. Pascucci, "Terrain Simplification Simplified", 2002.
//!
//! Departures. Errors are no sums of bounds but measured: the largest distance of the ground from the
//! triangle at any sample in it, found when a tile is loaded. They need not grow with the triangle then,
//! since cuts that are forced keep the mesh whole, not nested errors. There are no queues kept from frame
//! to frame: looking at every leaf costs less than to keep them in order. Vertices do not glide to their
//! places (geomorphs): each step is smaller than the tolerance, and a gliding vertex would be sent every
//! frame. Heights come in tiles of a pyramid: the finest tile in use gives the heights of its ground, and
//! triangles never reach across it. What leaves the view stays as it is until it is far enough away or
//! room is needed.

mod bisection;
mod height_patch;
mod indexed_list;
mod patch_errors;
mod patches;
mod refine;
mod right_triangle;
mod sight;
#[cfg(test)]
mod tests;
mod vertices;

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DVec2, DVec3, IVec2};

use self::bisection::{Bisection, NONE};
pub use self::height_patch::{GroundSample, HeightPatch, PatchFrame};
use self::indexed_list::{ChangedIds, IndexedList};
use self::patches::UsedPatch;
pub use self::refine::{RefineSettings, Refined};
use self::right_triangle::RightTriangle;
use self::sight::Bounds;
pub use self::sight::Sight;
use self::vertices::Vertices;
pub use self::vertices::ViewVertex;
use crate::tiling::{FIXED_UNITS_PER_ROOT, TileId};

/// The mesh; see the module's page.
pub struct ViewMesh {
    frame: PatchFrame,
    vertical_exaggeration: f64,
    /// The data's extent in fixed-point units: north-west and south-east corner.
    data_units: [DVec2; 2],
    patches: HashMap<TileId, UsedPatch>,
    bisection: Bisection,
    vertices: Vertices,
    /// Of each triangle its ball and error, and the level of the finest patch that holds it.
    bounds: Vec<Bounds>,
    patch_levels: Vec<u8>,
    /// The triangles that are drawn. Their places are those they have on the GPU.
    leaves: IndexedList,
    /// Pairs that can be joined, by their names.
    joinable: IndexedList,
    changed_places: ChangedIds,
    /// Triangles made since they were last looked at.
    fresh: Vec<u32>,
    /// Factor on the tolerance that keeps the mesh within its size.
    coarsening: f64,
    /// What the last refinement was made for.
    refined_for: Option<(Sight, RefineSettings)>,
}

/// What has changed of a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshChanges {
    /// Vertices by their numbers, which rise.
    pub vertices: Vec<(u32, ViewVertex)>,
    /// Triangles by their places, which rise: three numbers of vertices each.
    pub triangles: Vec<(u32, [u32; 3])>,
}

impl ViewMesh {
    /// The mesh of two triangles over the root, with level 0 in use.
    pub fn new(frame: PatchFrame, root: Arc<HeightPatch>, vertical_exaggeration: f64) -> Self {
        let corner = frame.scheme.origin;
        let units_per_m = f64::from(FIXED_UNITS_PER_ROOT) / frame.scheme.root_size_m;
        let extent = &frame.data_extent;
        let data_units = [
            DVec2::new(extent.min.x - corner.x, corner.y - extent.max.y) * units_per_m,
            DVec2::new(extent.max.x - corner.x, corner.y - extent.min.y) * units_per_m,
        ];
        let mut vertices = Vertices::default();
        let halves = RightTriangle::halves(IVec2::ZERO, FIXED_UNITS_PER_ROOT, (0, 0));
        let mut numbers = HashMap::new();
        let corners = halves.map(|half| {
            [half.apex, half.left, half.right].map(|position| {
                *numbers.entry(position).or_insert_with(|| {
                    vertices.add(ViewVertex::new(position, root.sample(position)))
                })
            })
        });
        let mut mesh = Self {
            frame,
            vertical_exaggeration,
            data_units,
            patches: HashMap::new(),
            bisection: Bisection::of_halves(corners),
            vertices,
            bounds: Vec::new(),
            patch_levels: Vec::new(),
            leaves: IndexedList::default(),
            joinable: IndexedList::default(),
            changed_places: ChangedIds::default(),
            fresh: Vec::new(),
            coarsening: 1.0,
            refined_for: None,
        };
        mesh.patches.insert(TileId::ROOT, UsedPatch::new(root));
        for half in [0, 1] {
            mesh.judge_new(half, 0);
            let place = mesh.leaves.push(half);
            mesh.changed_places.mark(place);
        }
        mesh
    }

    /// Draws the heights with another factor from now on. No vertex changes; what is fine enough does.
    pub fn set_vertical_exaggeration(&mut self, vertical_exaggeration: f64) {
        if vertical_exaggeration == self.vertical_exaggeration {
            return;
        }
        self.vertical_exaggeration = vertical_exaggeration;
        let mut all = vec![0, 1];
        while let Some(id) = all.pop() {
            self.judge(id);
            let children = self.bisection.get(id).children;
            if children != NONE {
                all.extend([children, children + 1]);
            }
        }
    }

    /// Triangles that are drawn: places below this have one.
    pub fn triangle_count(&self) -> usize {
        self.leaves.len()
    }

    /// Numbers of vertices are below this.
    pub fn vertex_capacity(&self) -> usize {
        self.vertices.capacity()
    }

    /// A vertex by its number.
    pub fn vertex(&self, number: u32) -> &ViewVertex {
        self.vertices.get(number)
    }

    /// Every triangle by its place: three numbers of vertices, counter-clockwise from above.
    pub fn triangles(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        self.leaves.ids().iter().map(|&id| self.bisection.get(id).corners)
    }

    /// How many vertices and triangles have changed since they were last taken.
    pub fn changed(&self) -> (usize, usize) {
        (self.vertices.changed(), self.changed_places.len())
    }

    /// Takes what has changed since the last call. Whoever carries every change out has the mesh.
    pub fn take_changes(&mut self) -> MeshChanges {
        let places = self.changed_places.take().into_iter();
        let triangles = places.filter_map(|place| {
            let id = *self.leaves.ids().get(place as usize)?;
            Some((place, self.drawn_corners(id)))
        });
        MeshChanges { triangles: triangles.collect(), vertices: self.vertices.take_changed() }
    }

    /// The triangle's corners; of one beside the data, a point.
    fn drawn_corners(&self, id: u32) -> [u32; 3] {
        let corners = self.bisection.get(id).corners;
        if self.is_beside_data(&self.shape(id)) { [corners[0]; 3] } else { corners }
    }

    fn shape(&self, id: u32) -> RightTriangle {
        let [apex, left, right] =
            self.bisection.get(id).corners.map(|number| self.vertices.get(number).position);
        RightTriangle { apex, left, right }
    }

    fn is_beside_data(&self, shape: &RightTriangle) -> bool {
        let low = shape.apex.min(shape.left).min(shape.right).as_dvec2();
        let high = shape.apex.max(shape.left).max(shape.right).as_dvec2();
        let [min, max] = self.data_units;
        !(low.cmplt(max).all() && high.cmpgt(min).all())
    }

    /// Notes a triangle that has just come about, in the patch of this level.
    fn judge_new(&mut self, id: u32, patch_level: u8) {
        let room = self.bisection.capacity();
        let nothing = Bounds { centre: DVec3::ZERO, radius_m: 0.0, error_m: 0.0 };
        self.bounds.resize(room, nothing);
        self.patch_levels.resize(room, 0);
        self.patch_levels[id as usize] = patch_level;
        let shape = self.shape(id);
        if self.bisection.get(id).depth.is_multiple_of(2) {
            self.bisection.set_half(id, shape.half());
        }
        self.judge(id);
    }

    /// Measures a triangle anew: its ball, and its error by the patch that holds it.
    fn judge(&mut self, id: u32) {
        let shape = self.shape(id);
        let error_m = self.error_m(id, &shape) * self.vertical_exaggeration as f32;
        let corners = self.bisection.get(id).corners.map(|number| self.place(number));
        self.bounds[id as usize] = Bounds::of(corners, error_m);
    }

    /// Where a vertex is drawn.
    fn place(&self, number: u32) -> DVec3 {
        let vertex = self.vertices.get(number);
        let place = height_patch::world_from_fixed(&self.frame.scheme, vertex.position);
        place.extend(f64::from(vertex.height_m) * self.vertical_exaggeration)
    }

    /// Cuts a triangle that is not cut, and first what must be cut before it.
    fn cut(&mut self, id: u32) {
        let partner = match self.bisection.partner(id) {
            Ok(partner) => partner,
            Err(larger) => {
                self.cut(larger);
                self.bisection.get(id).base
            }
        };
        let Some(middle) = self.shape(id).middle() else { return };
        let middle = self.add_middle(id, partner, middle);
        for cut in [id, partner].into_iter().filter(|&cut| cut != NONE) {
            let parent = self.bisection.get(cut).parent;
            if parent != NONE {
                self.joinable.remove(self.bisection.pair_name(parent));
            }
        }
        let pairs = self.bisection.cut(id, partner, middle);
        for (parent, first) in pairs.into_iter().flatten() {
            let patch_level = self.patch_levels[parent as usize];
            let kept = self.leaves.replace(parent, first);
            let added = self.leaves.push(first + 1);
            kept.into_iter().chain([added]).for_each(|place| self.changed_places.mark(place));
            for child in [first, first + 1] {
                self.judge_new(child, patch_level);
                self.fresh.push(child);
            }
        }
        self.joinable.push(self.bisection.pair_name(id));
    }

    /// The vertex at the middle of an edge: the finer patch of the two sides knows the ground best.
    fn add_middle(&mut self, id: u32, partner: u32, position: IVec2) -> u32 {
        let level = |id: u32| self.patch_levels[id as usize];
        let finer = if partner != NONE && level(partner) > level(id) { partner } else { id };
        let mut vertex = ViewVertex::new(position, self.patch_of(finer).sample(position));
        if vertex.coverage == 0.0 {
            let [_, left, right] = self.bisection.get(id).corners;
            let ends_m = [left, right].map(|end| self.vertices.get(end).height_m);
            vertex.height_m = 0.5 * (ends_m[0] + ends_m[1]);
        }
        self.vertices.add(vertex)
    }

    /// Takes the cut of a pair that can be joined back; returns the pairs that can be joined since.
    fn join(&mut self, name: u32) -> impl Iterator<Item = u32> {
        let (pairs, middle) = self.bisection.join(name);
        self.joinable.remove(name);
        self.vertices.remove(middle);
        let mut above = [None; 2];
        for (slot, (id, first)) in above.iter_mut().zip(pairs.into_iter().flatten()) {
            let kept = self.leaves.replace(first, id);
            let moved = self.leaves.remove(first + 1);
            kept.into_iter().chain(moved).for_each(|place| self.changed_places.mark(place));
            let parent = self.bisection.get(id).parent;
            if parent != NONE && self.bisection.can_join(parent) {
                let name = self.bisection.pair_name(parent);
                if self.joinable.place(name).is_none() {
                    self.joinable.push(name);
                    *slot = Some(name);
                }
            }
        }
        above.into_iter().flatten()
    }
}
