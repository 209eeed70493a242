use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::DVec3;
use terrain_core::NoProgress;
use terrain_core::dataset::{Shape, TileSource};
use terrain_core::measure::error::true_heights_m;
use terrain_core::reference::{
    ReferencePicture, ReferenceScene, ReferenceSettings, render_reference,
};
use terrain_core::{CameraView, RendererSettings};

/// Most memory for pictures that further runs over the same flight will want again.
const MOST_KEPT_BYTES: usize = 1 << 30;

/// The exact pictures of a flight's frames, one flight after the other.
pub struct ExactPictures {
    scene: ReferenceScene,
    settings: ReferenceSettings,
    kept: HashMap<u64, Arc<ReferencePicture>>,
    kept_bytes: usize,
}

impl ExactPictures {
    /// Pictures of the source, coloured as a renderer with these settings colours them.
    ///
    /// # Errors
    /// Where the source holds no heights.
    pub fn new(source: Arc<dyn TileSource>, settings: &RendererSettings) -> anyhow::Result<Self> {
        Ok(Self {
            scene: ReferenceScene::open(source)?,
            settings: ReferenceSettings::of_renderer(settings),
            kept: HashMap::new(),
            kept_bytes: 0,
        })
    }

    /// Forgets the pictures, for those of another flight.
    pub fn begin_flight(&mut self) {
        self.kept.clear();
        self.kept_bytes = 0;
    }

    /// The exact picture of the view, which is that of the flight's frame of this number.
    ///
    /// # Errors
    /// Where a tile cannot be read, or when it is called off.
    pub fn of_frame(
        &mut self,
        frame: u64,
        view: &CameraView,
        cancelled: &AtomicBool,
    ) -> anyhow::Result<Arc<ReferencePicture>> {
        if let Some(picture) = self.kept.get(&frame) {
            return Ok(Arc::clone(picture));
        }
        let picture = render_reference(&self.scene, view, &self.settings, &NoProgress, cancelled)?;
        let picture = Arc::new(picture);
        let bytes = picture.rgba.len() * (4 + size_of::<DVec3>() + size_of::<f64>() + 1);
        if self.kept_bytes + bytes <= MOST_KEPT_BYTES {
            self.kept_bytes += bytes;
            self.kept.insert(frame, Arc::clone(&picture));
        }
        Ok(picture)
    }

    /// The exact heights, as drawn, at x and y of these points; not a number where there are none. `None` of a
    /// globe, where up is not the same for all of them.
    ///
    /// # Errors
    /// Where a tile cannot be read.
    pub fn heights_m(&self, ground: &[DVec3]) -> anyhow::Result<Option<Vec<f64>>> {
        if self.scene.shape() == Shape::Globe {
            return Ok(None);
        }
        let heights = true_heights_m(&self.scene, ground, self.settings.vertical_exaggeration);
        self.scene.check()?;
        Ok(Some(heights))
    }
}
