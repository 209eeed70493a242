use glam::{DMat3, DVec2, DVec3, Vec3, Vec4, dvec2};

use super::model::Model;
use crate::dataset::Shape;
use crate::geodesy::{Geodetic, PlateCarree, Wgs84};

/// A model that stands somewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModelInstance {
    /// Index among the scene's models.
    pub model: usize,
    /// x and y of its origin in the dataset's CRS.
    pub place: DVec2,
    /// How high it stands.
    pub standing: Standing,
    /// Degrees clockwise from grid north; at 0 the file's -z points north.
    pub heading_deg: f64,
    /// Metres a unit of the file; above 0.
    pub scale: f64,
}

/// How high a model stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Standing {
    /// With its origin so many metres above the datum.
    Height(f64),
    /// With its lowest point on the ground: on the lowest ground below its bounds, so that no part of it hangs in
    /// the air on a slope.
    OnGround,
}

/// Where an instance is and how it is turned: world coordinates are x and y of the CRS and metres above the datum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModelPose {
    /// Place of the model's origin.
    pub origin: DVec3,
    /// Local metres to world metres: heading and scale.
    linear: DMat3,
    scale: f64,
}

impl ModelPose {
    /// Of an instance whose origin is at this height.
    pub fn new(instance: &ModelInstance, height_m: f64) -> Self {
        let heading = DMat3::from_rotation_z(-instance.heading_deg.to_radians());
        Self {
            origin: instance.place.extend(height_m),
            linear: heading * instance.scale,
            scale: instance.scale,
        }
    }

    /// The world place of a point of the model.
    pub fn world_from_local(&self, local_m: Vec3) -> DVec3 {
        self.origin + self.linear * local_m.as_dvec3()
    }

    /// The pose as seen from an eye: in metres along its own east, north and up. On a globe a model stands upright
    /// where it is, and the eye's axes are others.
    pub fn relative_to(&self, eye: DVec3, shape: Shape) -> RelativePose {
        if shape == Shape::Plane {
            let from_eye_m = self.origin - eye;
            return RelativePose { linear: self.linear, from_eye_m, scale: self.scale };
        }
        let [place, eye] = [self.origin, eye].map(Geodetic::from_plate_carree);
        let relative_from_ecef = eye.ecef_from_local().transpose();
        let [at, from] = [place, eye].map(|place| Wgs84::ecef_from_geodetic(&place));
        RelativePose {
            linear: relative_from_ecef * place.ecef_from_local() * self.linear,
            from_eye_m: relative_from_ecef * (at - from),
            scale: self.scale,
        }
    }
}

/// Where an instance is as seen from an eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelativePose {
    /// The model's metres to metres along the eye's axes.
    linear: DMat3,
    from_eye_m: DVec3,
    scale: f64,
}

impl RelativePose {
    /// The rows of the matrix that turns the model's points into metres relative to the eye.
    pub fn rows(&self) -> [Vec4; 3] {
        [0, 1, 2].map(|axis| self.linear.row(axis).extend(self.from_eye_m[axis]).as_vec4())
    }

    /// A sphere that holds the model: its centre relative to the eye and its radius in metres.
    pub fn bounding_sphere(&self, model: &Model) -> (DVec3, f64) {
        let [low, high] = model.bounds_m.map(Vec3::as_dvec3);
        let radius_m = 0.5 * (high - low).length() * self.scale;
        (self.from_eye_m + self.linear * (0.5 * (low + high)), radius_m)
    }
}

impl ModelInstance {
    /// Points of the ground, three by three, under the rectangle that the model covers.
    pub fn footprint(&self, model: &Model, shape: Shape) -> [DVec2; 9] {
        let pose = ModelPose::new(self, 0.0);
        let [low, high] = model.bounds_m.map(Vec3::as_dvec3);
        let crs_per_m = match shape {
            Shape::Plane => DVec2::ONE,
            // Circles of latitude shrink towards the poles; how flat the earth is does not matter here.
            Shape::Globe => dvec2((self.place.y / PlateCarree::RADIUS_M).cos().recip(), 1.0),
        };
        std::array::from_fn(|index| {
            let part = dvec2((index % 3) as f64, (index / 3) as f64) * 0.5;
            let local = low.truncate() + part * (high - low).truncate();
            let offset_m = pose.world_from_local(local.extend(0.0).as_vec3()) - pose.origin;
            self.place + offset_m.truncate() * crs_per_m
        })
    }

    /// Height of the origin in metres above the datum over ground that is drawn exaggerated: the ground is raised,
    /// the model's own size is not. `ground_height_m` tells true heights, `None` where there is none; a model on no
    /// ground stands at height 0.
    pub fn origin_height_m(
        &self,
        model: &Model,
        (shape, exaggeration): (Shape, f64),
        ground_height_m: impl Fn(DVec2) -> Option<f64>,
    ) -> f64 {
        match self.standing {
            Standing::Height(height_m) => height_m * exaggeration,
            Standing::OnGround => {
                let below = self.footprint(model, shape).into_iter().filter_map(ground_height_m);
                let lowest_m = below.reduce(f64::min).unwrap_or(0.0);
                lowest_m * exaggeration - f64::from(model.bounds_m[0].z) * self.scale
            }
        }
    }
}
