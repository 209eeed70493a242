use std::f64::consts::PI;

use glam::{DVec2, DVec3, dvec2, dvec3};

use super::ground::GlobeGround;
use super::patch_id::PatchId;
use super::vertex::{GlobeVertex, SplitPlace};
use crate::geodesy::{PlateCarree, Wgs84};
use crate::tiling::Extent;

/// Cells of a patch along a side; even, since neighbours may have half as many.
pub const CELLS_A_SIDE: u32 = 16;
/// Vertices of a patch.
pub const VERTICES_A_PATCH: u32 = (CELLS_A_SIDE + 1) * (CELLS_A_SIDE + 1);

/// A patch with the ground's heights on it.
pub struct GlobePatch {
    /// Row by row.
    pub vertices: Vec<GlobeVertex>,
    /// Holds all vertices: earth-centred, metres.
    pub bounds: Sphere,
    /// The same where the ellipsoid is a sphere of radius 1: x, y by the equator's radius and z by the pole's.
    pub unit_bounds: Sphere,
    /// Side of the largest cell, metres.
    pub cell_m: f64,
    /// The least ground on the plate carrée that the heights were taken from. Of a patch across the date line or
    /// about a pole all longitudes.
    pub extent: Extent,
}

/// A ball.
#[derive(Clone, Copy, Debug)]
pub struct Sphere {
    /// Its middle.
    pub centre: DVec3,
    /// Its radius.
    pub radius: f64,
}

impl Sphere {
    /// A ball about the middle of the box round all points.
    fn holding(points: impl Iterator<Item = DVec3> + Clone) -> Self {
        let bounds = |(low, high): (DVec3, DVec3), point: DVec3| (low.min(point), high.max(point));
        let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (low, high) = points.clone().fold(none, bounds);
        let centre = 0.5 * (low + high);
        let radius = points.fold(0.0_f64, |most, point| most.max(point.distance_squared(centre)));
        Self { centre, radius: radius.sqrt() }
    }
}

/// A place of the patch's grid or of the ring round it.
#[derive(Clone, Copy)]
struct GridPoint {
    normal: DVec3,
    /// On the plate carrée.
    at: DVec2,
    /// As it is drawn.
    height_m: f64,
}

impl GlobePatch {
    /// Points along a side of the grid with a ring round it, for slopes at the edges.
    const RINGED: usize = CELLS_A_SIDE as usize + 3;

    /// The patch on this ground.
    pub fn new(id: PatchId, ground: &GlobeGround) -> Self {
        let points = grid(id, ground);
        let at = |column: usize, row: usize| &points[row * Self::RINGED + column];
        let inner = 1..=CELLS_A_SIDE as usize + 1;
        let mut vertices = Vec::with_capacity(VERTICES_A_PATCH as usize);
        for row in inner.clone() {
            for column in inner.clone() {
                let point = at(column, row);
                let place = Wgs84::ecef_from_normal(point.normal, point.height_m);
                let around = [
                    [at(column - 1, row), at(column + 1, row)],
                    [at(column, row - 1), at(column, row + 1)],
                ];
                let slope = if ground.is_level() { [0.0; 2] } else { slope(point, around) };
                let slope = slope.map(|slope| slope / ground.exaggeration());
                vertices.push(GlobeVertex::new(place, point.height_m, slope));
            }
        }
        let places = vertices.iter().map(|vertex| vertex.split_place().place());
        let unit = dvec3(Wgs84::EQUATOR_RADIUS_M, Wgs84::EQUATOR_RADIUS_M, Wgs84::POLAR_RADIUS_M);
        Self {
            bounds: Sphere::holding(places.clone()),
            unit_bounds: Sphere::holding(places.map(|place| place / unit)),
            cell_m: Self::largest_cell_m(id.level),
            extent: extent_of(&points),
            vertices,
        }
    }

    /// Side in metres of the largest cell of a level, on level ground.
    pub fn largest_cell_m(level: u8) -> f64 {
        // Along the middle of a face, where steps are equal angles.
        let face_m = 0.5 * PI * Wgs84::normal_radius_m(1.0);
        face_m / f64::from(CELLS_A_SIDE << level)
    }
}

/// The points of the grid and of a ring round it, row by row.
fn grid(id: PatchId, ground: &GlobeGround) -> Vec<GridPoint> {
    let part = |index: usize| (index as f64 - 1.0) / f64::from(CELLS_A_SIDE);
    let side = GlobePatch::RINGED;
    (0..side * side)
        .map(|index| {
            let normal = id.direction(part(index % side), part(index / side)).normalize();
            // The pole is one point, whatever the longitude.
            let from_axis = normal.x.hypot(normal.y);
            let angles = dvec2(normal.y.atan2(normal.x), normal.z.atan2(from_axis));
            let at = angles * PlateCarree::RADIUS_M;
            GridPoint { normal, at, height_m: ground.drawn_height_m(at) }
        })
        .collect()
}

/// Metres gained per metre east and north, from the points on either side along both axes of the grid.
fn slope(point: &GridPoint, around: [[&GridPoint; 2]; 2]) -> [f64; 2] {
    let up = point.normal;
    let east = dvec3(-up.y, up.x, 0.0).normalize_or(DVec3::Y);
    let north = up.cross(east);
    let [along, across] = around.map(|[before, after]| {
        let step = Wgs84::ecef_from_normal(after.normal, 0.0)
            - Wgs84::ecef_from_normal(before.normal, 0.0);
        (dvec2(step.dot(east), step.dot(north)), after.height_m - before.height_m)
    });
    let determinant = along.0.perp_dot(across.0);
    if determinant == 0.0 {
        return [0.0; 2];
    }
    [
        (along.1 * across.0.y - across.1 * along.0.y) / determinant,
        (across.1 * along.0.x - along.1 * across.0.x) / determinant,
    ]
}

fn extent_of(points: &[GridPoint]) -> Extent {
    let none = Extent { min: DVec2::INFINITY, max: DVec2::NEG_INFINITY };
    let extent = points.iter().fold(none, |extent, point| Extent {
        min: extent.min.min(point.at),
        max: extent.max.max(point.at),
    });
    let half_m = PI * PlateCarree::RADIUS_M;
    let holds_axis = points.iter().any(|point| point.normal.z.abs() == 1.0);
    if extent.size_m().x < half_m && !holds_axis {
        return extent;
    }
    Extent { min: dvec2(-half_m, extent.min.y), max: dvec2(half_m, extent.max.y) }
}

impl GlobePatch {
    /// Distance in metres from an earth-centred place to the nearest that the patch could be.
    pub fn distance_m(&self, place: DVec3) -> f64 {
        (place.distance(self.bounds.centre) - self.bounds.radius).max(SplitPlace::COARSE_M)
    }
}
