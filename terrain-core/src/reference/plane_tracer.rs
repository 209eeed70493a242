use glam::{DVec2, DVec3, Vec3};

use super::ReferenceSettings;
use super::camera_rays::CameraRays;
use super::footprint::{Footprint, ground_step};
use super::scene::{ReferenceScene, SurfaceHit};
use super::shading::Shading;
use super::tracer::{Seen, Tracer};
use crate::CameraView;

/// One view of plane ground.
pub(super) struct PlaneTracer<'a> {
    scene: &'a ReferenceScene,
    settings: ReferenceSettings,
    rays: CameraRays,
    shading: Shading,
}

impl<'a> PlaneTracer<'a> {
    pub fn new(scene: &'a ReferenceScene, view: &CameraView, settings: &ReferenceSettings) -> Self {
        Self {
            scene,
            settings: *settings,
            rays: CameraRays::new(view),
            shading: Shading::new(view, &scene.tree, settings),
        }
    }

    fn hit(&self, direction: DVec3) -> Option<SurfaceHit> {
        self.scene.first_hit(self.rays.eye, direction, self.settings.vertical_exaggeration)
    }

    /// The ground under a square of the picture around a ray: on the plane that touches the surface
    /// where the ray meets it.
    fn footprint(&self, direction: DVec3, hit: &SurfaceHit, side_px: f64) -> Footprint {
        let steep = hit.slope * self.settings.vertical_exaggeration;
        let normal = DVec3::new(-steep.x, -steep.y, 1.0);
        let way = hit.distance_m / direction.length();
        let side = |step: DVec3| ground_step(direction, step * side_px, normal, way);
        Footprint::of_parallelogram(side(self.rays.step_right), side(self.rays.step_down))
    }
}

impl Tracer for PlaneTracer<'_> {
    fn seen(&self, direction: DVec3) -> Option<Seen> {
        self.hit(direction).map(|hit| Seen { point: hit.point, distance_m: hit.distance_m })
    }

    fn colour(&self, position: DVec2, side_px: f64) -> Vec3 {
        let direction = self.rays.direction(position.x, position.y);
        let Some(hit) = self.hit(direction) else {
            return self.shading.background(direction.normalize());
        };
        let on_map = hit.point.truncate();
        let imagery = self.scene.imagery.as_ref().map_or((Vec3::ZERO, 0.0), |imagery| {
            let footprint = self.footprint(direction, &hit, side_px);
            imagery.mean_under(on_map, &footprint, self.settings.finest_imagery)
        });
        self.shading.ground(hit.point - self.rays.eye, self.scene.lit_slope(on_map), imagery)
    }
}
