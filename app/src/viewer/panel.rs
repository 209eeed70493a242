//! The panel: what is drawn and how, what it costs, and what the keys do.

use egui::{Align2, Color32, Grid, RichText, Slider, SliderClamping, Ui};
use glam::DVec3;
use terrain_core::dataset::{Manifest, Shape};
use terrain_core::gpu::DebugImage;
use terrain_core::residency::page_table::{FaceCulling, PageFeedback};
use terrain_core::selection::{Shortening, Strategy, Visibility};
use terrain_core::{AntiAliasing, DebugView, RendererSettings};

use super::comparison::ComparisonSection;
use super::keys::{Action, HELP};
use super::plots::FrameHistory;

const WIDTH: f32 = 300.0;
const MARGIN: f32 = 8.0;
/// Sides of square caches to choose from, slots.
const CACHE_SIDES: [u32; 7] = [3, 4, 6, 8, 10, 12, 16];

/// What the panel shows and what it may change.
pub struct Panel<'a> {
    /// Name of the dataset.
    pub title: &'a str,
    /// The dataset.
    pub manifest: &'a Manifest,
    /// The frames just past.
    pub history: &'a FrameHistory,
    /// Those of the scene it is compared with.
    pub second_history: Option<&'a FrameHistory>,
    /// Where the eye is, metres.
    pub eye: DVec3,
    /// Height of the eye above the ground, metres.
    pub clearance_m: f64,
    /// Whether the device can draw lines.
    pub has_wireframe: bool,
    /// Whether a flight is being recorded.
    pub is_recording: bool,
    /// Whether a flight is being played.
    pub is_playing: bool,
    /// Whether there is a flight to play.
    pub has_flight: bool,
    /// The picture of the texture to look at.
    pub texture: Option<egui::TextureId>,
    /// Which texture to look at.
    pub debug_image: &'a mut Option<DebugImage>,
    /// What the user may change.
    pub settings: &'a mut RendererSettings,
    /// What the user asked for by buttons.
    pub actions: &'a mut Vec<Action>,
    /// What is compared.
    pub comparison: ComparisonSection<'a>,
}

