//! The window on the terrain: what it holds, and what changes in it.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use terrain_core::dataset::{Manifest, Shape, TileSource};
use terrain_core::gpu::{AdapterChoice, DebugImage, GpuContext};
use terrain_core::measure::CameraSpec;
use terrain_core::selection::Strategy;
use terrain_core::{CameraView, RenderError, RendererSettings, TerrainRenderer};
use winit::dpi::LogicalSize;
use winit::event_loop::ActiveEventLoop;
use winit::window::Window;

use super::ViewerOptions;
use super::camera_controls::{CameraControls, ControlBounds};
use super::comparison::{Choices, Comparison, Mode};
use super::flight_deck::FlightDeck;
use super::scene::Scene;
use super::surface::WindowSurface;
use super::texture_view::TextureView;
use super::ui_layer::UiLayer;
use super::window_input::Pointer;

/// Size of a new window, in points.
const FIRST_SIZE: LogicalSize<f64> = LogicalSize::new(1280.0, 720.0);
/// Time that a frame after a rest is taken to last, seconds.
pub(super) const FIRST_FRAME_S: f64 = 1.0 / 60.0;
/// The eye stays so far above ground: metres, or finest height texels if that is more.
const LEAST_CLEARANCE_M: f64 = 2.0;
const LEAST_CLEARANCE_TEXELS: f64 = 0.05;

/// The window and all it holds.
pub struct TerrainWindow {
    pub(super) window: Arc<Window>,
    pub(super) gpu: Arc<GpuContext>,
    pub(super) surface: WindowSurface,
    pub(super) ui: UiLayer,
    pub(super) scene: Scene,
    pub(super) comparison: Comparison,
    pub(super) controls: CameraControls,
    pub(super) pointer: Pointer,
    pub(super) panel_visible: bool,
    /// Whether the window can be seen at all.
    pub(super) hidden: bool,
    pub(super) source: Arc<dyn TileSource>,
    pub(super) title: String,
    pub(super) deck: FlightDeck,
    pub(super) record_to: Option<PathBuf>,
    /// Close the window at the end of the flight that plays; not once the user has taken over.
    pub(super) closes_at_end: bool,
    /// Which of the renderer's textures the panel shows, and its picture.
    pub(super) debug_image: Option<DebugImage>,
    pub(super) texture_view: Option<TextureView>,
    /// Something to tell, and until when.
    pub(super) notice: Option<(String, Instant)>,
    /// When the last frame was drawn; `None` after a rest.
    pub(super) last_frame: Option<Instant>,
    /// From the frame before to this one, seconds.
    pub(super) frame_s: f64,
}

impl TerrainWindow {
    /// Opens the window and everything behind it.
    ///
    /// # Errors
    /// Where the window, the device or the renderer cannot be had.
    pub fn open(event_loop: &ActiveEventLoop, options: &ViewerOptions) -> anyhow::Result<Self> {
        let attributes = Window::default_attributes()
            .with_title(format!("{} - terrain", options.title))
            .with_inner_size(FIRST_SIZE);
        let window = Arc::new(event_loop.create_window(attributes)?);
        let (gpu, surface) = open_surface(&window, &options.adapter)?;
        let ui = UiLayer::new(&gpu, &window, surface.format());
        let source = Arc::clone(&options.source);
        let mut renderer = TerrainRenderer::new(Arc::clone(&gpu), source, options.settings)?;
        options.objects.put_into(&mut renderer)?;
        let controls = first_controls(options, surface.size_px());
        let choices = Choices::new(&options.settings, options.compare_with);
        let mut window = Self {
            window,
            gpu,
            surface,
            ui,
            scene: Scene::new(renderer),
            comparison: Comparison::new(choices),
            controls,
            pointer: Pointer::default(),
            panel_visible: true,
            hidden: false,
            source: Arc::clone(&options.source),
            title: options.title.clone(),
            deck: first_deck(options),
            record_to: options.record_to.clone(),
            closes_at_end: options.closes_at_end,
            debug_image: None,
            texture_view: None,
            notice: None,
            last_frame: None,
            frame_s: FIRST_FRAME_S,
        };
        if options.compare_with.is_some() {
            window.change_comparison(Choices { mode: Mode::Split, ..choices })?;
        }
        Ok(window)
    }

