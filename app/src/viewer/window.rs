//! The window on the terrain: what it holds and how a frame of it comes about.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::DVec2;
use terrain_core::dataset::TileSource;
use terrain_core::gpu::{AdapterChoice, DebugImage, GpuContext};
use terrain_core::measure::CameraSpec;
use terrain_core::{CameraView, RenderError, RendererSettings, TerrainRenderer};
use winit::dpi::LogicalSize;
use winit::event_loop::ActiveEventLoop;
use winit::window::Window;

use super::camera_controls::{CameraControls, ControlBounds};
use super::flight_deck::FlightDeck;
use super::panel::Panel;
use super::plots::FrameHistory;
use super::scene_cache::SceneCache;
use super::surface::{Acquired, SurfaceFrame, WindowSurface};
use super::texture_view::TextureView;
use super::ui_layer::{UiLayer, UiTarget};
use super::window_input::Pointer;
use super::{Next, ViewerOptions};
use crate::flights;

/// Size of a new window, in points.
const FIRST_SIZE: LogicalSize<f64> = LogicalSize::new(1280.0, 720.0);
/// Time that a frame after a rest is taken to last, and the longest that any is, seconds.
const FIRST_FRAME_S: f64 = 1.0 / 60.0;
const LONGEST_FRAME_S: f64 = 0.25;
/// How soon to ask again for a picture of the window that was not to be had.
const RETRY: Duration = Duration::from_millis(10);
/// The eye stays so far above ground: metres, or finest height texels if that is more.
const LEAST_CLEARANCE_M: f64 = 2.0;
const LEAST_CLEARANCE_TEXELS: f64 = 0.05;

