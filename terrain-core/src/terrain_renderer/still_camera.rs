//! What takes several frames of a still camera: waiting until nothing is missing, and the coordinates
//! of every pixel.

use std::time::Duration;

use glam::{DVec3, dvec3};

use super::{RenderError, TerrainRenderer};
use crate::CameraView;
use crate::gpu::{CoordinatePass, read_texture};
use crate::measure::FrameRecord;

impl TerrainRenderer {
    /// Where on the ground each pixel of the view looks, after drawing until nothing is missing:
    /// x, y in the dataset's CRS and the height drawn (exaggeration included), row by row from the
    /// top left, NaN where there is sky. From the same mesh and tiles as the picture.
    ///
    /// # Errors
    /// [`RenderError::Gpu`] where the device has failed.
    pub fn ground_coordinates(&mut self, view: &CameraView) -> Result<Vec<[f64; 3]>, RenderError> {
        self.settle(view)?;
        let mut encoder = self.encoder();
        let scene = self.scene(view);
        self.set_up(&scene);
        self.displace(&mut encoder, &scene, false, false);
        let format = CoordinatePass::FULL_FORMAT;
        let pass = CoordinatePass::new(&self.gpu.device, &self.bindings, format, view.viewport_px);
        if let Some(mesh) = self.meshes.picture() {
            pass.record(&mut encoder, &self.bindings, mesh.parts(), mesh.visible());
        }
        self.gpu.queue.submit([encoder.finish()]);
        let bytes = read_texture(&self.gpu, &pass.target, view.viewport_px, 16)?;
        let world = |[x, y, z, ground]: [f32; 4]| {
            let offset = dvec3(f64::from(x), f64::from(y), f64::from(z));
            let point = if ground == 0.0 { DVec3::NAN } else { view.eye + offset };
            point.to_array()
        };
        Ok(bytemuck::pod_collect_to_vec::<u8, [f32; 4]>(&bytes).into_iter().map(world).collect())
    }

    /// Draws frames without a picture until nothing is missing.
    pub(super) fn settle(&mut self, view: &CameraView) -> Result<FrameRecord, RenderError> {
        // Each round brings at least one tile or image; a scene needs a few dozen.
        const MOST_FRAMES: u32 = 2_000;
        const PATIENCE: Duration = Duration::from_millis(50);
        let mut sum = self.frame(view, None)?;
        for _ in 0..MOST_FRAMES {
            if !self.is_pending(view) {
                break;
            }
            if self.feedback.is_waiting() {
                self.gpu.wait()?;
            } else {
                self.terrain.wait(PATIENCE);
            }
            let record = self.frame(view, None)?;
            sum.add_work_of(&record);
        }
        Ok(sum)
    }
}
