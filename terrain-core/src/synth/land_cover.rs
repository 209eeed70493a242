use glam::{DVec2, Vec2, Vec3, vec3};

use super::channels::floor_weight;
use super::ground::GroundPoint;
use super::noise::{
    cell_of, derived_seed, fractal_noise, gradient_noise, hash, smooth_step, unit, unit_pair,
};

/// What a camera above sees at a point.
#[derive(Clone, Copy, Debug)]
pub struct LandCover {
    seed: u32,
}

/// What the colour of a point follows.
#[derive(Clone, Copy, Debug)]
pub struct CoverPoint {
    /// The ground there; `to_water_m` exact to the metre.
    pub ground: GroundPoint,
    /// Gradient of the height, metres a metre, along east and south.
    pub gradient: Vec2,
}

const fn srgb(red: u8, green: u8, blue: u8) -> Vec3 {
    vec3(red as f32, green as f32, blue as f32)
}

const BROADLEAF: Vec3 = srgb(66, 84, 48);
const CONIFERS: Vec3 = srgb(48, 64, 45);
const SHRUBS: Vec3 = srgb(118, 112, 76);
const MEADOW: Vec3 = srgb(112, 114, 70);
const ALPINE_TURF: Vec3 = srgb(126, 117, 84);
const ROCK: Vec3 = srgb(112, 107, 102);
const SCREE: Vec3 = srgb(151, 144, 134);
const SNOW: Vec3 = srgb(240, 244, 250);
const WATER: Vec3 = srgb(84, 108, 104);
const GRAVEL: Vec3 = srgb(168, 162, 148);
const ROOFS: Vec3 = srgb(170, 160, 152);
const FIELDS: [Vec3; 6] = [
    srgb(88, 108, 58),
    srgb(112, 126, 70),
    srgb(140, 138, 86),
    srgb(74, 96, 56),
    srgb(156, 138, 100),
    srgb(98, 116, 78),
];

impl LandCover {
    /// Cover with the irregularities of a seed.
    pub fn new(seed: u32) -> Self {
        Self { seed }
    }

    /// The sRGB colour at a point in metres east and south of the ground's corner.
    ///
    /// Belts by height as in western Sichuan: fields and broadleaved forest, shrubs in dry valleys,
    /// conifers up to 3800 m and lower on sunny slopes, alpine turf, rock, and snow from 5000 m.
    pub fn colour(&self, point_m: DVec2, at: &CoverPoint) -> [u8; 3] {
        let texture = self.texture(point_m);
        let site = Site::of(at, texture);
        let mut colour = self.woods(&site, texture);
        let farmed = site.farmed();
        if farmed > 0.0 {
            colour = colour.lerp(self.fields(point_m, texture), farmed);
        }
        colour = colour.lerp(turf(&site, texture), site.above_trees());
        let stones = ROCK.lerp(SCREE, smooth_step(0.35, -0.35, site.rib + 0.6 * texture));
        colour = colour.lerp(stones * (1.0 + 0.26 * texture), site.bare());
        colour = colour.lerp(SNOW * (1.0 - 0.03 * texture.abs()), site.snow());
        // Less sky reaches hollows.
        colour *= 1.0 + 0.10 * site.rib;
        colour = self.with_water(colour, at.ground.to_water_m, &site, texture);
        let grain =
            unit(hash((point_m.x / 10.0) as i32, (point_m.y / 10.0) as i32, self.seed)) - 0.5;
        let grained = colour * (1.0 + 0.12 * grain) + 0.5;
        grained.clamp(Vec3::ZERO, Vec3::splat(255.0)).to_array().map(|part| part as u8)
    }

    /// Irregularity of tens of metres, about -1 to 1.
    fn texture(&self, point_m: DVec2) -> f32 {
        fractal_noise(point_m / 42.0, 2, derived_seed(self.seed, 1))
    }

    fn woods(&self, site: &Site, texture: f32) -> Vec3 {
        let conifers = smooth_step(2_100.0, 2_900.0, site.belt_m);
        let trees = BROADLEAF.lerp(CONIFERS, conifers);
        let trees = trees * (1.0 + 0.26 * texture + 0.12 * site.patch - 0.10 * site.northness);
        let open = smooth_step(0.34, 0.74, site.dryness + 0.22 * texture + 0.25 * site.patch);
        let grass = SHRUBS.lerp(MEADOW, smooth_step(1_900.0, 3_000.0, site.belt_m));
        trees.lerp(grass * (1.0 + 0.10 * texture), open)
    }