/// The window and all it holds.
pub struct TerrainWindow {
    pub(super) window: Arc<Window>,
    pub(super) gpu: Arc<GpuContext>,
    pub(super) surface: WindowSurface,
    pub(super) ui: UiLayer,
    pub(super) renderer: TerrainRenderer,
    pub(super) controls: CameraControls,
    pub(super) pointer: Pointer,
    pub(super) panel_visible: bool,
    /// Whether the window can be seen at all.
    pub(super) hidden: bool,
    source: Arc<dyn TileSource>,
    title: String,
    scene_cache: Option<SceneCache>,
    pub(super) deck: FlightDeck,
    pub(super) record_to: Option<PathBuf>,
    /// Close the window at the end of the flight that plays; not once the user has taken over.
    closes_at_end: bool,
    history: FrameHistory,
    /// Which of the renderer's textures the panel shows, and its picture.
    debug_image: Option<DebugImage>,
    texture_view: Option<TextureView>,
    /// Something to tell, and until when.
    pub(super) notice: Option<(String, Instant)>,
    /// When the last frame was drawn; `None` after a rest.
    last_frame: Option<Instant>,
    /// From the frame before to this one, seconds.
    frame_s: f64,
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
        let renderer = TerrainRenderer::new(Arc::clone(&gpu), source, options.settings)?;
        let controls = first_controls(options, surface.size_px());
        Ok(Self {
            window,
            gpu,
            surface,
            ui,
            renderer,
            controls,
            pointer: Pointer::default(),
            panel_visible: true,
            hidden: false,
            source: Arc::clone(&options.source),
            title: options.title.clone(),
            scene_cache: None,
            deck: first_deck(options),
            record_to: options.record_to.clone(),
            closes_at_end: options.closes_at_end,
            history: FrameHistory::default(),
            debug_image: None,
            texture_view: None,
            notice: None,
            last_frame: None,
            frame_s: FIRST_FRAME_S,
        })
    }

    /// Asks the system to have a frame drawn.
    pub fn request_frame(&self) {
        self.window.request_redraw();
    }

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
        let mut ui_rests_for = Duration::MAX;
        if self.panel_visible {
            ui_rests_for = self.draw_with_panel(&view, &frame)?;
        } else {
            self.scene_cache = None;
            self.draw_scene(&view, &frame.scene_view)?;
        }
        self.window.pre_present_notify();
        frame.present(&self.gpu.queue);
        self.gpu.check()?;
        Ok(self.next(ui_rests_for))
    }

    /// Height of the ground as drawn, for the controls.
    pub(super) fn ground(renderer: &TerrainRenderer) -> impl Fn(DVec2) -> Option<f64> + '_ {
        let exaggeration = renderer.settings().vertical_exaggeration;
        move |xy| renderer.ground_height_m(xy).map(|height_m| height_m * exaggeration)
    }

    /// Stops a flight that plays: the user has taken the controls.
    pub(super) fn take_over(&mut self) {
        self.closes_at_end = false;
        self.deck.stop();
    }

    fn move_camera(&mut self) {
        let now = Instant::now();
        let since = self.last_frame.replace(now).map(|last| (now - last).as_secs_f64());
        self.frame_s = since.unwrap_or(FIRST_FRAME_S);
        let dt_s = self.frame_s.min(LONGEST_FRAME_S);
        if let Some(view) = self.deck.advance(dt_s, self.controls.view().viewport_px) {
            self.controls.set_view(view);
        }
        self.controls.advance(dt_s, &Self::ground(&self.renderer));
        self.deck.take_view(dt_s, self.controls.view());
    }

    fn draw_scene(&mut self, view: &CameraView, target: &wgpu::TextureView) -> anyhow::Result<()> {
        let mut record = self.renderer.render(view, target, self.surface.scene_format())?;
        record.frame_ms = self.frame_s * 1.0e3;
        self.history.push(record);
        for failure in self.renderer.take_failures() {
            self.tell(failure);
        }
        Ok(())
    }

    /// Draws the scene where it has changed, and the panel over it. Returns how long the panel may
    /// stay as it is.
    fn draw_with_panel(
        &mut self,
        view: &CameraView,
        frame: &SurfaceFrame,
    ) -> anyhow::Result<Duration> {
        let label = Some("window");
        let descriptor = wgpu::CommandEncoderDescriptor { label };
        let mut encoder = self.gpu.device.create_command_encoder(&descriptor);
        if self.surface.takes_copies() {
            let cache = self.scene_cache.take().filter(|cache| cache.fits(&self.surface));
            let mut cache = cache.unwrap_or_else(|| SceneCache::new(&self.gpu, &self.surface));
            if !cache.is_drawn || self.renderer.needs_frame(view) {
                self.draw_scene(view, cache.view())?;
                cache.is_drawn = true;
            }
            cache.copy_to(&mut encoder, frame);
            self.scene_cache = Some(cache);
        } else {
            self.draw_scene(view, &frame.scene_view)?;
        }
        let rests_for = self.draw_panel(&mut encoder, &frame.ui_view)?;
        self.gpu.queue.submit([encoder.finish()]);
        Ok(rests_for)
    }

    fn draw_panel(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        view: &wgpu::TextureView,
    ) -> anyhow::Result<Duration> {
        let mut settings = *self.renderer.settings();
        let mut actions = Vec::new();
        let texture = self.draw_debug_image();
        let mut debug_image = self.debug_image;
        let now = Instant::now();
        self.notice.take_if(|(_, until)| *until <= now);
        let mut panel = Panel {
            title: &self.title,
            manifest: self.source.manifest(),
            history: &self.history,
            eye: self.controls.view().eye,
            clearance_m: self.controls.clearance_m(&Self::ground(&self.renderer)),
            has_wireframe: self.has_wireframe(),
            is_recording: self.deck.is_recording(),
            is_playing: self.deck.is_playing(),
            has_flight: self.deck.has_flight(),
            notice: self.notice.as_ref().map(|(text, _)| text.as_str()),
            texture,
            debug_image: &mut debug_image,
            settings: &mut settings,
            actions: &mut actions,
        };
        let target = UiTarget { view, size_px: self.surface.size_px() };
        let rests_for =
            self.ui.draw(&self.gpu, encoder, &self.window, &target, |ui| panel.show(ui));
        if std::mem::replace(&mut self.debug_image, debug_image) != debug_image {
            self.request_frame();
        }
        self.change_settings(settings)?;
        for action in actions {
            self.act(action)?;
        }
        let notice_ends = self.notice.as_ref().map(|(_, until)| until.duration_since(now));
        Ok(rests_for.min(notice_ends.unwrap_or(Duration::MAX)))
    }

    /// Draws the texture that the panel shows, if any.
    fn draw_debug_image(&mut self) -> Option<egui::TextureId> {
        let image = self.debug_image?;
        let ui = &mut self.ui;
        let picture = self.texture_view.get_or_insert_with(|| TextureView::new(&self.gpu, ui));
        Some(picture.draw(&mut self.renderer, image))
    }

    /// What the window needs after a frame.
    fn next(&mut self, ui_rests_for: Duration) -> Next {
        if self.closes_at_end && !self.deck.is_playing() {
            return Next::Close;
        }
        let view = *self.controls.view();
        let moves = self.controls.is_moving() || self.deck.is_playing();
        if moves || self.renderer.needs_frame(&view) || ui_rests_for.is_zero() {
            return Next::Frame;
        }
        self.last_frame = None;
        match Instant::now().checked_add(ui_rests_for) {
            Some(time) if ui_rests_for < Duration::MAX => Next::FrameAt(time),
            _ => Next::Rest,
        }
    }

    pub(super) fn change_settings(&mut self, settings: RendererSettings) -> anyhow::Result<()> {
        let before = *self.renderer.settings();
        let settings = settings.checked();
        if settings == before {
            return Ok(());
        }
        if settings.vertical_exaggeration != before.vertical_exaggeration {
            let scale = settings.vertical_exaggeration / before.vertical_exaggeration;
            self.controls.scale_heights(scale, &Self::ground(&self.renderer));
        }
        match self.renderer.set_settings(settings) {
            // The old settings stay, and the panel shows them again.
            Err(error @ RenderError::CacheTooLarge { .. }) => self.tell(error.to_string()),
            changed => changed?,
        }
        self.scene_cache = None;
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

fn first_deck(options: &ViewerOptions) -> FlightDeck {
    let crs = flights::crs_code(options.source.manifest());
    let mut deck = FlightDeck::new(crs, options.flight.clone());
    if options.plays_at_once {
        deck.play();
    }
    if options.record_to.is_some() {
        deck.record();
    }
    deck
}
