use glam::DVec3;

use crate::CameraView;

/// All a view can see: the pyramid from the eye through the picture's corners, without end.
///
/// There is no far plane, as there is none when the terrain is drawn, and the near plane lies so close
/// to the eye that it hides nothing.
pub(super) struct ViewPyramid {
    eye: DVec3,
    /// Directions in which the pyramid ends at the eye: every point p of it has
    /// `axis . (p - eye) >= 0`.
    axes: Vec<DVec3>,
}

/// An axis-aligned box in world coordinates, metres; `min` nowhere above `max`.
#[derive(Clone, Copy, Debug)]
pub(super) struct WorldBox {
    pub min: DVec3,
    pub max: DVec3,
}

/// Sine of the angle below which two directions count as one: far above the rounding of f64, far
/// below a pixel.
const ALIGNED: f64 = 1.0e-12;

impl ViewPyramid {
    pub fn new(view: &CameraView) -> Self {
        let [width, height] = view.viewport_px.map(f64::from);
        let rays = [[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]]
            .map(|[x, y]| view.ray_direction(x, y));
        let sides = (0..4).map(|i| rays[i].cross(rays[(i + 1) % 4]));
        let edges = rays.iter().flat_map(|ray| DVec3::AXES.map(|edge| ray.cross(edge)));
        let directions = DVec3::AXES.into_iter().chain(sides).chain(edges);
        let axes = directions
            .filter(|direction| direction.length() > ALIGNED)
            .flat_map(|direction| [direction.normalize(), -direction.normalize()])
            .filter(|axis| rays.iter().all(|ray| axis.dot(*ray) >= -ALIGNED))
            .collect();
        Self { eye: view.eye, axes }
    }

    /// Whether the two share a point (touching counts); false for a box that is no number.
    ///
    /// Exact up to rounding, by separating axes: two convex polyhedra that do not meet can be told
    /// apart along the normal of a face of either, or along the cross product of an edge of each.
    /// Testing the pyramid's sides alone, as is common, would keep boxes near its corners and edges
    /// that it does not meet. After S. Gottschalk, M. C. Lin and D. Manocha, "OBBTree: A Hierarchical
    /// Structure for Rapid Interference Detection", 1996; here one of the two has no end, and an axis
    /// can part them only if all of the pyramid lies on one side of the eye along it.
    pub fn meets(&self, bounds: &WorldBox) -> bool {
        let centre = 0.5 * (bounds.min + bounds.max) - self.eye;
        let half = 0.5 * (bounds.max - bounds.min);
        let slack = ALIGNED * (centre.abs() + half).element_sum();
        self.axes.iter().all(|axis| axis.dot(centre) + axis.abs().dot(half) >= -slack)
    }
}
