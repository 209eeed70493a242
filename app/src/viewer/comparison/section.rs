//! The panel's section on the comparison: how it is shown, and what it is with.

use egui::{RichText, Ui};
use terrain_core::RendererSettings;

use super::{Choices, Mode};
use crate::viewer::panel::{
    cache_choice, shortening_choice, slider, strategy_choice, visibility_choice,
};

/// What the section shows and what it may change.
pub struct ComparisonSection<'a> {
    /// The settings of the first scene.
    pub first: &'a RendererSettings,
    /// What the user may choose.
    pub choices: &'a mut Choices,
}

impl ComparisonSection<'_> {
    /// Shows it.
    pub fn show(&mut self, ui: &mut Ui) {
        ui.horizontal_wrapped(|ui| {
            for (mode, name) in Mode::ALL {
                if ui.selectable_label(self.choices.mode == mode, name).clicked() {
                    *self.choices = self.choices.with_mode(mode, self.first);
                }
            }
        });
        strategy_choice(ui, &mut self.choices.second);
        if self.choices.mode == Mode::Off {
            return;
        }
        visibility_choice(ui, &mut self.choices.second);
        shortening_choice(ui, &mut self.choices.second);
        cache_choice(ui, &mut self.choices.second);
        ui.add(slider(&mut self.choices.second.texel_px, 0.25, 8.0).text("texel (px)"));
        ui.label(RichText::new("All other settings are those of A.").weak());
    }
}
