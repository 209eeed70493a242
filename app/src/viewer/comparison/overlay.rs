//! The divider, and the names of the scenes beside it.

use egui::{Align2, Color32, FontId, Id, Order, Painter, Pos2, Ui};
use terrain_core::selection::Strategy;

use super::layout::{Shares, Side};

/// Radius of the knob at the divider's middle, points.
const KNOB_RADIUS: f32 = 7.0;
/// From the window's upper edge and from the divider to the names, points.
const MARGIN: f32 = 14.0;

/// What is drawn over two scenes.
pub struct Overlay {
    /// How much of each is seen.
    pub shares: Shares,
    /// The strategies of the first and the second.
    pub strategies: [Strategy; 2],
}

impl Overlay {
    /// Draws it, behind all panels.
    pub fn show(&self, ui: &Ui) {
        let screen = ui.ctx().content_rect();
        let layer = egui::LayerId::new(Order::Background, Id::unique("comparison"));
        let painter = ui.ctx().layer_painter(layer);
        let [of_first, of_second] = self.strategies.map(Strategy::name);
        let (first, second) = (format!("A  {of_first}"), format!("B  {of_second}"));
        let x = self.shares.first_columns as f32 / ui.ctx().pixels_per_point();
        let y = screen.top() + MARGIN;
        if self.shares.columns(Side::Second).is_empty() {
            name(&painter, Pos2::new(screen.center().x, y), Align2::CENTER_TOP, first);
        } else if self.shares.columns(Side::First).is_empty() {
            name(&painter, Pos2::new(screen.center().x, y), Align2::CENTER_TOP, second);
        } else {
            painter.vline(x, screen.y_range(), (3.0, Color32::from_black_alpha(120)));
            painter.vline(x, screen.y_range(), (1.0, Color32::WHITE));
            let knob = Pos2::new(x, screen.center().y);
            painter.circle(knob, KNOB_RADIUS, Color32::WHITE, (1.0, Color32::BLACK));
            name(&painter, Pos2::new(x - MARGIN, y), Align2::RIGHT_TOP, first);
            name(&painter, Pos2::new(x + MARGIN, y), Align2::LEFT_TOP, second);
        }
    }
}

/// Writes a scene's name so that it can be read over any ground.
fn name(painter: &Painter, at: Pos2, anchor: Align2, text: String) {
    let galley = painter.layout_no_wrap(text, FontId::proportional(14.0), Color32::WHITE);
    let place = anchor.anchor_size(at, galley.size());
    painter.rect_filled(place.expand(4.0), 4.0, Color32::from_black_alpha(160));
    painter.galley(place.min, galley, Color32::WHITE);
}
