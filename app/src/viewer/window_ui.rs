//! The user interface over the ground: what it is told, and what becomes of what it asks for.

use std::time::{Duration, Instant};

use terrain_core::RendererSettings;
use terrain_core::gpu::DebugImage;

use super::comparison::{Choices, ComparisonSection, Overlay};
use super::keys::Action;
use super::panel::{Panel, show_notice};
use super::texture_view::TextureView;
use super::ui_layer::UiTarget;
use super::window::TerrainWindow;

/// What the user interface may change.
struct Wishes {
    settings: RendererSettings,
    choices: Choices,
    debug_image: Option<DebugImage>,
    actions: Vec<Action>,
}

impl TerrainWindow {
    /// Draws the user interface and does what it asks for; returns how long it may stay as it is.
    pub(super) fn draw_ui(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        view: &wgpu::TextureView,
    ) -> anyhow::Result<Duration> {
        let now = Instant::now();
        self.notice.take_if(|(_, until)| *until <= now);
        let mut wishes = self.no_wishes();
        let ui_rests_for = self.build_ui(encoder, view, &mut wishes);
        self.grant(wishes)?;
        let notice_ends = self.notice.as_ref().map(|(_, until)| until.duration_since(now));
        Ok(ui_rests_for.min(notice_ends.unwrap_or(Duration::MAX)))
    }

    /// Everything as it is.
    fn no_wishes(&self) -> Wishes {
        Wishes {
            settings: *self.scene.settings(),
            choices: *self.comparison.choices(),
            debug_image: self.debug_image,
            actions: Vec::new(),
        }
    }

    fn build_ui(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        view: &wgpu::TextureView,
        wishes: &mut Wishes,
    ) -> Duration {
        let texture = self.draw_debug_image();
        let has_wireframe = self.has_wireframe();
        let size_px = self.surface.size_px();
        let first = *self.scene.settings();
        let (scene, second) = (&self.scene, self.comparison.second());
        let overlay = second.map(|second| Overlay {
            shares: self.comparison.shares(size_px[0]).0,
            strategies: [first.strategy, second.settings().strategy],
        });
        let mut panel = self.panel_visible.then(|| Panel {
            title: &self.title,
            manifest: self.source.manifest(),
            history: scene.history(),
            second_history: second.map(|second| second.history()),
            eye: self.controls.view().eye,
            clearance_m: self.controls.clearance_m(&scene.ground()),
            has_wireframe,
            is_recording: self.deck.is_recording(),
            is_playing: self.deck.is_playing(),
            has_flight: self.deck.has_flight(),
            texture,
            debug_image: &mut wishes.debug_image,
            settings: &mut wishes.settings,
            actions: &mut wishes.actions,
            comparison: ComparisonSection { first: &first, choices: &mut wishes.choices },
        });
        let notice = self.notice.as_ref().map(|(text, _)| text.as_str());
        let target = UiTarget { view, size_px };
        self.ui.draw(&self.gpu, encoder, &self.window, &target, |ui| {
            if let Some(overlay) = &overlay {
                overlay.show(ui);
            }
            if let Some(panel) = &mut panel {
                panel.show(ui);
            }
            if let Some(notice) = notice {
                show_notice(ui, notice);
            }
        })
    }

    /// Draws the texture that the panel shows, if any.
    fn draw_debug_image(&mut self) -> Option<egui::TextureId> {
        let image = self.debug_image.filter(|_| self.panel_visible)?;
        let ui = &mut self.ui;
        let picture = self.texture_view.get_or_insert_with(|| TextureView::new(&self.gpu, ui));
        Some(picture.draw(&mut self.scene.renderer, image))
    }

    fn grant(&mut self, wishes: Wishes) -> anyhow::Result<()> {
        if std::mem::replace(&mut self.debug_image, wishes.debug_image) != wishes.debug_image {
            self.request_frame();
        }
        self.change_settings(wishes.settings)?;
        self.change_comparison(wishes.choices)?;
        for action in wishes.actions {
            self.act(action)?;
        }
        Ok(())
    }
}
