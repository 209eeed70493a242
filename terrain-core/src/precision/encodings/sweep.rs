//! Which points are looked at: two sweeps, one for where points are and one for where in their tiles.

use glam::{DVec2, dvec2};
use serde::Serialize;

use super::{EncodingScene, spread};

/// Height in pixels of the picture that fields of view are spread over.
pub const VIEWPORT_HEIGHT_PX: f64 = 2160.0;

/// A tile is drawn with texels of a quarter of a pixel at the least: it is split by the distance of its
/// nearest point, and its farthest is never four times as far.
const LEAST_TEXEL_PX: f64 = 0.25;

/// Values that the sweeps go through.
#[derive(Clone, Debug, Serialize)]
pub struct SweepAxes {
    /// Coordinates of the eye on both axes, metres.
    pub magnitudes_m: Vec<f64>,
    /// Heights of the eye above level ground, metres.
    pub heights_m: Vec<f64>,
    /// Angles between the ray and the ground, degrees.
    pub grazing_deg: Vec<f64>,
    /// Vertical fields of view, degrees.
    pub fovs_deg: Vec<f64>,
    /// Levels of the tiles.
    pub levels: Vec<u8>,
    /// Points in a cell.
    pub points: usize,
}

impl SweepAxes {
    /// Every combination that the records hold.
    pub fn full() -> Self {
        Self {
            magnitudes_m: vec![1.0, 1e2, 1e4, 1e5, 5e5, 1e6, 4e6, 1e7, 2e7, 4e7],
            heights_m: (0..8).map(|exponent| 10.0_f64.powi(exponent)).collect(),
            grazing_deg: vec![80.0, 60.0, 30.0, 10.0, 3.0, 1.0, 0.1],
            fovs_deg: vec![1.0, 10.0, 50.0, 90.0, 170.0],
            levels: (0..=24).collect(),
            points: 256,
        }
    }

    /// The ends of every axis and some of what is between, for a run of a second.
    pub fn quick() -> Self {
        Self {
            magnitudes_m: vec![1.0, 1e4, 1e6, 4e7],
            heights_m: vec![1.0, 1e2, 1e4, 1e7],
            grazing_deg: vec![80.0, 10.0, 0.1],
            fovs_deg: vec![1.0, 50.0, 170.0],
            levels: vec![0, 4, 8, 12, 16, 20, 22, 24],
            points: 32,
        }
    }
}

/// A point to encode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SweepPoint {
    /// Which cell of the sweep it belongs to.
    pub cell: usize,
    /// Metres east and north.
    pub world: DVec2,
    /// Level of the tile it is looked up in.
    pub level: u8,
}

/// A cell of the sweep over positions.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PositionCell {
    /// Coordinates of the eye, metres.
    pub magnitude_m: f64,
    /// Height of the eye, metres.
    pub height_m: f64,
    /// Angle between the ray and the ground, degrees.
    pub grazing_deg: f64,
    /// Vertical field of view, degrees.
    pub fov_deg: f64,
    /// Level shown there.
    pub level: u8,
    /// Distance from the eye to the points, metres.
    pub distance_m: f64,
}

/// A cell of the sweep over places in tiles.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PlaceCell {
    /// Coordinates of the eye, metres.
    pub magnitude_m: f64,
    /// Level of the tiles.
    pub level: u8,
    /// Vertical field of view, degrees: it bounds the distance at which the level is shown.
    pub fov_deg: f64,
}

/// A cell of the sweep over ground close to the eye.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct GroundCell {
    /// Coordinates of the eye, metres.
    pub magnitude_m: f64,
    /// Level of the tiles that hold the heights.
    pub level: u8,
    /// Side of their texels, metres.
    pub texel_m: f64,
}

/// Angle in radians of a pixel in the middle of the picture.
pub fn pixel_angle_rad(fov_deg: f64) -> f64 {
    2.0 * (0.5 * fov_deg.to_radians()).tan() / VIEWPORT_HEIGHT_PX
}

