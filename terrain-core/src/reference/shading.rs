//! Light, air and sky: what the shaders compute a pixel from, on the CPU. Their numbers are those of
//! the frame's own uniforms. A test holds whole pictures of both against each other.

use glam::{DVec2, DVec3, Vec3};

use super::ReferenceSettings;
use crate::CameraView;
use crate::frame_setup::frame_uniforms;
use crate::gpu::FrameUniforms;
use crate::renderer_settings::RendererSettings;
use crate::selection::TileTree;

/// Tints of the lowest and the highest ground where there is no imagery, in linear light.
const LOW_TINT: Vec3 = Vec3::new(0.19, 0.30, 0.15);
const HIGH_TINT: Vec3 = Vec3::new(0.80, 0.76, 0.70);

/// What colours a ray in one view.
pub(super) struct Shading {
    frame: FrameUniforms,
}

impl Shading {
    pub fn new(view: &CameraView, tree: &TileTree, settings: &ReferenceSettings) -> Self {
        let settings = RendererSettings {
            vertical_exaggeration: settings.vertical_exaggeration,
            shading_strength: settings.shading_strength,
            ..RendererSettings::default()
        };
        // The scale of the mesh colours nothing.
        Self { frame: frame_uniforms(view, tree, &settings, 1.0) }
    }

    /// Linear light of lit ground `relative` to the eye (metres), whose slope is given without
    /// exaggeration, seen through the air. `imagery` is weighted by `coverage`.
    pub fn ground(&self, relative: DVec3, slope: DVec2, (imagery, coverage): (Vec3, f32)) -> Vec3 {
        let lit = self.lit_ground(relative.z as f32, slope, (imagery, coverage));
        let clear = self.transmittance(relative.as_vec3());
        self.frame.haze_colour.lerp(lit, clear)
    }

    /// The same without the air; `above_eye_m` is how far the ground is above the eye.
    pub fn lit_ground(
        &self,
        above_eye_m: f32,
        slope: DVec2,
        (imagery, coverage): (Vec3, f32),
    ) -> Vec3 {
        (imagery + self.tint(above_eye_m) * (1.0 - coverage)) * self.light(slope)
    }

    /// Linear light of the haze.
    pub fn haze(&self) -> Vec3 {
        self.frame.haze_colour
    }

    /// Linear light where there is no ground, in a direction of length 1.
    pub fn background(&self, direction: DVec3) -> Vec3 {
        let z = direction.z as f32;
        let zenith = if z >= 0.0 {
            1.0 - (1.0 - z.min(1.0)).powi(4)
        } else {
            0.7 * (1.0 - (1.0 + z.max(-1.0)).powi(2))
        };
        self.frame.haze_colour.lerp(self.frame.zenith_colour, zenith)
    }

    fn tint(&self, relative_z_m: f32) -> Vec3 {
        let part = (relative_z_m * self.frame.tint_per_m + self.frame.tint_at_eye).clamp(0.0, 1.0);
        LOW_TINT.lerp(HIGH_TINT, part)
    }

    fn light(&self, slope: DVec2) -> f32 {
        let steep = slope * f64::from(self.frame.vertical_exaggeration);
        let normal = DVec3::new(-steep.x, -steep.y, 1.0).normalize().as_vec3();
        let ambient = 0.35 + 0.15 * normal.z;
        let direct = normal.dot(self.frame.sun_direction).max(0.0);
        let level = 0.5 + self.frame.sun_direction.z;
        1.0 + ((ambient + direct) / level - 1.0) * self.frame.shading_strength
    }

    fn transmittance(&self, relative_m: Vec3) -> f32 {
        let frame = &self.frame;
        let eye = frame.eye_height_above_base_m.max(0.0) / frame.haze_scale_height_m;
        let ground = frame.eye_height_above_base_m + relative_m.z;
        let ground = ground.max(0.0) / frame.haze_scale_height_m;
        let rise = ground - eye;
        let mean = if rise.abs() < 1e-3 {
            (-0.5 * (eye + ground)).exp()
        } else {
            ((-eye).exp() - (-ground).exp()) / rise
        };
        (-relative_m.length() / frame.haze_distance_m * mean).exp()
    }
}
