use glam::{DVec2, DVec3};

use crate::CameraView;

/// Nearness (inverse depth) of a triangle's farthest corner over that of its nearest, below which it
/// is taken to span a silhouette instead of the surface.
const LEAST_NEARNESS_PART: f64 = 0.9;
/// How far from where a place should show it is looked for, in pixels each way.
const REACH_PX: i64 = 2;

/// The surface as one picture shows it: the triangles between the points of neighbouring pixels.
pub(super) struct DrawnSurface<'a> {
    pub view: &'a CameraView,
    /// The point of each pixel of the view, row by row from the top left, not a number in the sky.
    pub points: &'a [DVec3],
}

impl DrawnSurface<'_> {
    /// Height of the surface at a place, looked for near the pixel position `near_px`; `None` where the
    /// picture does not show it.
    pub fn height_m(&self, place: DVec2, near_px: DVec2) -> Option<f64> {
        let corner = (near_px - 0.5).floor();
        // From the likeliest square of four pixels outwards.
        (0..=REACH_PX).find_map(|reach| {
            self.squares_at(reach).find_map(|(right, down)| {
                let corner = (corner.x as i64 + right, corner.y as i64 + down);
                self.height_in_square(place, corner)
            })
        })
    }

    /// Steps to the squares of the ring at this distance.
    fn squares_at(&self, reach: i64) -> impl Iterator<Item = (i64, i64)> {
        let steps = move || -reach..=reach;
        steps()
            .flat_map(move |down| steps().map(move |right| (right, down)))
            .filter(move |(right, down)| right.abs().max(down.abs()) == reach)
    }

    fn height_in_square(&self, place: DVec2, (column, row): (i64, i64)) -> Option<f64> {
        let [a, b, c, d] = [(0, 0), (1, 0), (0, 1), (1, 1)]
            .map(|(right, down)| self.point(column + right, row + down));
        let triangle = |corners: [Option<DVec3>; 3]| {
            let [a, b, c] = corners;
            self.height_in_triangle(place, [a?, b?, c?])
        };
        triangle([a, b, c]).or_else(|| triangle([d, c, b]))
    }

    fn point(&self, column: i64, row: i64) -> Option<DVec3> {
        let [width, height] = self.view.viewport_px.map(i64::from);
        let is_inside = (0..width).contains(&column) && (0..height).contains(&row);
        let point = is_inside.then(|| self.points.get((row * width + column) as usize))??;
        (!point.is_nan()).then_some(*point)
    }

    fn height_in_triangle(&self, place: DVec2, [a, b, c]: [DVec3; 3]) -> Option<f64> {
        let (to_b, to_c) = ((b - a).truncate(), (c - a).truncate());
        let area = to_b.perp_dot(to_c);
        let way = place - a.truncate();
        let (part_b, part_c) = (way.perp_dot(to_c) / area, to_b.perp_dot(way) / area);
        // Not a number in a triangle that is seen as a line from above, hence outside.
        let is_inside = part_b >= 0.0 && part_c >= 0.0 && part_b + part_c <= 1.0;
        let height_m = a.z + part_b * (b.z - a.z) + part_c * (c.z - a.z);
        (is_inside && !self.spans_silhouette([a, b, c])).then_some(height_m)
    }

    fn spans_silhouette(&self, corners: [DVec3; 3]) -> bool {
        let forward = self.view.forward();
        let depths = corners.map(|corner| (corner - self.view.eye).dot(forward));
        let nearest = depths.into_iter().fold(f64::INFINITY, f64::min);
        let farthest = depths.into_iter().fold(0.0, f64::max);
        nearest < LEAST_NEARNESS_PART * farthest
    }
}
