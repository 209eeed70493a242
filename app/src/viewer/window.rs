//! The window on the terrain: what it holds and how a frame of it comes about.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::DVec2;
use terrain_core::dataset::{Manifest, TileSource};
use terrain_core::gpu::{DebugImage, GpuContext, OFFSCREEN_FORMAT, OffscreenTarget};
use terrain_core::measure::CameraSpec;
use terrain_core::{CameraView, RendererSettings, TerrainRenderer};
use winit::dpi::LogicalSize;
use winit::event_loop::ActiveEventLoop;
use winit::window::{Fullscreen, Window};

use super::camera_controls::{CameraControls, ControlBounds};
use super::flight_deck::FlightDeck;
use super::keys::Action;
use super::panel::Panel;
use super::plots::FrameHistory;

use super::scene_cache::SceneCache;
use super::surface::{Acquired, SurfaceFrame, WindowSurface};
use super::texture_view::TextureView;
use super::ui_layer::{UiLayer, UiTarget};
use super::window_input::Pointer;
use super::{Next, ViewerOptions};
use crate::pictures::{free_name, write_png};
use crate::{flights, output};

/// Size of a new window, in points.
const FIRST_SIZE: LogicalSize<f64> = LogicalSize::new(1280.0, 720.0);
/// Time that a frame after a rest is taken to last, and the longest that any is, seconds.
const FIRST_FRAME_S: f64 = 1.0 / 60.0;
const LONGEST_FRAME_S: f64 = 0.25;
/// How soon to ask again for a picture of the window that was not to be had.
const RETRY: Duration = Duration::from_millis(10);
/// How long a notice is shown.
const NOTICE: Duration = Duration::from_secs(6);
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
    deck: FlightDeck,
    record_to: Option<PathBuf>,
    /// Close the window at the end of the flight that plays; not once the user has taken over.
    closes_at_end: bool,
    history: FrameHistory,
    /// Which of the renderer's textures the panel shows, and its picture.
    debug_image: Option<DebugImage>,
    texture_view: Option<TextureView>,
    notice: Option<(String, Instant)>,
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
        let instance = GpuContext::instance(&options.adapter);
        let surface = instance.create_surface(Arc::clone(&window))?;
        let gpu = Arc::new(GpuContext::new(instance, &options.adapter, Some(&surface))?);
        let size_px: [u32; 2] = window.inner_size().into();
        let surface = WindowSurface::new(&gpu, surface, size_px)?;
        let ui = UiLayer::new(&gpu, &window, surface.format());
        let source = Arc::clone(&options.source);
        let renderer = TerrainRenderer::new(Arc::clone(&gpu), source, options.settings)?;
        let manifest = options.source.manifest();
        let exaggeration = options.settings.vertical_exaggeration;
        let mut controls = first_controls(manifest, exaggeration, surface.size_px());
        controls.set_view(controls.home_view());
        let mut deck = FlightDeck::new(flights::crs_code(manifest), options.flight.clone());
        if options.plays_at_once {
            deck.play();
        }
        if options.record_to.is_some() {
            deck.record();
        }
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
            deck,
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

    fn change_settings(&mut self, settings: RendererSettings) -> anyhow::Result<()> {
        let before = *self.renderer.settings();
        let settings = settings.checked();
        if settings == before {
            return Ok(());
        }
        if settings.vertical_exaggeration != before.vertical_exaggeration {
            let scale = settings.vertical_exaggeration / before.vertical_exaggeration;
            self.controls.scale_heights(scale, &Self::ground(&self.renderer));
        }
        self.renderer.set_settings(settings)?;
        self.scene_cache = None;
        Ok(())
    }

    /// Does what a key or a button asks for. [`Action::Quit`] is the caller's.
    pub(super) fn act(&mut self, action: Action) -> anyhow::Result<()> {
        use terrain_core::DebugView;
        let mut settings = *self.renderer.settings();
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
                self.controls.go_north_up(&Self::ground(&self.renderer));
            }
            Action::TakeScreenshot => self.take_screenshot()?,
            Action::ToggleRecording if self.deck.is_recording() => self.save_recording()?,
            Action::ToggleRecording => {
                self.deck.record();
                self.tell("recording; R ends it".to_owned());
            }
            Action::TogglePlaying => self.toggle_playing(),
            Action::ToggleFullscreen => self.toggle_fullscreen(),
        }
        self.change_settings(settings)
    }

    fn has_wireframe(&self) -> bool {
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

    fn take_screenshot(&mut self) -> anyhow::Result<()> {
        let view = *self.controls.view();
        let target = OffscreenTarget::new(&self.gpu, view.viewport_px);
        self.renderer.render(&view, target.view(), OFFSCREEN_FORMAT)?;
        let rgba = target.read_rgba8(&self.gpu)?;
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
        let path = self.record_to.take().unwrap_or_else(|| free_name("terrain-flight", "json"));
        flight.write(&path)?;
        let duration_s = flight.duration_s();
        self.tell(format!("flight of {duration_s:.1} s saved as {}", path.display()));
        Ok(())
    }

    /// Tells the user something, in the window and on stderr.
    fn tell(&mut self, text: String) {
        output::say(&format!("terrain: {text}"));
        self.notice = Some((text, Instant::now() + NOTICE));
    }
}

fn first_controls(manifest: &Manifest, exaggeration: f64, viewport_px: [u32; 2]) -> CameraControls {
    let layout = &manifest.heights.layout;
    let texel_m = layout.texel_size_m(&manifest.scheme, layout.finest_level());
    let range = manifest.heights.range;
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
    CameraControls::new(view, bounds)
}
