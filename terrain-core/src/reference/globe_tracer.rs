use glam::{DMat3, DVec2, DVec3, Vec3, dvec2, dvec3};

use super::ReferenceSettings;
use super::camera_rays::CameraRays;
use super::footprint::{Footprint, ground_step};
use super::scene::ReferenceScene;
use super::shading::Shading;
use super::tracer::{Seen, Tracer};
use crate::CameraView;
use crate::geodesy::{Geodetic, PlateCarree, Wgs84};
use crate::surface::globe::{GlobeAir, GlobeGround};

/// One view of a globe.
///
/// Ground without any height is the ellipsoid, met exactly. Heights are met by steps along the ray: no longer than
/// the height above the ground allows, since no ground is steeper than the whole range of heights over the distance
/// of two samples, and at the least [`Self::LEAST_STEP`] of that distance; where a step ends below the ground, halving
/// finds the place. A peak that a ray passes within such a step may be missed.
pub(super) struct GlobeTracer<'a> {
    scene: &'a ReferenceScene,
    settings: ReferenceSettings,
    rays: CameraRays,
    shading: Shading,
    air: GlobeAir,
    eye_ecef: DVec3,
    eye_height_m: f64,
    ecef_from_local: DMat3,
    /// Lowest and highest ground, exaggerated.
    range_m: [f64; 2],
    /// Metres between samples, and metres that a metre above the ground is certainly away from it along any ray.
    texel_m: f64,
    least_way: f64,
}

/// Where a ray meets the globe.
struct GlobeHit {
    /// In the eye's axes.
    relative_m: DVec3,
    distance_m: f64,
    at: Geodetic,
}

impl<'a> GlobeTracer<'a> {
    /// The least step in parts of the distance between samples.
    const LEAST_STEP: f64 = 1.0 / 64.0;
    const HALVINGS: u32 = 40;

    pub fn new(scene: &'a ReferenceScene, view: &CameraView, settings: &ReferenceSettings) -> Self {
        let within = GlobeGround::within(view.eye.truncate()).extend(view.eye.z);
        let eye = Geodetic::from_plate_carree(within);
        let exaggeration = settings.vertical_exaggeration;
        let range_m = scene.range_m.map(|height_m| height_m * exaggeration);
        let layout = &scene.tree.heights.layout;
        let texel_m = layout.texel_size_m(&scene.tree.scheme, layout.finest_level());
        let steepest = (range_m[1] - range_m[0]) / texel_m;
        Self {
            scene,
            settings: *settings,
            rays: CameraRays::new(view),
            shading: Shading::new(view, &scene.tree, settings),
            air: GlobeAir::new(&eye, exaggeration),
            eye_ecef: Wgs84::ecef_from_geodetic(&eye),
            eye_height_m: eye.height_m,
            ecef_from_local: eye.ecef_from_local(),
            range_m,
            texel_m,
            least_way: 1.0 / (1.0 + 2.0 * steepest),
        }
    }

    fn is_level(&self) -> bool {
        self.range_m == [0.0; 2]
    }

    /// The part of a ray within the ellipsoid raised by so much, metres along the unit direction.
    fn within_ellipsoid(&self, direction: DVec3, raised_m: f64) -> Option<[f64; 2]> {
        let (a, b) = (Wgs84::EQUATOR_RADIUS_M + raised_m, Wgs84::POLAR_RADIUS_M + raised_m);
        let axes = dvec3(a, a, b);
        let (from, along) = (self.eye_ecef / axes, (self.ecef_from_local * direction) / axes);
        let square = along.length_squared();
        let nearest = -from.dot(along) / square;
        let low = from + nearest * along;
        // 1 - |low|^2 without the square of a number near 1.
        let half = (1.0 - low.length()) * (1.0 + low.length()) / square;
        (half >= 0.0).then(|| [nearest - half.sqrt(), nearest + half.sqrt()])
    }

    fn at(&self, direction: DVec3, distance_m: f64) -> Geodetic {
        let place = self.eye_ecef + self.ecef_from_local * (direction * distance_m);
        Wgs84::geodetic_from_ecef(place)
    }

    fn ground_m(&self, at: &Geodetic) -> f64 {
        let height_m = self.scene.height_m(GlobeGround::within(at.plate_carree()));
        height_m.unwrap_or(0.0) * self.settings.vertical_exaggeration
    }

    fn hit(&self, direction: DVec3) -> Option<GlobeHit> {
        let direction = direction.normalize();
        let distance_m = match self.is_level() {
            true => {
                let [first, _] = self.within_ellipsoid(direction, 0.0)?;
                (first >= 0.0).then_some(first)?
            }
            false => self.first_below(direction)?,
        };
        let at = self.at(direction, distance_m);
        Some(GlobeHit { relative_m: direction * distance_m, distance_m, at })
    }

