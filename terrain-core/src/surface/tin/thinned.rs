//! Scattered points covered with few triangles: greedy insertion, as of rasters (`greedy.rs`), where each
//! triangle keeps the list of the points in it.

use std::collections::BinaryHeap;

use glam::{DVec2, dvec2};
use spade::handles::{FaceHandle, FixedVertexHandle, InnerTag};
use spade::{DelaunayTriangulation, Point2, PositionInTriangulation, Triangulation};

use super::scattered::{HeightPoint, Triangles, add_breaklines, check_shape, tin_of_triangles};
use super::triangle_scan::plane_slope;
use super::worst::{Versions, Worst};
use super::{Breakline, DistinctPoints, KeepGoing, Tin, TinError};

/// Joins so many of the points that none is more than `max_error_m` above or below the triangles;
/// returns the largest such distance too. Otherwise as [`tin_of_points`](super::tin_of_points).
///
/// # Errors
/// As of that, and where the error is negative or no number or `keep_going` says to stop.
pub fn tin_of_points_within(
    points: &DistinctPoints,
    max_error_m: f64,
    breaklines: &[Breakline],
    keep_going: &mut KeepGoing<'_>,
) -> Result<(Tin, f64), TinError> {
    if !(max_error_m.is_finite() && max_error_m >= 0.0) {
        return Err(TinError::MaxError(max_error_m));
    }
    let mut triangles = hull_of(points)?;
    add_breaklines(&mut triangles, points, breaklines)?;
    let mut mesh = ThinnedMesh {
        points: points.points(),
        max_error_m,
        inside: Vec::new(),
        triangles,
        versions: Versions::default(),
        queue: BinaryHeap::new(),
        left_m: Vec::new(),
    };
    mesh.share_out();
    mesh.refine(keep_going)?;
    let largest_m = mesh.left_m.iter().copied().fold(0.0, f64::max);
    Ok((tin_of_triangles(&mesh.triangles), largest_m))
}

/// A triangulation of the points on the convex hull alone.
fn hull_of(points: &DistinctPoints) -> Result<Triangles, TinError> {
    let all = DelaunayTriangulation::<HeightPoint>::bulk_load(points.height_points())
        .map_err(|_| points.first_bad())?;
    check_shape(all.num_inner_faces(), points)?;
    let hull = all.convex_hull().map(|edge| *edge.from().data()).collect();
    Triangles::bulk_load(hull).map_err(|_| points.first_bad())
}

struct ThinnedMesh<'a> {
    points: &'a [[f64; 3]],
    max_error_m: f64,
    /// The points in each triangle that are no vertices.
    inside: Vec<Vec<u32>>,
    triangles: Triangles,
    versions: Versions,
    queue: BinaryHeap<Worst>,
    /// The largest error in each triangle.
    left_m: Vec<f64>,
}