impl Panel<'_> {
    /// Shows the panel at the left.
    pub fn show(&mut self, ui: &Ui) {
        let context = ui.ctx();
        let height = context.content_rect().height() - 6.0 * MARGIN;
        egui::Window::new(self.title)
            .anchor(Align2::LEFT_TOP, [MARGIN, MARGIN])
            .resizable(false)
            .default_width(WIDTH)
            .vscroll(true)
            .default_height(height)
            .max_height(height)
            .show(context, |ui| {
                ui.set_width(WIDTH);
                self.contents(ui);
            });
    }

    fn contents(&mut self, ui: &mut Ui) {
        self.place(ui);
        self.buttons(ui);
        ui.separator();
        let histories = [Some(self.history), self.second_history];
        numbers(ui, &histories.into_iter().flatten().collect::<Vec<_>>());
        section(ui, "Bytes a frame", true, |ui| self.history.show_bytes(ui));
        section(ui, "Times", true, |ui| self.history.show_times(ui));
        section(ui, "Settings", true, |ui| self.sliders(ui));
        section(ui, "Comparison", false, |ui| self.comparison.show(ui));
        section(ui, "Debug views", false, |ui| self.debug_views(ui));
        section(ui, "Textures", false, |ui| self.textures(ui));
        section(ui, "Dataset", false, |ui| about(ui, self.manifest));
        section(ui, "Keys", false, help);
    }

    fn place(&self, ui: &mut Ui) {
        let shape = self.manifest.shape;
        let place = shape.user_from_world(self.eye.truncate());
        ui.label(match shape {
            Shape::Plane => format!("x {:.0}   y {:.0}", place.x, place.y),
            Shape::Globe => format!("longitude {:.4}°   latitude {:.4}°", place.x, place.y),
        });
        ui.label(format!(
            "height {}   above ground {}",
            metres(self.eye.z),
            metres(self.clearance_m)
        ));
    }

    fn buttons(&mut self, ui: &mut Ui) {
        let record = if self.is_recording { "Stop recording" } else { "Record" };
        let play = if self.is_playing { "Stop" } else { "Play" };
        ui.horizontal_wrapped(|ui| {
            self.button(ui, "Home", true, Action::GoHome);
            self.button(ui, "North", true, Action::GoNorthUp);
            self.button(ui, record, true, Action::ToggleRecording);
            self.button(ui, play, self.has_flight, Action::TogglePlaying);
            self.button(ui, "Picture", true, Action::TakeScreenshot);
        });
    }

    fn button(&mut self, ui: &mut Ui, text: &str, enabled: bool, action: Action) {
        if ui.add_enabled(enabled, egui::Button::new(text)).clicked() {
            self.actions.push(action);
        }
    }

    fn sliders(&mut self, ui: &mut Ui) {
        let settings = &mut *self.settings;
        strategy_choice(ui, settings);
        visibility_choice(ui, settings);
        if settings.strategy == Strategy::PageTable {
            page_feedback_choice(ui, settings);
        }
        if settings.strategy == Strategy::TextureMap {
            face_culling_choice(ui, settings);
        }
        shortening_choice(ui, settings);
        cache_choice(ui, settings);
        let slots = (settings.cache_columns * settings.cache_rows) as usize;
        ui.add(Slider::new(&mut settings.max_tiles, 1..=slots).text("MaxofTiles"))
            .on_hover_text("Most tiles a selection may have, level 0 included");
        ui.add(slider(&mut settings.texel_px, 0.25, 8.0).text("texel (px)"))
            .on_hover_text("A tile is split while its texels are drawn larger than this");
        ui.add(slider(&mut settings.triangle_px, 2.0, 40.0).text("triangle (px)"))
            .on_hover_text("Size of the mesh's triangles in the picture");
        let mut is_smooth = settings.anti_aliasing == AntiAliasing::FourSamples;
        if ui.checkbox(&mut is_smooth, "smooth edges (4 samples a pixel)").changed() {
            let four = AntiAliasing::FourSamples;
            settings.anti_aliasing = if is_smooth { four } else { AntiAliasing::Off };
        }
        ui.add(slider(&mut settings.vertical_exaggeration, 0.5, 50.0).text("exaggeration"));
        let mut budget_kib = settings.upload_budget_bytes / 1024;
        let budget = Slider::new(&mut budget_kib, 64..=16_384)
            .logarithmic(true)
            .clamping(SliderClamping::Edits);
        if ui.add(budget.text("upload (KiB a frame)")).changed() {
            settings.upload_budget_bytes = budget_kib * 1024;
        }
    }

    fn debug_views(&mut self, ui: &mut Ui) {
        let settings = &mut *self.settings;
        ui.horizontal_wrapped(|ui| {
            for (view, name) in [
                (DebugView::Off, "terrain"),
                (DebugView::TileBorders, "borders"),
                (DebugView::Levels, "levels"),
                (DebugView::Shading, "light"),
            ] {
                ui.selectable_value(&mut settings.debug_view, view, name);
            }
        });
        ui.add_enabled(
            self.has_wireframe,
            egui::Checkbox::new(&mut settings.wireframe, "wireframe"),
        );
        ui.checkbox(&mut settings.freeze_selection, "freeze the selection");
    }

    fn textures(&mut self, ui: &mut Ui) {
        ui.horizontal_wrapped(|ui| {
            for (image, name) in [
                (None, "none"),
                (Some(DebugImage::Coordinates), "coordinates"),
                (Some(DebugImage::HeightCache), "DEM cache"),
                (Some(DebugImage::ColourCache), "DOM cache"),
            ] {
                ui.selectable_value(self.debug_image, image, name);
            }
        });
        if let Some(texture) = self.texture {
            let width = ui.available_width();
            let share = if *self.debug_image == Some(DebugImage::Coordinates) {
                self.settings.coordinate_size_px
            } else {
                [self.settings.cache_columns, self.settings.cache_rows]
            };
            let height = width * share[1] as f32 / share[0] as f32;
            ui.image((texture, egui::vec2(width, height)));
        }
    }
}

