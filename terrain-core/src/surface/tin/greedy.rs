//! A raster covered with few triangles: greedy insertion.
//!
//! M. Garland and P. Heckbert, "Fast Polygonal Approximation of Terrains and Height Fields", 1995, their
//! algorithm III on a Delaunay triangulation:
//!
//! 1. Triangulate the corners.
//! 2. Find the sample farthest from its triangle, for each triangle, and keep the triangles in a heap.
//! 3. Insert the farthest sample of all; look again at the triangles that this has changed.
//! 4. Go on until no sample is farther than the stated error.
//!
//! Departures. The corners are those of the ground that holds data: its border is part of the
//! triangulation, as constrained edges, and so are breaklines; triangles outside the border are left out
//! in the end. Breaklines may bring heights of their own, but where one passes through a sample the
//! sample counts. Coordinates are in samples, so that those of samples are whole numbers.
//!
//! After an insertion the changed triangles are those round the new vertex: Delaunay flips only ever
//! make edges that end there.

use std::collections::BinaryHeap;

use glam::{DVec2, dvec2};
use spade::handles::{FaceHandle, FixedVertexHandle, InnerTag};
use spade::{ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation};

use super::border::border_of;
use super::breakline::ground_parts;
use super::triangle_scan::{plane_slope, visit_rows};
use super::worst::{Versions, Worst};
use super::{Breakline, KeepGoing, SampleGrid, Tin, TinError};

/// Covers a grid with triangles none of whose samples is more than `max_error_m` above or below them.
///
/// Triangles cover the cells all of whose four samples hold data, and nothing else; the error is kept
/// at every sample of such a cell, up to the rounding of f64. Where breaklines cross each other or the border, a
/// vertex is made there.
///
/// # Errors
/// Where the error is negative or no number, the grid has no cell that holds data, no breakline meets
/// the grid, or `keep_going` says to stop.
pub fn tin_of_grid(
    grid: &SampleGrid<'_>,
    max_error_m: f64,
    breaklines: &[Breakline],
    keep_going: &mut KeepGoing<'_>,
) -> Result<Tin, TinError> {
    if !(max_error_m.is_finite() && max_error_m >= 0.0) {
        return Err(TinError::MaxError(max_error_m));
    }
    grid.check()?;
    let mut mesh = GreedyMesh::new(*grid, max_error_m)?;
    mesh.add_breaklines(breaklines)?;
    mesh.refine(keep_going)?;
    Ok(mesh.finish())
}

/// A vertex: its place in samples and its height in metres.
#[derive(Clone, Copy)]
struct GridVertex {
    place: Point2<f64>,
    height_m: f64,
}

impl HasPosition for GridVertex {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.place
    }
}

type Triangles = ConstrainedDelaunayTriangulation<GridVertex>;
type GridFace<'a> = FaceHandle<'a, InnerTag, GridVertex, (), spade::CdtEdge<()>, ()>;

struct GreedyMesh<'a> {
    grid: SampleGrid<'a>,
    max_error_m: f64,
    triangles: Triangles,
    /// Samples that are vertices.
    is_vertex: Vec<bool>,
    versions: Versions,
    queue: BinaryHeap<Worst>,
}

impl<'a> GreedyMesh<'a> {
    fn new(grid: SampleGrid<'a>, max_error_m: f64) -> Result<Self, TinError> {
        let border = border_of(&grid);
        if border.is_empty() {
            return Err(TinError::NoData);
        }
        let mut mesh = Self {
            grid,
            max_error_m,
            triangles: Triangles::new(),
            is_vertex: vec![false; grid.columns * grid.rows],
            versions: Versions::default(),
            queue: BinaryHeap::new(),
        };
        // Corners first: no piece of border may find its end in another's way.
        let mut ends = Vec::with_capacity(border.len());
        for [from, to] in border {
            ends.push([mesh.insert_sample(from, None)?, mesh.insert_sample(to, None)?]);
        }
        for [from, to] in ends {
            mesh.triangles.add_constraint(from, to);
        }
        Ok(mesh)
    }

    fn insert_sample(
        &mut self,
        [column, row]: [usize; 2],
        near: Option<FixedVertexHandle>,
    ) -> Result<FixedVertexHandle, TinError> {
        self.is_vertex[row * self.grid.columns + column] = true;
        let height_m = self.grid.height_m(column, row);
        let vertex = GridVertex { place: Point2::new(column as f64, row as f64), height_m };
        let inserted = match near {
            Some(near) => self.triangles.insert_with_hint(vertex, near),
            None => self.triangles.insert(vertex),
        };
        inserted.map_err(|_| self.bad_place(vertex))
    }

    fn bad_place(&self, vertex: GridVertex) -> TinError {
        let position = self.grid.position(dvec2(vertex.place.x, vertex.place.y));
        TinError::BadPoint { point: [position.x, position.y, vertex.height_m] }
    }

    fn add_breaklines(&mut self, breaklines: &[Breakline]) -> Result<(), TinError> {
        let mut met = breaklines.is_empty();
        for line in breaklines {
            for pair in line.points.windows(2) {
                let [from, to] = [pair[0], pair[1]].map(|point| self.grid.place(point.position));
                let heights = pair[0].height_m.zip(pair[1].height_m);
                for ends in ground_parts(&self.grid, from, to) {
                    let [start, end] = ends.map(|(part, place)| {
                        let height_m = heights.map(|(from, to)| from * (1.0 - part) + to * part);
                        self.insert_line_end(place, height_m)
                    });
                    self.add_line(start?, end?);
                    met = true;
                }
            }
        }
        if met { Ok(()) } else { Err(TinError::BreaklinesElsewhere) }
    }

