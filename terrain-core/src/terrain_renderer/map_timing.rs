//! How long the texture map takes, by itself.

use super::{RenderError, TerrainRenderer};
use crate::CameraView;

impl TerrainRenderer {
    /// Milliseconds that laying the models in view into the map of their texture takes, so many times over: from
    /// handing it to the GPU until the GPU is done, the scene's depth left out. With the strategy
    /// [`TextureMap`](crate::selection::Strategy::TextureMap) and the settings in force; `None` without models or with
    /// another strategy. No frame: see [`Self::redraw`].
    ///
    /// # Errors
    /// [`RenderError::Camera`] where the view is none, [`RenderError::Gpu`] where the device has failed.
    pub fn time_models_map(
        &mut self,
        view: &CameraView,
        repeats: usize,
    ) -> Result<Option<Vec<f64>>, RenderError> {
        view.check()?;
        let times = self.beside_frames(view, |renderer, _, scene| {
            let gpu = &renderer.gpu;
            renderer.objects.as_mut().map(|objects| objects.time_map(gpu, scene, repeats))
        });
        Ok(times.transpose()?.flatten())
    }
}
