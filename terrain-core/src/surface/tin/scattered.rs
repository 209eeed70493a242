//! Scattered points joined to triangles.

use rayon::prelude::*;
use spade::handles::FixedVertexHandle;
use spade::{
    ConstrainedDelaunayTriangulation, HasPosition, MAX_ALLOWED_VALUE, Point2,
    PositionInTriangulation, Triangulation, mitigate_underflow, validate_vertex,
};

use super::{Breakline, NaturalNeighbours, Tin, TinError};

/// Points no two of which have the same x and y, from west to east and south to north.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DistinctPoints {
    points: Vec<[f64; 3]>,
    /// Points left out because another one stands for them.
    pub merged: usize,
}

/// Most points of a triangulation: its edges are counted in 32 bits.
const MOST_POINTS: usize = 1 << 28;

impl DistinctPoints {
    /// Of points with the same x and y the one of median height stays (of an even number the lower of
    /// the middle two): one that was measured, whatever order they come in.
    ///
    /// # Errors
    /// Where a coordinate is not finite or beyond 2^201, or there are too many points.
    pub fn new(mut points: Vec<[f64; 3]>) -> Result<Self, TinError> {
        for point in &mut points {
            let place = mitigate_underflow(Point2::new(point[0], point[1]));
            if validate_vertex(&place).is_err() || !is_height(point[2]) {
                return Err(TinError::BadPoint { point: *point });
            }
            // Adding 0 makes -0 the same as 0.
            *point = [place.x + 0.0, place.y + 0.0, point[2]];
        }
        let key = |a: &[f64; 3], b: &[f64; 3]| {
            a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])).then(a[2].total_cmp(&b[2]))
        };
        points.par_sort_unstable_by(key);
        let all = points.len();
        let groups = points.chunk_by(|a, b| a[0] == b[0] && a[1] == b[1]);
        let points: Vec<_> = groups.map(|group| group[(group.len() - 1) / 2]).collect();
        let merged = all - points.len();
        match points.len() {
            count if count > MOST_POINTS => Err(TinError::TooManyPoints { count }),
            _ => Ok(Self { points, merged }),
        }
    }

    /// The points: x, y, height in metres.
    pub fn points(&self) -> &[[f64; 3]] {
        &self.points
    }

    pub(super) fn height_points(&self) -> Vec<HeightPoint> {
        let points = self.points.iter();
        points.map(|&[x, y, height_m]| HeightPoint { place: Point2::new(x, y), height_m }).collect()
    }

    /// For a triangulation that refuses what was checked here.
    pub(super) fn first_bad(&self) -> TinError {
        TinError::BadPoint { point: self.points.first().copied().unwrap_or_default() }
    }
}

/// Whether a height can be computed with: as wide a range as that of coordinates.
fn is_height(height_m: f64) -> bool {
    height_m.abs() <= MAX_ALLOWED_VALUE
}

/// A point with a height.
#[derive(Clone, Copy)]
pub struct HeightPoint {
    pub place: Point2<f64>,
    pub height_m: f64,
}

impl HasPosition for HeightPoint {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.place
    }
}

/// Why a triangulation of so many triangles is no surface, if so.
pub fn check_shape(triangles: usize, points: &DistinctPoints) -> Result<(), TinError> {
    match points.points.len() {
        count @ 0..=2 => Err(TinError::TooFewPoints { count }),
        count if triangles == 0 => Err(TinError::Collinear { count }),
        _ => Ok(()),
    }
}

/// Triangles of points, with breaklines.
pub type Triangles = ConstrainedDelaunayTriangulation<HeightPoint>;

/// Joins all points to a Delaunay triangulation of their convex hull, with the breaklines as edges.
/// Breakline points without a height take that of the points' natural neighbours. Where breaklines
/// cross, the later one's height counts.
///
/// # Errors
/// Where there are fewer than three points or all lie on one line, and where a breakline without
/// heights leaves the hull.
pub fn tin_of_points(points: &DistinctPoints, breaklines: &[Breakline]) -> Result<Tin, TinError> {
    let mut triangles =
        Triangles::bulk_load(points.height_points()).map_err(|_| points.first_bad())?;
    check_shape(triangles.num_inner_faces(), points)?;
    add_breaklines(&mut triangles, points, breaklines)?;
    Ok(tin_of_triangles(&triangles))
}

pub fn tin_of_triangles(triangles: &Triangles) -> Tin {
    let vertices = triangles.vertices().map(|vertex| {
        let HeightPoint { place, height_m } = *vertex.data();
        [place.x, place.y, height_m]
    });
    let faces = triangles.inner_faces();
    Tin {
        vertices: vertices.collect(),
        triangles: faces.map(|face| face.vertices().map(|vertex| vertex.index() as u32)).collect(),
    }
}

/// Makes edges of the breaklines' pieces.
pub fn add_breaklines(
    triangles: &mut Triangles,
    points: &DistinctPoints,
    breaklines: &[Breakline],
) -> Result<(), TinError> {
    if breaklines.is_empty() {
        return Ok(());
    }
    let ground = NaturalNeighbours::new(points)?;
    let mut sampler = ground.sampler();
    for line in breaklines {
        let mut last: Option<FixedVertexHandle> = None;
        for point in &line.points {
            let [x, y] = point.position.to_array();
            let height_m = point.height_m.or_else(|| sampler.height_m(x, y));
            let height_m = height_m.ok_or(TinError::BreaklineWithoutHeight { x, y })?;
            let place = mitigate_underflow(Point2::new(x, y));
            let vertex = insert(triangles, HeightPoint { place, height_m })
                .ok_or(TinError::BadPoint { point: [x, y, height_m] })?;
            if let Some(last) = last {
                add_piece(triangles, last, vertex);
            }
            last = Some(vertex);
        }
    }
    Ok(())
}

/// The vertex at a point, a new one where there is none yet; a point that is there counts.
fn insert(triangles: &mut Triangles, point: HeightPoint) -> Option<FixedVertexHandle> {
    if !is_height(point.height_m) || validate_vertex(&point.place).is_err() {
        return None;
    }
    match triangles.locate(point.place) {
        PositionInTriangulation::OnVertex(vertex) => Some(vertex),
        _ => triangles.insert(point).ok(),
    }
}

/// Makes edges from one vertex to another. Where that crosses a breakline a vertex is made, of the
/// height that this one has there.
fn add_piece(triangles: &mut Triangles, from: FixedVertexHandle, to: FixedVertexHandle) {
    let [start, end] = [from, to].map(|vertex| *triangles.vertex(vertex).data());
    let way = [end.place.x - start.place.x, end.place.y - start.place.y];
    let squared = way[0] * way[0] + way[1] * way[1];
    triangles.add_constraint_and_split(from, to, |place| {
        let along = (place.x - start.place.x) * way[0] + (place.y - start.place.y) * way[1];
        let part = (along / squared).clamp(0.0, 1.0);
        HeightPoint { place, height_m: start.height_m * (1.0 - part) + end.height_m * part }
    });
}