    /// Makes edges from one vertex to another, and a vertex on the ground where they cross others.
    fn add_line(&mut self, start: FixedVertexHandle, end: FixedVertexHandle) {
        let grid = self.grid;
        self.triangles.add_constraint_and_split(start, end, |place| {
            let height_m = grid.bilinear_m(dvec2(place.x, place.y)).unwrap_or(f64::NAN);
            GridVertex { place, height_m }
        });
    }

    /// A breakline's end becomes a vertex; one on a sample is that sample.
    fn insert_line_end(
        &mut self,
        place: DVec2,
        height_m: Option<f64>,
    ) -> Result<FixedVertexHandle, TinError> {
        if place == place.round() {
            return self.insert_sample([place.x as usize, place.y as usize], None);
        }
        let own_m = height_m.filter(|height_m| height_m.is_finite());
        let height_m = own_m.or_else(|| self.grid.bilinear_m(place)).unwrap_or(f64::NAN);
        let vertex = GridVertex { place: Point2::new(place.x, place.y), height_m };
        self.triangles.insert(vertex).map_err(|_| self.bad_place(vertex))
    }

    fn refine(&mut self, keep_going: &mut KeepGoing<'_>) -> Result<(), TinError> {
        /// Vertices between two calls of `keep_going`.
        const STRIDE: usize = 4096;
        let faces: Vec<Look> = self.triangles.inner_faces().map(Look::at).collect();
        faces.into_iter().for_each(|face| self.look(&face));
        let mut star = Vec::new();
        while let Some(worst) = self.queue.pop() {
            if !self.versions.holds(&worst) {
                continue;
            }
            let sample = [worst.sample % self.grid.columns, worst.sample / self.grid.columns];
            let vertex = self.insert_sample(sample, Some(worst.corner))?;
            star.clear();
            let edges = self.triangles.vertex(vertex).out_edges();
            star.extend(edges.filter_map(|edge| edge.face().as_inner()).map(Look::at));
            star.iter().for_each(|face| self.look(face));
            let count = self.triangles.num_vertices();
            if count.is_multiple_of(STRIDE) && !keep_going(worst.error_m, count) {
                return Err(TinError::Cancelled);
            }
        }
        Ok(())
    }

    /// Finds a triangle's worst sample, and notes it if it is too far off.
    fn look(&mut self, face: &Look) {
        let version = self.versions.renew(face.index);
        if !is_on_ground(&self.grid, &face.places) {
            return;
        }
        if let Some((error_m, sample)) = self.worst_sample(face) {
            let (face, corner) = (face.index, face.corner);
            self.queue.push(Worst { error_m, sample, face, version, corner });
        }
    }

    /// The sample farthest above or below a triangle, if it is too far.
    fn worst_sample(&self, face: &Look) -> Option<(f64, usize)> {
        let slope = plane_slope(face.places, face.heights_m)?;
        let columns = self.grid.columns;
        let (mut worst_m, mut found) = (self.max_error_m, None);
        visit_rows(face.places, [columns, self.grid.rows], |row, start, end| {
            let from = dvec2(start as f64, row as f64) - face.places[0];
            let plane_m = face.heights_m[0] + slope.dot(from);
            let samples = row * columns + start..row * columns + end;
            for (offset, height_m) in self.grid.heights_m[samples.clone()].iter().enumerate() {
                let error_m = (plane_m + slope.x * offset as f64 - f64::from(*height_m)).abs();
                if error_m > worst_m && !self.is_vertex[samples.start + offset] {
                    worst_m = error_m;
                    found = Some(samples.start + offset);
                }
            }
        });
        found.map(|sample| (worst_m, sample))
    }

    fn finish(self) -> Tin {
        let mut tin = Tin::default();
        let mut numbers = vec![u32::MAX; self.triangles.num_vertices()];
        for face in self.triangles.inner_faces() {
            if !is_on_ground(&self.grid, &Look::at(face).places) {
                continue;
            }
            let corners = face.vertices().map(|vertex| {
                let number = &mut numbers[vertex.index()];
                if *number == u32::MAX {
                    *number = tin.vertices.len() as u32;
                    let GridVertex { place, height_m } = *vertex.data();
                    let position = self.grid.position(dvec2(place.x, place.y));
                    tin.vertices.push([position.x, position.y, height_m]);
                }
                *number
            });
            // Rows run south, so what turns left among samples turns right on the ground.
            tin.triangles.push([corners[0], corners[2], corners[1]]);
        }
        tin
    }
}

/// A triangle as it is looked at.
struct Look {
    index: usize,
    corner: FixedVertexHandle,
    places: [DVec2; 3],
    heights_m: [f64; 3],
}

impl Look {
    fn at(face: GridFace<'_>) -> Self {
        let vertices = face.vertices();
        Self {
            index: face.index(),
            corner: vertices[0].fix(),
            places: vertices.map(|vertex| dvec2(vertex.position().x, vertex.position().y)),
            heights_m: vertices.map(|vertex| vertex.data().height_m),
        }
    }
}

/// Whether a triangle lies on ground that holds data. The border is made of edges, so one point
/// inside tells for all.
fn is_on_ground(grid: &SampleGrid<'_>, [a, b, c]: &[DVec2; 3]) -> bool {
    let centre = (*a + *b + *c) / 3.0;
    grid.is_cell_held(centre.x.floor() as i64, centre.y.floor() as i64)
}
