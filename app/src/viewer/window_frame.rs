//! How a frame of the window comes about.

use std::time::{Duration, Instant};

use terrain_core::CameraView;

use super::Next;
use super::comparison::Side;
use super::surface::{Acquired, SurfaceFrame};
use super::window::{FIRST_FRAME_S, TerrainWindow, draws_globe};

/// The longest that any frame is taken to last, seconds.
const LONGEST_FRAME_S: f64 = 0.25;
/// How soon to ask again for a picture of the window that was not to be had.
const RETRY: Duration = Duration::from_millis(10);

impl TerrainWindow {
    /// Draws a frame: whatever of it is not there already.
    pub(super) fn draw(&mut self) -> anyhow::Result<Next> {
        if self.hidden {
            return Ok(Next::Rest);
        }
        let frame = match self.surface.acquire(&self.gpu, &self.window)? {
            Acquired::Frame(frame) => frame,
            Acquired::Later => return Ok(Next::FrameAt(Instant::now() + RETRY)),
            Acquired::Hidden => return Ok(Next::Rest),
        };
        self.move_camera();
        let view = *self.controls.view();
        let mut rests_for = Duration::MAX;
        if self.has_ui() {
            rests_for = self.draw_with_ui(&view, &frame)?;
        } else {
            self.scene.forget_picture();
            self.draw_directly(&view, &frame.scene_view)?;
        }
        self.tell_failures();
        self.window.pre_present_notify();
        frame.present(&self.gpu.queue);
        self.gpu.check()?;
        Ok(self.next(rests_for))
    }

    /// Whether there is any user interface over the ground.
    pub(super) fn has_ui(&self) -> bool {
        self.panel_visible || self.comparison.is_on()
    }

    fn move_camera(&mut self) {
        let now = Instant::now();
        let since = self.last_frame.replace(now).map(|last| (now - last).as_secs_f64());
        self.frame_s = since.unwrap_or(FIRST_FRAME_S);
        let dt_s = self.frame_s.min(LONGEST_FRAME_S);
        if let Some(view) = self.deck.advance(dt_s, self.controls.view().viewport_px) {
            self.controls.set_view(view);
        }
        let is_globe = draws_globe(self.source.manifest(), self.scene.settings());
        self.controls.set_is_globe(is_globe);
        self.controls.advance(dt_s, &self.scene.ground());
        self.deck.take_view(dt_s, self.controls.view());
    }

    /// Draws the first scene straight into a picture of the window.
    fn draw_directly(
        &mut self,
        view: &CameraView,
        target: &wgpu::TextureView,
    ) -> anyhow::Result<()> {
        let format = self.surface.scene_format();
        Ok(self.scene.draw(view, target, format, self.frame_s)?)
    }

    /// Draws what has changed of the ground, and the user interface over it. Returns how long all of it
    /// may stay as it is.
    fn draw_with_ui(
        &mut self,
        view: &CameraView,
        frame: &SurfaceFrame,
    ) -> anyhow::Result<Duration> {
        let label = Some("window");
        let descriptor = wgpu::CommandEncoderDescriptor { label };
        let mut encoder = self.gpu.device.create_command_encoder(&descriptor);
        let mut rests_for = Duration::MAX;
        if self.surface.takes_copies() {
            self.keep_scenes_current(view)?;
            rests_for = self.copy_scenes(&mut encoder, frame);
        } else {
            self.draw_directly(view, &frame.scene_view)?;
        }
        rests_for = rests_for.min(self.draw_ui(&mut encoder, &frame.ui_view)?);
        self.gpu.queue.submit([encoder.finish()]);
        Ok(rests_for)
    }

    /// Draws both scenes where either has changed: what their frames cost is compared frame by frame.
    fn keep_scenes_current(&mut self, view: &CameraView) -> anyhow::Result<()> {
        let scenes = [Some(&mut self.scene), self.comparison.second_mut()];
        let mut scenes: Vec<_> = scenes.into_iter().flatten().collect();
        if scenes.iter().all(|scene| scene.is_kept(&self.surface, view)) {
            return Ok(());
        }
        let is_compared = scenes.len() > 1;
        for scene in &mut scenes {
            // A software driver's submit waits for the work before it: that would pass for time that
            // the second scene's own frame takes.
            if self.gpu.is_software() && is_compared {
                self.gpu.wait()?;
            }
            scene.draw_and_keep(&self.gpu, &self.surface, view, self.frame_s)?;
        }
        Ok(())
    }

    /// Copies what is to be seen of each scene into a picture of the window; returns how long that
    /// may stay.
    fn copy_scenes(&self, encoder: &mut wgpu::CommandEncoder, frame: &SurfaceFrame) -> Duration {
        let (shares, rests_for) = self.comparison.shares(self.surface.size_px()[0]);
        self.scene.copy_columns_to(encoder, frame, shares.columns(Side::First));
        if let Some(second) = self.comparison.second() {
            second.copy_columns_to(encoder, frame, shares.columns(Side::Second));
        }
        rests_for
    }

    /// What the window needs after a frame.
    fn next(&mut self, rests_for: Duration) -> Next {
        if self.closes_at_end && !self.deck.is_playing() {
            return Next::Close;
        }
        let view = *self.controls.view();
        let moves = self.controls.is_moving() || self.deck.is_playing();
        let is_new = self.scene.renderer.needs_frame(&view) || self.comparison.needs_frame(&view);
        if moves || is_new || rests_for.is_zero() {
            return Next::Frame;
        }
        self.last_frame = None;
        match Instant::now().checked_add(rests_for) {
            Some(time) if rests_for < Duration::MAX => Next::FrameAt(time),
            _ => Next::Rest,
        }
    }

    /// Tells which tiles could not be loaded.
    fn tell_failures(&mut self) {
        let mut failures = self.scene.renderer.take_failures();
        if let Some(second) = self.comparison.second_mut() {
            failures.extend(second.renderer.take_failures());
        }
        for failure in failures {
            self.tell(failure);
        }
    }
}