/// Shows something just done, to be told, at the bottom.
pub fn show_notice(ui: &Ui, notice: &str) {
    egui::Area::new(egui::Id::unique("notice"))
        .anchor(Align2::CENTER_BOTTOM, [0.0, -2.0 * MARGIN])
        .interactable(false)
        .show(ui.ctx(), |ui| {
            let text = egui::Label::new(notice).extend();
            egui::Frame::popup(ui.style()).show(ui, |ui| ui.add(text));
        });
}

fn section(ui: &mut Ui, title: &str, open: bool, contents: impl FnOnce(&mut Ui)) {
    egui::CollapsingHeader::new(title).default_open(open).show(ui, contents);
}

/// A slider that leaves a value beyond its ends, given on the command line, until it is moved.
pub(super) fn slider(value: &mut f64, least: f64, most: f64) -> Slider<'_> {
    Slider::new(value, least..=most)
        .logarithmic(true)
        .max_decimals(2)
        .clamping(SliderClamping::Edits)
}

/// Lets the user choose a strategy.
pub(super) fn strategy_choice(ui: &mut Ui, settings: &mut RendererSettings) {
    choice(ui, "strategy", &mut settings.strategy, Strategy::ALL, Strategy::name);
}

/// Lets the user choose what counts as visible.
pub(super) fn visibility_choice(ui: &mut Ui, settings: &mut RendererSettings) {
    let chosen = &mut settings.visibility;
    choice(ui, "visible ground", chosen, Visibility::ALL, Visibility::name);
}

/// Lets the user choose how a page table learns what pixels need.
fn page_feedback_choice(ui: &mut Ui, settings: &mut RendererSettings) {
    let chosen = &mut settings.page_feedback;
    choice(ui, "page feedback", chosen, PageFeedback::ALL, PageFeedback::name);
}

/// Lets the user choose where a texture map drops back faces.
fn face_culling_choice(ui: &mut Ui, settings: &mut RendererSettings) {
    let chosen = &mut settings.face_culling;
    choice(ui, "back faces dropped", chosen, FaceCulling::ALL, FaceCulling::name);
}

/// Lets the user choose how too long a list is made short.
pub(super) fn shortening_choice(ui: &mut Ui, settings: &mut RendererSettings) {
    let chosen = &mut settings.shortening;
    choice(ui, "too many tiles", chosen, Shortening::ALL, Shortening::name);
}

/// Lets the user choose one of several by its name.
fn choice<T: Copy + PartialEq, const N: usize>(
    ui: &mut Ui,
    label: &str,
    chosen: &mut T,
    all: [T; N],
    name: fn(T) -> &'static str,
) {
    egui::ComboBox::from_label(label).selected_text(name(*chosen)).show_ui(ui, |ui| {
        for one in all {
            ui.selectable_value(chosen, one, name(one));
        }
    });
}

/// Lets the user choose the caches' size; as many tiles are then selected.
pub(super) fn cache_choice(ui: &mut Ui, settings: &mut RendererSettings) {
    let (columns, rows) = (settings.cache_columns, settings.cache_rows);
    egui::ComboBox::from_label("cache (slots)")
        .selected_text(format!("{columns} x {rows}"))
        .show_ui(ui, |ui| {
            for side in CACHE_SIDES {
                let chosen = (columns, rows) == (side, side);
                if ui.selectable_label(chosen, format!("{side} x {side}")).clicked() {
                    (settings.cache_columns, settings.cache_rows) = (side, side);
                    settings.max_tiles = RendererSettings::most_tiles_of(side, side);
                }
            }
        });
}

