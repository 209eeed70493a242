//! Two scenes of the same ground and camera in one window, for comparing how they are drawn.
//!
//! The second scene has a renderer of its own, made when a comparison begins and dropped when it ends:
//! without a comparison there is nothing of it.

mod choices;
mod layout;
mod overlay;
mod section;

use std::sync::Arc;
use std::time::{Duration, Instant};

use terrain_core::dataset::TileSource;
use terrain_core::gpu::GpuContext;
use terrain_core::{CameraView, RenderError, TerrainRenderer};

pub use self::choices::{Choices, Mode};
pub use self::layout::{Shares, Side};
pub use self::overlay::Overlay;
pub use self::section::ComparisonSection;
use super::scene::Scene;
use crate::scene_args::SceneObjects;

/// How near to the divider the pointer takes hold of it, points.
const GRIP_POINTS: f64 = 7.0;

/// A comparison, or what one would be.
pub struct Comparison {
    choices: Choices,
    /// The second scene; there is one unless the mode is off.
    second: Option<Scene>,
    /// When the mode was chosen: flicker goes by it.
    since: Instant,
    /// Whether the second scene alone is to be seen, for as long as a key is held.
    pub shows_second_alone: bool,
}

impl Comparison {
    /// No comparison yet.
    pub fn new(choices: Choices) -> Self {
        let choices = Choices { mode: Mode::Off, ..choices };
        Self { choices, second: None, since: Instant::now(), shows_second_alone: false }
    }

    /// Whether two scenes are shown.
    pub fn is_on(&self) -> bool {
        self.second.is_some()
    }

    /// What is compared, and how.
    pub fn choices(&self) -> &Choices {
        &self.choices
    }

    /// The second scene, if there is one.
    pub fn second(&self) -> Option<&Scene> {
        self.second.as_ref()
    }

    /// The second scene, if there is one.
    pub fn second_mut(&mut self) -> Option<&mut Scene> {
        self.second.as_mut()
    }

    /// Begins, changes or ends the comparison with the first scene.
    ///
    /// # Errors
    /// Where the second renderer cannot be had as it is wanted; all then stays as it was.
    pub fn change(
        &mut self,
        choices: Choices,
        first: &Scene,
        gpu: &Arc<GpuContext>,
        source: &Arc<dyn TileSource>,
    ) -> Result<(), RenderError> {
        let settings = choices.second_settings(first.settings());
        match &mut self.second {
            _ if choices.mode == Mode::Off => self.second = None,
            Some(scene) if *scene.settings() == settings.for_adapter(gpu.is_software()) => {}
            Some(scene) => scene.set_settings(settings)?,
            None => {
                let (gpu, source) = (Arc::clone(gpu), Arc::clone(source));
                let mut renderer = TerrainRenderer::new(gpu, source, settings)?;
                SceneObjects::of(&first.renderer).put_into(&mut renderer)?;
                self.second = Some(Scene::new(renderer));
            }
        }
        if choices.mode != self.choices.mode {
            self.since = Instant::now();
        }
        self.choices = choices;
        Ok(())
    }

    /// How much of each scene is seen now, and how long that holds.
    pub fn shares(&self, width_px: u32) -> (Shares, Duration) {
        let for_good = |shares| (shares, Duration::MAX);
        match self.choices.mode {
            Mode::Off => for_good(Shares::all_of(Side::First, width_px)),
            _ if self.shows_second_alone => for_good(Shares::all_of(Side::Second, width_px)),
            Mode::Split => for_good(Shares::divided_at(self.choices.divider, width_px)),
            Mode::Flicker => {
                let (side, rest) = layout::flicker(self.since.elapsed());
                (Shares::all_of(side, width_px), rest)
            }
        }
    }

    /// Whether the divider can be taken hold of at column `x_px` of a window of this width, whose points
    /// are `scale` pixels.
    pub fn has_divider_at(&self, x_px: f64, width_px: u32, scale: f64) -> bool {
        let divider_px = self.choices.divider * f64::from(width_px);
        let is_seen = self.choices.mode == Mode::Split && !self.shows_second_alone;
        is_seen && (x_px - divider_px).abs() <= GRIP_POINTS * scale
    }

    /// Moves the divider to column `x_px` of a window of this width.
    pub fn move_divider(&mut self, x_px: f64, width_px: u32) {
        self.choices.divider = layout::fraction_at(x_px, width_px);
    }

    /// Whether a frame for this view would show or do anything new in the second scene.
    pub fn needs_frame(&self, view: &CameraView) -> bool {
        self.second.as_ref().is_some_and(|scene| scene.renderer.needs_frame(view))
    }
}

#[cfg(test)]
mod tests {
    use terrain_core::RendererSettings;

    use super::*;

    #[test]
    fn the_divider_is_held_where_it_is_seen_and_at_the_windows_edge() {
        let choices = Choices::new(&RendererSettings::default(), None);
        let mut comparison = Comparison::new(choices);
        assert!(!comparison.has_divider_at(400.0, 800, 1.0), "there is none yet");
        comparison.choices.mode = Mode::Split;
        assert!(comparison.has_divider_at(406.0, 800, 1.0));
        assert!(!comparison.has_divider_at(412.0, 800, 1.0));
        assert!(
            comparison.has_divider_at(412.0, 800, 2.0),
            "a finer screen, the same width of hand"
        );
        comparison.move_divider(2_000.0, 800);
        assert_eq!(comparison.shares(800).0, Shares::all_of(Side::First, 800));
        assert!(comparison.has_divider_at(799.0, 800, 1.0));
        comparison.shows_second_alone = true;
        assert!(!comparison.has_divider_at(799.0, 800, 1.0));
    }
}
