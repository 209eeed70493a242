//! The window: terrain to fly over with mouse and keyboard, and a panel that shows what it costs.

mod camera_controls;
mod camera_glide;
mod comparison;
mod flight_deck;
mod ground_pick;
mod keys;
mod panel;
mod plots;
mod scene;
mod scene_cache;
mod surface;
mod texture_view;
mod ui_layer;
mod window;
mod window_actions;
mod window_frame;
mod window_input;
mod window_ui;

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use anyhow::Context;
use terrain_core::RendererSettings;
use terrain_core::dataset::TileSource;
use terrain_core::gpu::AdapterChoice;
use terrain_core::measure::Flight;
use terrain_core::selection::Strategy;
use winit::application::ApplicationHandler;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop};
use winit::window::WindowId;

use crate::scene_args::SceneObjects;
use window::TerrainWindow;

/// What to open a window on.
pub struct ViewerOptions {
    /// The terrain.
    pub source: Arc<dyn TileSource>,
    /// What stands on it, and other ground.
    pub objects: SceneObjects,
    /// Its name for people.
    pub title: String,
    /// The adapter to draw with.
    pub adapter: AdapterChoice,
    /// The settings to begin with.
    pub settings: RendererSettings,
    /// The strategy to compare with from the first frame on.
    pub compare_with: Option<Strategy>,
    /// A flight to play.
    pub flight: Option<Flight>,
    /// Whether the flight begins at once.
    pub plays_at_once: bool,
    /// Whether the window closes when the flight that began at once has been flown.
    pub closes_at_end: bool,
    /// Where to record what is flown, from the first frame on.
    pub record_to: Option<PathBuf>,
}

/// What the window needs next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Next {
    /// Another frame at once.
    Frame,
    /// Another frame at this time, unless something happens before.
    FrameAt(Instant),
    /// Nothing until something happens.
    Rest,
    /// To be closed.
    Close,
}

/// Opens the window; returns when it is closed.
///
/// # Errors
/// Where there is no display or no adapter for it, or the device fails meanwhile.
pub fn run(options: ViewerOptions) -> anyhow::Result<()> {
    let event_loop = EventLoop::new().context("no window can be opened (is there a display?)")?;
    event_loop.set_control_flow(ControlFlow::Wait);
    let mut viewer = Viewer { options, window: None, failure: None };
    event_loop.run_app(&mut viewer).context("the window's event loop failed")?;
    viewer.failure.map_or(Ok(()), Err)
}

struct Viewer {
    options: ViewerOptions,
    window: Option<TerrainWindow>,
    failure: Option<anyhow::Error>,
}

impl Viewer {
    fn follow(&mut self, event_loop: &ActiveEventLoop, outcome: anyhow::Result<Next>) {
        let next = outcome.unwrap_or_else(|error| {
            self.failure.get_or_insert(error);
            Next::Close
        });
        match next {
            Next::Frame => {
                event_loop.set_control_flow(ControlFlow::Wait);
                self.request_frame();
            }
            Next::FrameAt(time) => event_loop.set_control_flow(ControlFlow::WaitUntil(time)),
            Next::Rest => {}
            Next::Close => event_loop.exit(),
        }
    }

    fn request_frame(&self) {
        if let Some(window) = &self.window {
            window.request_frame();
        }
    }
}

impl ApplicationHandler for Viewer {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.window.is_none() {
            let opened = TerrainWindow::open(event_loop, &self.options);
            let outcome = opened.map(|window| self.window = Some(window)).map(|()| Next::Frame);
            self.follow(event_loop, outcome);
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        if let Some(window) = &mut self.window {
            let outcome = window.on_event(&event);
            self.follow(event_loop, outcome);
        }
    }

    fn new_events(&mut self, event_loop: &ActiveEventLoop, cause: winit::event::StartCause) {
        if matches!(cause, winit::event::StartCause::ResumeTimeReached { .. }) {
            event_loop.set_control_flow(ControlFlow::Wait);
            self.request_frame();
        }
    }

    fn exiting(&mut self, _: &ActiveEventLoop) {
        let saved = self.window.take().map_or(Ok(()), |mut window| window.save_recording());
        if let Err(error) = saved {
            self.failure.get_or_insert(error);
        }
    }
}
