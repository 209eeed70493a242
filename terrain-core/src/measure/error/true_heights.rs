use glam::DVec3;
use rayon::prelude::*;

use crate::reference::ReferenceScene;

/// The height of the exact surface at x and y of each point, times the vertical exaggeration; not a
/// number where the point is none or the surface has no ground.
pub fn true_heights_m(
    scene: &ReferenceScene,
    ground: &[DVec3],
    vertical_exaggeration: f64,
) -> Vec<f64> {
    let height_m = |point: &DVec3| {
        let point = Some(point.truncate()).filter(|point| point.is_finite());
        point
            .and_then(|point| scene.height_m(point))
            .map_or(f64::NAN, |h| h * vertical_exaggeration)
    };
    ground.par_iter().map(height_m).collect()
}