impl ThinnedMesh<'_> {
    /// Gives every point to the triangle it lies in.
    fn share_out(&mut self) {
        self.inside.resize(self.triangles.num_all_faces(), Vec::new());
        for (index, &[x, y, _]) in self.points.iter().enumerate() {
            let face = match self.triangles.locate(Point2::new(x, y)) {
                PositionInTriangulation::OnFace(face) => Some(face.index()),
                PositionInTriangulation::OnEdge(edge) => {
                    let edge = self.triangles.directed_edge(edge);
                    let sides = [edge.face(), edge.rev().face()];
                    sides.into_iter().find_map(|face| face.as_inner().map(|face| face.index()))
                }
                _ => None,
            };
            if let Some(face) = face {
                self.inside[face].push(index as u32);
            }
        }
        let faces: Vec<Corners> = self.triangles.inner_faces().map(Corners::of).collect();
        faces.iter().for_each(|face| self.look(face));
    }

    fn refine(&mut self, keep_going: &mut KeepGoing<'_>) -> Result<(), TinError> {
        /// Vertices between two calls of `keep_going`.
        const STRIDE: usize = 4096;
        while let Some(worst) = self.queue.pop() {
            if !self.versions.holds(&worst) {
                continue;
            }
            self.insert(&worst)?;
            let count = self.triangles.num_vertices();
            if count.is_multiple_of(STRIDE) && !keep_going(worst.error_m, count) {
                return Err(TinError::Cancelled);
            }
        }
        Ok(())
    }

    /// Makes a point a vertex, and shares the points of the triangles round it out among them.
    fn insert(&mut self, worst: &Worst) -> Result<(), TinError> {
        let point = self.points[worst.sample];
        let vertex = HeightPoint { place: Point2::new(point[0], point[1]), height_m: point[2] };
        let vertex = self
            .triangles
            .insert_with_hint(vertex, worst.corner)
            .map_err(|_| TinError::BadPoint { point })?;
        let edges = self.triangles.vertex(vertex).out_edges();
        let star: Vec<Corners> =
            edges.filter_map(|edge| edge.face().as_inner()).map(Corners::of).collect();
        self.inside.resize(self.triangles.num_all_faces(), Vec::new());
        let points: Vec<u32> =
            star.iter().flat_map(|face| std::mem::take(&mut self.inside[face.index])).collect();
        for index in points.into_iter().filter(|&index| index as usize != worst.sample) {
            let [x, y, _] = self.points[index as usize];
            let depth = |face: &&Corners| face.depth(vertex, dvec2(x, y));
            let face = star.iter().max_by(|a, b| depth(a).total_cmp(&depth(b)));
            if let Some(face) = face {
                self.inside[face.index].push(index);
            }
        }
        star.iter().for_each(|face| self.look(face));
        Ok(())
    }

    /// Finds a triangle's worst point, and queues it if it is too far off.
    fn look(&mut self, face: &Corners) {
        let version = self.versions.renew(face.index);
        self.left_m.resize(self.left_m.len().max(face.index + 1), 0.0);
        self.left_m[face.index] = 0.0;
        let Some(slope) = plane_slope(face.places, face.heights_m) else { return };
        let errors = self.inside[face.index].iter().map(|&index| {
            let [x, y, height_m] = self.points[index as usize];
            let plane_m = face.heights_m[0] + slope.dot(dvec2(x, y) - face.places[0]);
            ((plane_m - height_m).abs(), index as usize)
        });
        let worst = errors.max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
        let Some((error_m, sample)) = worst else { return };
        self.left_m[face.index] = error_m;
        if error_m > self.max_error_m {
            let (face, corner) = (face.index, face.handles[0]);
            self.queue.push(Worst { error_m, sample, face, version, corner });
        }
    }
}

/// A triangle as it is looked at, its corners counter-clockwise.
struct Corners {
    index: usize,
    handles: [FixedVertexHandle; 3],
    places: [DVec2; 3],
    heights_m: [f64; 3],
}

impl Corners {
    fn of(face: FaceHandle<'_, InnerTag, HeightPoint, (), spade::CdtEdge<()>, ()>) -> Self {
        let vertices = face.vertices();
        Self {
            index: face.index(),
            handles: vertices.map(|vertex| vertex.fix()),
            places: vertices.map(|vertex| dvec2(vertex.data().place.x, vertex.data().place.y)),
            heights_m: vertices.map(|vertex| vertex.data().height_m),
        }
    }

    /// How far a place lies within the two edges from one of the corners: positive inside.
    fn depth(&self, apex: FixedVertexHandle, place: DVec2) -> f64 {
        let first = self.handles.iter().position(|corner| *corner == apex).unwrap_or(0);
        let [apex, next, last] = [0, 1, 2].map(|step| self.places[(first + step) % 3]);
        let (next, last, place) = (next - apex, last - apex, place - apex);
        (next.perp_dot(place) / next.length()).min(place.perp_dot(last) / last.length())
    }
}
