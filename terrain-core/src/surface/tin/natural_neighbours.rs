//! Heights between scattered points.

use spade::{
    DelaunayTriangulation, FloatTriangulation, HierarchyHintGenerator, NaturalNeighbor, Point2,
    Triangulation, mitigate_underflow, validate_vertex,
};

use super::scattered::{HeightPoint, check_shape};
use super::{DistinctPoints, TinError};

type Triangles = DelaunayTriangulation<HeightPoint, (), (), (), HierarchyHintGenerator<f64>>;

/// A surface through scattered points: each place takes from its natural neighbours, in proportion to
/// the area its own cell would take from theirs (R. Sibson, "A Brief Description of Natural Neighbour
/// Interpolation", 1981; the variant that is continuous, without slopes at the points). It meets every
/// point, never leaves the range of a place's neighbours, and reproduces planes.
///
/// Made once, read by many threads at a time.
pub struct NaturalNeighbours {
    triangles: Triangles,
}

impl NaturalNeighbours {
    /// Triangulates the points.
    ///
    /// # Errors
    /// Where there are fewer than three points or all lie on one line.
    pub fn new(points: &DistinctPoints) -> Result<Self, TinError> {
        let triangles =
            Triangles::bulk_load(points.height_points()).map_err(|_| points.first_bad())?;
        check_shape(triangles.num_inner_faces(), points)?;
        Ok(Self { triangles })
    }

    /// What a thread needs to read heights; keep it as long as there are more to read.
    pub fn sampler(&self) -> NaturalSampler<'_> {
        NaturalSampler {
            triangles: &self.triangles,
            natural: self.triangles.natural_neighbor(),
            weights: Vec::new(),
        }
    }

    /// Area of the points' convex hull, in squares of the coordinates' unit.
    pub fn hull_area(&self) -> f64 {
        // Relative to a corner: coordinates far from 0 would lose the difference.
        let Some(first) = self.triangles.convex_hull().next() else { return 0.0 };
        let origin = first.from().position();
        let edges = self
            .triangles
            .convex_hull()
            .map(|edge| edge.positions().map(|point| [point.x - origin.x, point.y - origin.y]));
        let doubled: f64 = edges.map(|[a, b]| a[0] * b[1] - a[1] * b[0]).sum();
        0.5 * doubled.abs()
    }
}

/// Reads heights of [`NaturalNeighbours`], for one thread.
pub struct NaturalSampler<'a> {
    triangles: &'a Triangles,
    natural: NaturalNeighbor<'a, Triangles>,
    weights: Vec<(spade::handles::FixedVertexHandle, f64)>,
}

impl NaturalSampler<'_> {
    /// The height in metres at a place, `None` outside the points' convex hull.
    pub fn height_m(&mut self, x: f64, y: f64) -> Option<f64> {
        /// Shares lie within 0 and 1 up to rounding.
        const SLACK: f64 = 1e-6;
        let place = mitigate_underflow(Point2::new(x, y));
        validate_vertex(&place).ok()?;
        self.natural.get_weights(place, &mut self.weights);
        let sound = self.weights.iter().all(|(_, share)| (-SLACK..=1.0 + SLACK).contains(share));
        if !sound {
            // Close to the hull cells reach far away and their areas cannot be told apart any more.
            self.triangles.barycentric().get_weights(place, &mut self.weights);
        }
        if self.weights.is_empty() {
            return None;
        }
        let parts = self.weights.iter();
        let height_m: f64 = parts
            .map(|(vertex, share)| share * self.triangles.vertex(*vertex).data().height_m)
            .sum();
        height_m.is_finite().then_some(height_m)
    }
}