    /// Asks the system to have a frame drawn.
    pub fn request_frame(&self) {
        self.window.request_redraw();
    }

    /// Stops a flight that plays: the user has taken the controls.
    pub(super) fn take_over(&mut self) {
        self.closes_at_end = false;
        self.deck.stop();
    }

    /// Changes the first scene's settings; the second one follows.
    pub(super) fn change_settings(&mut self, settings: RendererSettings) -> anyhow::Result<()> {
        let before = *self.scene.settings();
        let settings = settings.checked();
        if settings == before {
            return Ok(());
        }
        if settings.vertical_exaggeration != before.vertical_exaggeration {
            let scale = settings.vertical_exaggeration / before.vertical_exaggeration;
            self.controls.scale_heights(scale, &self.scene.ground());
        }
        match self.scene.set_settings(settings) {
            // The old settings stay, and the panel shows them again.
            Err(error @ RenderError::CacheTooLarge { .. }) => self.tell(error.to_string()),
            changed => changed?,
        }
        self.change_comparison(*self.comparison.choices())
    }

    /// Begins, changes or ends the comparison.
    pub(super) fn change_comparison(&mut self, choices: Choices) -> anyhow::Result<()> {
        if choices != *self.comparison.choices() {
            self.request_frame();
        }
        if choices.mode != Mode::Off && !self.surface.takes_copies() {
            self.tell("this display cannot show two scenes at once".to_owned());
            return Ok(());
        }
        match self.comparison.change(choices, &self.scene, &self.gpu, &self.source) {
            Err(error @ RenderError::CacheTooLarge { .. }) => self.tell(error.to_string()),
            changed => changed?,
        }
        Ok(())
    }
}

/// A device that can draw into the window, and the window's surface.
fn open_surface(
    window: &Arc<Window>,
    adapter: &AdapterChoice,
) -> anyhow::Result<(Arc<GpuContext>, WindowSurface)> {
    let instance = GpuContext::instance(adapter);
    let surface = instance.create_surface(Arc::clone(window))?;
    let gpu = Arc::new(GpuContext::new(instance, adapter, Some(&surface))?);
    let surface = WindowSurface::new(&gpu, surface, window.inner_size().into())?;
    Ok((gpu, surface))
}

/// The camera where the whole area can be seen.
fn first_controls(options: &ViewerOptions, viewport_px: [u32; 2]) -> CameraControls {
    let manifest = options.source.manifest();
    let layout = &manifest.heights.layout;
    let texel_m = layout.texel_size_m(&manifest.scheme, layout.finest_level());
    let range = manifest.heights.range;
    let exaggeration = options.settings.vertical_exaggeration;
    let bounds = ControlBounds {
        data_extent: manifest.data_extent,
        height_range_m: [range.min_m, range.max_m].map(|h| f64::from(h) * exaggeration),
        least_clearance_m: LEAST_CLEARANCE_M.max(LEAST_CLEARANCE_TEXELS * texel_m),
        is_globe: draws_globe(manifest, &options.settings),
    };
    let view = CameraView {
        eye: manifest.data_extent.centre().extend(bounds.height_range_m[1]),
        heading_deg: 0.0,
        pitch_deg: CameraSpec::DEFAULT_PITCH_DEG,
        fov_y_deg: CameraSpec::DEFAULT_FOV_DEG,
        viewport_px,
    };
    let mut controls = CameraControls::new(view, bounds);
    controls.set_view(controls.home_view());
    controls
}

/// Whether the dataset is drawn as a globe with these settings.
pub(super) fn draws_globe(manifest: &Manifest, settings: &RendererSettings) -> bool {
    manifest.shape == Shape::Globe && settings.strategy == Strategy::PageTable
}

fn first_deck(options: &ViewerOptions) -> FlightDeck {
    let manifest = options.source.manifest();
    let place = (manifest.user_crs(), manifest.shape);
    let mut deck = FlightDeck::new(place, options.flight.clone());
    if options.plays_at_once {
        deck.play();
    }
    if options.record_to.is_some() {
        deck.record();
    }
    deck
}