    /// Metres along a unit direction to where the ray first goes below the ground.
    fn first_below(&self, direction: DVec3) -> Option<f64> {
        // The ellipsoid's normals spread, so that one raised evenly is not quite one of larger axes: a metre more.
        let [enter, leave] = self.within_ellipsoid(direction, self.range_m[1] + 1.0)?;
        let mut above = enter.max(0.0);
        let above_ground_m = |distance_m: f64| {
            let at = self.at(direction, distance_m);
            at.height_m - self.ground_m(&at)
        };
        let mut gap_m = above_ground_m(above);
        if gap_m < 0.0 {
            return None;
        }
        while above < leave {
            let step_m = (gap_m * self.least_way).max(self.texel_m * Self::LEAST_STEP);
            let next = above + step_m;
            gap_m = above_ground_m(next);
            if gap_m < 0.0 {
                return Some(self.halved(above_ground_m, [above, next]));
            }
            above = next;
        }
        None
    }

    fn halved(&self, above_ground_m: impl Fn(f64) -> f64, [mut above, mut below]: [f64; 2]) -> f64 {
        for _ in 0..Self::HALVINGS {
            let middle = 0.5 * (above + below);
            match above_ground_m(middle) < 0.0 {
                true => below = middle,
                false => above = middle,
            }
        }
        0.5 * (above + below)
    }

    /// Metres up per metre east and north that are lit, without exaggeration.
    fn slope(&self, at: &Geodetic) -> DVec2 {
        if self.is_level() {
            return DVec2::ZERO;
        }
        let on_map = self.scene.lit_slope(GlobeGround::within(at.plate_carree()));
        let (sin_lat, cos_lat) = at.latitude_rad.sin_cos();
        let east_m = Wgs84::normal_radius_m(sin_lat) * cos_lat.max(1.0e-6);
        on_map * PlateCarree::RADIUS_M / dvec2(east_m, Wgs84::meridian_radius_m(sin_lat))
    }

    /// The ground under a square of the picture around a ray in metres east and north, as long as texels of the
    /// equator have there: on the plane that touches the surface where the ray meets it.
    fn footprint(&self, hit: &GlobeHit, slope: DVec2, direction: DVec3, side_px: f64) -> Footprint {
        let steep = slope * self.settings.vertical_exaggeration;
        let normal = DVec3::new(-steep.x, -steep.y, 1.0);
        let there_from_eye = hit.at.ecef_from_local().transpose() * self.ecef_from_local;
        let (way, along) = (hit.distance_m / direction.length(), there_from_eye * direction);
        let sin_lat = hit.at.latitude_rad.sin();
        let radii_m = dvec2(Wgs84::normal_radius_m(sin_lat), Wgs84::meridian_radius_m(sin_lat));
        let scale = PlateCarree::RADIUS_M / (radii_m + hit.at.height_m);
        let side = |step: DVec3| {
            ground_step(along, there_from_eye * (step * side_px), normal, way) * scale
        };
        Footprint::of_parallelogram(side(self.rays.step_right), side(self.rays.step_down))
    }
}

impl Tracer for GlobeTracer<'_> {
    fn seen(&self, direction: DVec3) -> Option<Seen> {
        let GlobeHit { relative_m, distance_m, .. } = self.hit(direction)?;
        Some(Seen { point: self.rays.eye + relative_m, distance_m })
    }

    fn colour(&self, position: DVec2, side_px: f64) -> Vec3 {
        let direction = self.rays.direction(position.x, position.y);
        let Some(hit) = self.hit(direction) else {
            return self.air.sky(direction.normalize()).as_vec3();
        };
        let slope = self.slope(&hit.at);
        let imagery = self.scene.imagery.as_ref().map_or((Vec3::ZERO, 0.0), |imagery| {
            let footprint = self.footprint(&hit, slope, direction, side_px);
            let on_map = GlobeGround::within(hit.at.plate_carree());
            let cos_latitude = hit.at.latitude_rad.cos();
            imagery.mean_on_globe(on_map, &footprint, cos_latitude, self.settings.finest_imagery)
        });
        let above_eye_m = (hit.at.height_m - self.eye_height_m) as f32;
        let lit = self.shading.lit_ground(above_eye_m, slope, imagery);
        let clear = self.air.clear(hit.relative_m).as_vec3();
        self.shading.haze() * (Vec3::ONE - clear) + lit * clear
    }
}