/// The finest level whose texels are not smaller than a pixel at this distance, as selection picks it.
pub fn finest_level_shown(scene: &EncodingScene, distance_m: f64, fov_deg: f64) -> u8 {
    let footprint_m = distance_m * pixel_angle_rad(fov_deg);
    (0..=24).take_while(|level| scene.texel_size_m(*level) >= footprint_m).last().unwrap_or(0)
}

/// Points in every direction, at the distance at which a ray of each angle meets level ground. Cells of
/// rays that meet it beyond the root are left out.
pub fn position_points(
    scene: &EncodingScene,
    magnitude_m: f64,
    axes: &SweepAxes,
    cells: &mut Vec<PositionCell>,
) -> Vec<SweepPoint> {
    let mut points = Vec::new();
    for (height_m, grazing_deg) in pairs(&axes.heights_m, &axes.grazing_deg) {
        let ground_m = height_m / grazing_deg.to_radians().tan();
        let distance_m = height_m.hypot(ground_m);
        for fov_deg in axes.fovs_deg.iter().copied() {
            let level = finest_level_shown(scene, distance_m, fov_deg);
            let cell = cells.len();
            let before = points.len();
            points.extend((0..axes.points).filter_map(|index| {
                let world = scene.eye() + around(index, ground_m);
                scene.contains(world).then_some(SweepPoint { cell, world, level })
            }));
            if points.len() > before {
                let cell =
                    PositionCell { magnitude_m, height_m, grazing_deg, fov_deg, level, distance_m };
                cells.push(cell);
            }
        }
    }
    points
}

/// Points of every level at all distances at which it is shown, half of them within four texels of a
/// tile's corner.
pub fn place_points(
    scene: &EncodingScene,
    magnitude_m: f64,
    axes: &SweepAxes,
    cells: &mut Vec<PlaceCell>,
) -> Vec<SweepPoint> {
    let mut points = Vec::new();
    for (level, fov_deg) in pairs(&axes.levels, &axes.fovs_deg) {
        let cell = cells.len();
        cells.push(PlaceCell { magnitude_m, level, fov_deg });
        let texel_m = scene.texel_size_m(level);
        let farthest_m = texel_m / (LEAST_TEXEL_PX * pixel_angle_rad(fov_deg));
        let nearest_m = (0.1 * texel_m).min(farthest_m);
        points.extend((0..axes.points).filter_map(|index| {
            let octaves = (farthest_m / nearest_m).log2();
            let distance_m = nearest_m * (octaves * spread(index, 0.618_034)).exp2();
            let mut world = scene.eye() + around(index, distance_m);
            if index % 2 == 0 {
                let beside_texels = 8.0 * (spread(index, 0.271_83) - 0.5);
                world = scene.near_corner(world, level, beside_texels);
            }
            scene.contains(world).then_some(SweepPoint { cell, world, level })
        }));
    }
    points
}

/// Points within a kilometre of the eye in tiles of every level: what is drawn while finer tiles are on
/// their way, or where there are none.
pub fn ground_points(
    scene: &EncodingScene,
    magnitude_m: f64,
    axes: &SweepAxes,
    cells: &mut Vec<GroundCell>,
) -> Vec<SweepPoint> {
    let mut points = Vec::new();
    for level in axes.levels.iter().copied() {
        let cell = cells.len();
        cells.push(GroundCell { magnitude_m, level, texel_m: scene.texel_size_m(level) });
        points.extend((0..axes.points).filter_map(|index| {
            let distance_m = 1000.0 * spread(index, 0.618_034);
            let world = scene.eye() + around(index, distance_m);
            scene.contains(world).then_some(SweepPoint { cell, world, level })
        }));
    }
    points
}

fn pairs<A: Copy, B: Copy>(first: &[A], second: &[B]) -> Vec<(A, B)> {
    first.iter().flat_map(|a| second.iter().map(move |b| (*a, *b))).collect()
}

fn around(index: usize, distance_m: f64) -> DVec2 {
    let angle = std::f64::consts::TAU * spread(index, 0.381_966);
    distance_m * dvec2(angle.cos(), angle.sin())
}
