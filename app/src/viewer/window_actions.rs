//! What the keys and the panel's buttons do.

use std::time::{Duration, Instant};

use terrain_core::gpu::{GpuContext, OFFSCREEN_FORMAT, OffscreenTarget};
use terrain_core::{CameraView, DebugView};
use winit::window::Fullscreen;

use super::keys::Action;
use super::scene::Scene;
use super::window::TerrainWindow;
use crate::output;
use crate::pictures::{free_name, write_png};

/// How long a notice is shown.
const NOTICE: Duration = Duration::from_secs(6);

impl TerrainWindow {
    /// Does what a key or a button asks for. [`Action::Quit`] is the caller's.
    pub(super) fn act(&mut self, action: Action) -> anyhow::Result<()> {
        let mut settings = *self.scene.settings();
        let toggled = |view| if settings.debug_view == view { DebugView::Off } else { view };
        match action {
            Action::Quit => {}
            Action::TogglePanel => self.panel_visible = !self.panel_visible,
            Action::ToggleFreeze => settings.freeze_selection = !settings.freeze_selection,
            Action::ToggleBorders => settings.debug_view = toggled(DebugView::TileBorders),
            Action::ToggleLevels => settings.debug_view = toggled(DebugView::Levels),
            Action::ToggleWireframe => {
                settings.wireframe = self.has_wireframe() && !settings.wireframe;
            }
            Action::GoHome => {
                self.take_over();
                self.controls.go_home();
            }
            Action::GoNorthUp => {
                self.take_over();
                self.controls.go_north_up(&self.scene.ground());
            }
            Action::TakeScreenshot => self.take_screenshot()?,
            Action::ToggleRecording if self.deck.is_recording() => {
                // The flight can still be played, and a window flies on without a file.
                if let Err(error) = self.save_recording() {
                    self.tell(output::one_line(&error));
                }
            }
            Action::ToggleRecording => {
                self.deck.record();
                self.tell("recording; R ends it".to_owned());
            }
            Action::TogglePlaying => self.toggle_playing(),
            Action::NextComparison => {
                let choices = self.comparison.choices();
                let next = choices.with_mode(choices.mode.next(), self.scene.settings());
                self.change_comparison(next)?;
            }
            Action::ShowSecondAlone(is_down) => self.comparison.shows_second_alone = is_down,
            Action::ToggleFullscreen => self.toggle_fullscreen(),
        }
        self.change_settings(settings)
    }

    pub(super) fn has_wireframe(&self) -> bool {
        self.gpu.device.features().contains(wgpu::Features::POLYGON_MODE_LINE)
    }

    fn toggle_playing(&mut self) {
        if self.deck.is_playing() {
            self.deck.stop();
        } else if !self.deck.play() {
            self.tell("no flight to play yet; R records one".to_owned());
        }
    }

    fn toggle_fullscreen(&self) {
        let is_full = self.window.fullscreen().is_some();
        self.window.set_fullscreen((!is_full).then_some(Fullscreen::Borderless(None)));
    }

    /// Saves what is to be seen of the ground.
    fn take_screenshot(&mut self) -> anyhow::Result<()> {
        let view = *self.controls.view();
        let mut rgba = picture_of(&mut self.scene, &self.gpu, &view)?;
        let (shares, _) = self.comparison.shares(view.viewport_px[0]);
        if let Some(second) = self.comparison.second_mut() {
            rgba = shares.compose(&rgba, &picture_of(second, &self.gpu, &view)?);
        }
        let path = free_name("terrain", "png");
        match write_png(&path, view.viewport_px, &rgba) {
            Ok(()) => self.tell(format!("picture saved as {}", path.display())),
            Err(error) => self.tell(output::one_line(&error)),
        }
        Ok(())
    }

    /// Ends the recording, if there is one, and saves it.
    ///
    /// # Errors
    /// Where the file cannot be written.
    pub(super) fn save_recording(&mut self) -> anyhow::Result<()> {
        let Some(flight) = self.deck.finish_recording()? else { return Ok(()) };
        let path = self.record_to.clone().unwrap_or_else(|| free_name("terrain-flight", "json"));
        flight.write(&path)?;
        let duration_s = flight.duration_s();
        self.record_to = None;
        self.tell(format!("flight of {duration_s:.1} s saved as {}", path.display()));
        Ok(())
    }

    /// Tells the user something, in the window and on stderr.
    pub(super) fn tell(&mut self, text: String) {
        output::say(&format!("terrain: {text}"));
        self.notice = Some((text, Instant::now() + NOTICE));
        self.request_frame();
    }
}

/// A scene's next frame as RGBA of 8 bits.
fn picture_of(scene: &mut Scene, gpu: &GpuContext, view: &CameraView) -> anyhow::Result<Vec<u8>> {
    let target = OffscreenTarget::new(gpu, view.viewport_px);
    scene.renderer.render(view, target.view(), OFFSCREEN_FORMAT)?;
    Ok(target.read_rgba8(gpu)?)
}
