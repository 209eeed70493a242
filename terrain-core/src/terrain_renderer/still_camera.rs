//! Frames that wait, and what takes several of them: drawing until nothing is missing, and the
//! coordinates of every pixel.

use std::time::Duration;

use glam::{DVec3, dvec3};

use super::{RenderError, TerrainRenderer};
use crate::CameraView;
use crate::gpu::read_texture;
use crate::measure::FrameRecord;
use crate::method::SceneState;
use crate::progress::{NoProgress, Progress};

/// How long to wait for a source that says nothing.
const PATIENCE: Duration = Duration::from_secs(10);

impl TerrainRenderer {
    /// Waits until all that earlier frames have asked of GPU and disk is there. Frames with such a wait
    /// before each are the same on every run, however fast either is.
    ///
    /// # Errors
    /// [`RenderError::Gpu`] where the device has failed.
    pub fn wait(&self) -> Result<(), RenderError> {
        self.gpu.wait()?;
        self.method.wait(PATIENCE);
        if let Some(objects) = &self.objects {
            objects.wait(PATIENCE);
        }
        Ok(())
    }

    /// A frame without its picture; see [`Self::render`].
    ///
    /// # Errors
    /// [`RenderError::Camera`] where the view is none, [`RenderError::Gpu`] where the device has failed.
    pub fn advance(&mut self, view: &CameraView) -> Result<FrameRecord, RenderError> {
        self.frame(view, None)
    }

    /// Where on the ground each pixel of the view looks, after drawing until nothing is missing; see
    /// [`Self::drawn_coordinates`].
    ///
    /// # Errors
    /// [`RenderError::Gpu`] where the device has failed.
    pub fn ground_coordinates(&mut self, view: &CameraView) -> Result<Vec<[f64; 3]>, RenderError> {
        self.settle(view)?;
        self.drawn_coordinates(view)
    }

    /// Where on the ground each pixel of the view looks with the tiles there are: x, y in the
    /// dataset's CRS and the height drawn (exaggeration included), row by row from the top left, NaN
    /// where there is sky. Of a globe, the eye's place and what there is from it to the point in the eye's
    /// directions, which [`Geodetic::of_seen`](crate::geodesy::Geodetic::of_seen) reads. From the same mesh
    /// and tiles as a picture. No frame: see [`Self::redraw`].
    ///
    /// # Errors
    /// [`RenderError::Gpu`] where the device has failed.
    pub fn drawn_coordinates(&mut self, view: &CameraView) -> Result<Vec<[f64; 3]>, RenderError> {
        let target = self.beside_frames(view, |renderer, encoder, scene| {
            let (method, cx) = renderer.method_and_context();
            method.draw_coordinates(&cx, encoder, scene)
        });
        let bytes = read_texture(&self.gpu, &target, view.viewport_px, 16)?;
        let world = |[x, y, z, ground]: [f32; 4]| {
            let offset = dvec3(f64::from(x), f64::from(y), f64::from(z));
            let point = if ground == 0.0 { DVec3::NAN } else { view.eye + offset };
            point.to_array()
        };
        Ok(bytemuck::pod_collect_to_vec::<u8, [f32; 4]>(&bytes).into_iter().map(world).collect())
    }

    /// Draws the view into `target` with the tiles there are, for comparing pictures. No frame: nothing
    /// is selected, loaded or counted, and the next frame finds everything as the last one left it.
    /// Before the first frame it builds meshes that the first frame would build.
    ///
    /// # Errors
    /// [`RenderError::Gpu`] where the device has failed.
    pub fn redraw(
        &mut self,
        view: &CameraView,
        target: &wgpu::TextureView,
        format: wgpu::TextureFormat,
    ) -> Result<(), RenderError> {
        self.gpu.check()?;
        self.beside_frames(view, |renderer, encoder, scene| {
            renderer.draw(encoder, scene, target, format, false);
        });
        Ok(())
    }

    /// Records and submits work on the view as it would be drawn now, then brings everything back to
    /// what the last frame drew.
    pub(super) fn beside_frames<T>(
        &mut self,
        view: &CameraView,
        work: impl FnOnce(&mut Self, &mut wgpu::CommandEncoder, &SceneState) -> T,
    ) -> T {
        let ledger = std::mem::take(&mut self.ledger);
        let (drawn, drawn_objects) = (self.drawn, self.drawn_objects);
        let scene = self.scene(view);
        let mut encoder = self.encoder();
        self.set_up(&mut encoder, &scene);
        let done = work(self, &mut encoder, &scene);
        self.gpu.queue.submit([encoder.finish()]);
        if let Some(scene) = drawn {
            let mut encoder = self.encoder();
            self.set_up(&mut encoder, &scene);
            self.gpu.queue.submit([encoder.finish()]);
        }
        (self.drawn, self.drawn_objects) = (drawn, drawn_objects);
        self.ledger = ledger;
        done
    }

    /// Does frames of a still camera without drawing their pictures until nothing is missing. Waits for
    /// disk and GPU. The record sums up all of them; it costs no more than what a picture rests on.
    ///
    /// # Errors
    /// [`RenderError::Camera`] where the view is none, [`RenderError::Gpu`] where the device has failed.
    pub fn settle(&mut self, view: &CameraView) -> Result<FrameRecord, RenderError> {
        self.settle_with(view, &NoProgress)
    }

    /// [`Self::settle`], telling how many tiles of those known to be missing have come.
    ///
    /// # Errors
    /// As [`Self::settle`].
    pub fn settle_with(
        &mut self,
        view: &CameraView,
        progress: &dyn Progress,
    ) -> Result<FrameRecord, RenderError> {
        // Each round brings at least one tile or image, unless a disk takes its time.
        const MOST_FRAMES: u32 = 2_000;
        let mut sum = self.advance(view)?;
        let mut most_missing = 0;
        for _ in 0..MOST_FRAMES {
            if !self.is_pending(&self.scene(view)) {
                break;
            }
            // All that is under way: the same rounds of them every time.
            self.wait()?;
            let record = self.advance(view)?;
            most_missing = record.tiles_missing.max(most_missing);
            progress.advanced("tiles", most_missing - record.tiles_missing, most_missing);
            sum.add_work_of(&record);
        }
        Ok(sum)
    }
}