    /// Parcels of 40 to 120 m, hamlets among them.
    fn fields(&self, point_m: DVec2, texture: f32) -> Vec3 {
        let (parcel, to_edge) = self.parcel(point_m);
        let crop = FIELDS[parcel as usize % FIELDS.len()];
        let shade = 0.92 + 0.16 * unit(parcel.rotate_left(9));
        let hedge = smooth_step(0.10, 0.02, to_edge);
        let field = (crop * shade * (1.0 + 0.04 * texture)).lerp(BROADLEAF, 0.5 * hedge);
        let hamlets = gradient_noise(point_m / 520.0, derived_seed(self.seed, 3));
        let roofs = smooth_step(0.42, 0.55, hamlets + 0.25 * texture);
        field.lerp(ROOFS * (0.8 + 0.35 * unit(parcel.rotate_left(17))), 0.75 * roofs)
    }

    /// The parcel around a point: a number of its own, and how far its edge is, in parcels.
    fn parcel(&self, point_m: DVec2) -> (u32, f32) {
        let seed = derived_seed(self.seed, 2);
        // Parcels follow the lie of the land, which turns from place to place.
        let turn = gradient_noise(point_m / 2_600.0, derived_seed(self.seed, 4));
        let bent_m = point_m + DVec2::new(f64::from(turn), -f64::from(turn)) * 240.0;
        let place = DVec2::new(bent_m.x / 92.0, bent_m.y / 58.0);
        let (x, y, at) = cell_of(place);
        let (mut nearest, mut second, mut parcel) = (f32::MAX, f32::MAX, 0);
        for (dx, dy) in (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy))) {
            let bits = hash(x + dx, y + dy, seed);
            let centre = Vec2::new(dx as f32, dy as f32) + 0.2 + 0.6 * unit_pair(bits);
            // Parcels have straight sides along and across.
            let distance = (at - centre).abs().element_sum();
            if distance < nearest {
                (second, nearest, parcel) = (nearest, distance, bits);
            } else if distance < second {
                second = distance;
            }
        }
        (parcel >> 4, second - nearest)
    }

    fn with_water(&self, colour: Vec3, to_water_m: f32, site: &Site, texture: f32) -> Vec3 {
        let bars = smooth_step(30.0, 4.0, to_water_m + 24.0 * texture - 20.0 * site.patch);
        let colour = colour.lerp(GRAVEL, 0.6 * bars * smooth_step(0.5, 1.0, site.floor));
        colour.lerp(WATER, smooth_step(5.0, -5.0, to_water_m))
    }
}

/// What decides between covers.
struct Site {
    height_m: f32,
    /// Height that the climate here feels like: lower on shaded slopes and in moist places.
    belt_m: f32,
    slope: f32,
    /// 1 on slopes that face north, -1 on those that face south.
    northness: f32,
    dryness: f32,
    rib: f32,
    patch: f32,
    floor: f32,
}

impl Site {
    fn of(at: &CoverPoint, texture: f32) -> Self {
        let GroundPoint { height_m, rib, patch, moisture, floor, .. } = at.ground;
        let slope = at.gradient.length();
        // Height falls towards the north where it grows towards the south (y).
        let northness = at.gradient.y / (slope * slope + 0.04).sqrt();
        let belt_m = height_m - 130.0 * northness + 190.0 * patch + 60.0 * texture;
        let inner_valley = smooth_step(2_700.0, 1_500.0, height_m) * smooth_step(0.2, 0.5, slope);
        let dryness = 0.62 - 0.75 * moisture - 0.30 * northness + 0.18 * inner_valley + 0.10 * rib;
        Self { height_m, belt_m, slope, northness, dryness, rib, patch, floor }
    }

    fn farmed(&self) -> f32 {
        let gentle = smooth_step(0.24, 0.12, self.slope + 0.06 * self.patch);
        let terraces = smooth_step(0.42, 0.28, self.slope) * smooth_step(0.15, 0.45, self.patch);
        let valley = floor_weight(self.floor).max(smooth_step(900.0, 650.0, self.height_m));
        let near = valley.max(0.8 * terraces);
        gentle.max(terraces) * near * smooth_step(2_900.0, 2_300.0, self.belt_m)
    }

    fn above_trees(&self) -> f32 {
        smooth_step(3_650.0, 3_900.0, self.belt_m)
    }

    /// Rock and scree: where it is steep, and ever more with height.
    fn bare(&self) -> f32 {
        let high = smooth_step(3_900.0, 4_800.0, self.belt_m + 300.0 * self.rib);
        let steepness_needed = 1.4 - 1.05 * high;
        let steep = smooth_step(steepness_needed - 0.15, steepness_needed + 0.2, self.slope);
        steep.max(smooth_step(0.75, 1.0, high))
    }

    fn snow(&self) -> f32 {
        let line_m = self.height_m + 230.0 * self.northness + 120.0 * self.patch - 150.0 * self.rib;
        smooth_step(4_750.0, 5_150.0, line_m - 420.0 * (self.slope - 0.7).max(0.0))
    }
}

fn turf(site: &Site, texture: f32) -> Vec3 {
    let high = smooth_step(3_900.0, 4_600.0, site.belt_m);
    MEADOW.lerp(ALPINE_TURF, high) * (1.0 + 0.09 * texture + 0.08 * site.patch)
}
