use glam::{DVec2, Vec2, vec2};

use super::channels::{ChannelEffect, Channels, floor_weight};
use super::erosion::{ErodedGround, LEVELS, erode};
use super::grid::HeightGrid;
use super::gullies::Gullies;
use super::noise::{derived_seed, fractal_noise, gradient_noise, mixed, smooth_step};

/// The whole ground of a seed, known at every point.
///
/// Points are metres east (x) and south (y) of its north-west corner; the ground is a square of
/// [`GROUND_SIZE_M`](super::grid::GROUND_SIZE_M). Heights follow an eroded grid, the beds of its
/// streams and gullies too fine for the grid.
#[derive(Debug)]
pub struct Ground {
    grid: HeightGrid,
    channels: Channels,
    seed: u32,
}

/// The ground at a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GroundPoint {
    /// Metres above the datum.
    pub height_m: f32,
    /// -1 in a gully, 1 on a rib between gullies, 0 on even ground.
    pub rib: f32,
    /// 1 on the floor of a valley, 0 away from it.
    pub floor: f32,
    /// Metres from the nearest water's edge, negative in it; at most 10,000.
    pub to_water_m: f32,
    /// By how many metres the point is bent out of its place in the eroded grid.
    pub bend_m: Vec2,
    /// How moist the climate is, about 0 to 1.
    pub moisture: f32,
    /// Irregularity of the plant cover over hundreds of metres, about -1 to 1.
    pub patch: f32,
}

impl Ground {
    /// Makes the ground of a seed. `advanced` hears which share of the work is done; where it says
    /// no, there is no ground.
    pub fn new(seed: u32, advanced: impl FnMut(f64) -> bool) -> Option<Self> {
        Some(Self::on(erode(seed, LEVELS, advanced)?, seed))
    }

    /// The ground on an eroded grid.
    pub fn on(eroded: ErodedGround, seed: u32) -> Self {
        let channels = Channels::of(&eroded, derived_seed(seed, 20));
        Self { grid: eroded.grid, channels, seed }
    }

    /// The ground at a point.
    pub fn at(&self, point_m: DVec2) -> GroundPoint {
        let bend_m = self.bend_m(point_m);
        let place_m = point_m + bend_m.as_dvec2();
        let (base_m, gradient) = self.grid.smooth_height(place_m);
        let streams = self.channels.effect(place_m, base_m);
        let away = 1.0 - floor_weight(streams.floor);
        let gullies = Gullies::on_slope(place_m, gradient, away, derived_seed(self.seed, 21));
        let noise = |purpose: u32, wavelength_m: f64, octaves: u32| {
            let seed = derived_seed(self.seed, purpose);
            fractal_noise(point_m / wavelength_m, octaves, seed)
        };
        let patch = noise(22, 900.0, 4);
        let added_m = gullies.height_m + away * self.roughness_m(point_m, base_m);
        GroundPoint {
            height_m: streams.height_m + added_m,
            rib: gullies.rib,
            floor: streams.floor,
            to_water_m: streams.to_water_m,
            bend_m,
            moisture: (0.5 + 0.5 * noise(24, 26_000.0, 3)).clamp(0.0, 1.0),
            patch,
        }
    }

    /// Metres from the nearest water's edge, at a point with this bend.
    pub fn to_water_m(&self, point_m: DVec2, bend_m: Vec2) -> f32 {
        self.channels.to_water_m(point_m + bend_m.as_dvec2())
    }

    /// What neither rivers nor gullies make: slight unevenness, and crags and notches up where frost
    /// breaks the rock.
    fn roughness_m(&self, point_m: DVec2, height_m: f32) -> f32 {
        let frost = smooth_step(3_900.0, 5_000.0, height_m);
        let mut roughness_m = gradient_noise(point_m / 70.0, derived_seed(self.seed, 23));
        if frost > 0.0 {
            for (octave, wavelength_m) in [640.0, 290.0, 130.0].into_iter().enumerate() {
                let seed = derived_seed(self.seed, 25 + octave as u32);
                let crag = 0.4 - gradient_noise(point_m / wavelength_m, seed).abs();
                roughness_m += 0.16 * frost * wavelength_m as f32 * crag;
            }
        }
        roughness_m
    }

    /// Bends the ground, so that nothing shows the directions of the grid. Bends are so gentle that
    /// no two points fall on one: what drained before still does.
    fn bend_m(&self, point_m: DVec2) -> Vec2 {
        let along = |purpose: u32| {
            let noise = |wavelength_m: f64, purpose: u32| {
                gradient_noise(point_m / wavelength_m, derived_seed(self.seed, purpose))
            };
            170.0 * noise(3_100.0, purpose) + 45.0 * noise(870.0, purpose + 1)
        };
        vec2(along(30), along(40))
    }
}

impl GroundPoint {
    /// A point between two others: `weight` 0 is this one, 1 the other.
    pub fn mixed(&self, other: &Self, weight: f32) -> Self {
        let mixed = |a: f32, b: f32| mixed(a, b, weight);
        Self {
            height_m: mixed(self.height_m, other.height_m),
            rib: mixed(self.rib, other.rib),
            floor: mixed(self.floor, other.floor),
            to_water_m: mixed(self.to_water_m, other.to_water_m),
            bend_m: self.bend_m.lerp(other.bend_m, weight),
            moisture: mixed(self.moisture, other.moisture),
            patch: mixed(self.patch, other.patch),
        }
    }

    /// Whether water may be near enough to be seen between this point and its neighbours.
    pub fn is_near_water(&self) -> bool {
        self.to_water_m < 0.01 * ChannelEffect::FAR_M
    }
}