/// What the last frame of a scene cost, or those of two scenes side by side.
fn numbers(ui: &mut Ui, histories: &[&FrameHistory]) {
    let columns: Vec<_> = histories.iter().filter_map(|history| column(history)).collect();
    Grid::new("numbers").num_columns(1 + columns.len()).striped(true).show(ui, |ui| {
        for (row, name) in ROWS.iter().enumerate() {
            ui.label(*name);
            for column in &columns {
                ui.label(column[row].clone());
            }
            ui.end_row();
        }
    });
}

/// What the rows of the numbers are called.
const ROWS: [&str; 11] = [
    "strategy",
    "frame",
    "CPU",
    "selection",
    "GPU",
    "tiles selected",
    "new, evicted",
    "missing",
    "region's age",
    "bytes",
    "mean bytes",
];

/// The numbers of a scene, a row each; `None` before its first frame.
fn column(history: &FrameHistory) -> Option<[RichText; ROWS.len()]> {
    let record = history.last()?;
    let gpu = record.gpu_ms.map_or("not measured".to_owned(), |ms| format!("{ms:.1} ms"));
    let age = record.region_age_frames.map_or("-".to_owned(), |age| format!("{age} frames"));
    let missing = RichText::new(record.tiles_missing.to_string());
    let missing = if record.tiles_missing > 0 { missing.color(Color32::YELLOW) } else { missing };
    Some([
        record.strategy.as_str().into(),
        format!("{:.1} ms", record.frame_ms).into(),
        format!("{:.2} ms", record.cpu_ms).into(),
        format!("{:.3} ms", record.select_ms).into(),
        gpu.into(),
        format!("{} to level {}", record.tiles_selected, record.finest_level).into(),
        format!("{}, {}", record.tiles_new, record.tiles_evicted).into(),
        missing,
        age.into(),
        bytes(record.upload_bytes + record.readback_bytes).into(),
        bytes(history.mean_bytes() as u64).into(),
    ])
}

fn about(ui: &mut Ui, manifest: &Manifest) {
    let size_m = manifest.data_extent.size_m();
    let range = manifest.heights.range;
    ui.label(&manifest.crs.name);
    ui.label(format!("{} x {}", metres(size_m.x), metres(size_m.y)));
    ui.label(format!("heights {:.0} to {:.0} m", range.min_m, range.max_m));
    let levels = |layout: &terrain_core::tiling::LayerLayout| {
        format!("{} levels of {} texels", layout.level_count, layout.tile_size_texels)
    };
    ui.label(format!("DEM {}", levels(&manifest.heights.layout)));
    match &manifest.colours {
        Some(colours) => ui.label(format!("DOM {}", levels(&colours.layout))),
        None => ui.label("no imagery"),
    };
    for line in manifest.sources.iter().chain(&manifest.notes) {
        ui.label(RichText::new(line).weak());
    }
}

fn help(ui: &mut Ui) {
    Grid::new("keys").num_columns(2).striped(true).show(ui, |ui| {
        for (keys, effect) in HELP {
            ui.label(RichText::new(keys).strong());
            ui.label(effect);
            ui.end_row();
        }
    });
}

/// A length in metres or kilometres, whichever is shorter to read.
fn metres(length_m: f64) -> String {
    if length_m.abs() < 10_000.0 {
        format!("{length_m:.0} m")
    } else {
        format!("{:.1} km", length_m / 1_000.0)
    }
}

/// An amount of data in the unit that reads best.
fn bytes(count: u64) -> String {
    match count {
        0..1024 => format!("{count} B"),
        1024..1_048_576 => format!("{:.1} KiB", count as f64 / 1024.0),
        _ => format!("{:.1} MiB", count as f64 / 1_048_576.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_and_amounts_read_well() {
        assert_eq!(metres(812.4), "812 m");
        assert_eq!(metres(12_345.0), "12.3 km");
        assert_eq!(bytes(0), "0 B");
        assert_eq!(bytes(135_000), "131.8 KiB");
        assert_eq!(bytes(3 << 20), "3.0 MiB");
    }
}
