//! Where the models of a scene stand, as well as the ground below them is known. No GPU.

use std::sync::Arc;

use super::GroundBelow;
use crate::CameraView;
use crate::dataset::Shape;
use crate::surface::models::{ModelPose, ModelScene, RelativePose};

/// The instances of a scene and their poses, model by model.
pub(super) struct StandingModels {
    scene: Arc<ModelScene>,
    /// The model of each instance and its place among the scene's instances, in the order of the models.
    order: Vec<(usize, usize)>,
    /// In the same order; empty before the first frame.
    poses: Vec<ModelPose>,
    /// The version of the ground and the exaggeration that the poses are for.
    stands_on: Option<(u64, f64)>,
    version: u64,
}

impl StandingModels {
    pub fn new(scene: Arc<ModelScene>) -> Self {
        let instances = scene.instances.iter().enumerate();
        let mut order: Vec<_> =
            instances.map(|(index, instance)| (instance.model, index)).collect();
        order.sort_unstable();
        Self { scene, order, poses: Vec::new(), stands_on: None, version: 0 }
    }

    pub fn scene(&self) -> &Arc<ModelScene> {
        &self.scene
    }

    /// Counts the changes of the poses.
    pub fn version(&self) -> u64 {
        self.version
    }

    /// Puts all instances on the ground, unless it is the same as it was.
    pub fn stand(&mut self, exaggeration: f64, ground: &GroundBelow<'_>) {
        let state = (ground.version, exaggeration);
        if self.stands_on == Some(state) {
            return;
        }
        self.stands_on = Some(state);
        let pose = |&(model, index): &(usize, usize)| {
            let (instance, model) = (&self.scene.instances[index], &self.scene.models[model]);
            let how = (ground.shape, exaggeration);
            let height_m = instance.origin_height_m(model, how, ground.height_m);
            ModelPose::new(instance, height_m)
        };
        let poses = self.order.iter().map(pose).collect::<Vec<_>>();
        self.version += u64::from(poses != self.poses);
        self.poses = poses;
    }

    /// The model of each instance that the view may show and its pose as seen from there, model by model.
    pub fn in_view(
        &self,
        view: &CameraView,
        shape: Shape,
    ) -> impl Iterator<Item = (usize, RelativePose)> {
        let all = self.order.iter().zip(&self.poses);
        let seen = all.map(move |(&(model, _), pose)| (model, pose.relative_to(view.eye, shape)));
        seen.filter(move |(model, pose)| {
            let (from_eye_m, radius_m) = pose.bounding_sphere(&self.scene.models[*model]);
            view.may_see_sphere(view.eye + from_eye_m, radius_m)
        })
    }
}
