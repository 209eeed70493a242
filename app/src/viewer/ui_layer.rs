//! The user interface over the picture: egui, fed by winit, drawn by wgpu.

use std::time::Duration;

use terrain_core::gpu::GpuContext;
use winit::event::WindowEvent;
use winit::window::Window;

/// egui and what it takes to draw it.
pub struct UiLayer {
    context: egui::Context,
    state: egui_winit::State,
    renderer: egui_wgpu::Renderer,
}

/// Where to draw.
pub struct UiTarget<'a> {
    /// The picture's view in the format given to [`UiLayer::new`].
    pub view: &'a wgpu::TextureView,
    /// Its width and height in pixels.
    pub size_px: [u32; 2],
}

/// What a window event means to the user interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UiResponse {
    /// The event is the user interface's own; the scene must not react.
    pub consumed: bool,
    /// The user interface looks different now.
    pub repaint: bool,
}

impl UiLayer {
    /// A user interface for a window whose pictures have this format.
    pub fn new(gpu: &GpuContext, window: &Window, format: wgpu::TextureFormat) -> Self {
        let context = egui::Context::default();
        context.set_visuals(egui::Visuals::dark());
        let state = egui_winit::State::new(
            context.clone(),
            egui::ViewportId::ROOT,
            window,
            Some(window.scale_factor() as f32),
            Some(winit::window::Theme::Dark),
            Some(gpu.device.limits().max_texture_dimension_2d as usize),
        );
        let renderer = egui_wgpu::Renderer::new(&gpu.device, format, Default::default());
        Self { context, state, renderer }
    }

    /// Passes a window event on.
    pub fn on_event(&mut self, window: &Window, event: &WindowEvent) -> UiResponse {
        let was_under = self.is_under_pointer();
        let response = self.state.on_window_event(window, event);
        let repaint = match event {
            // Every motion asks for a repaint, but over the scene nothing of the panel changes.
            WindowEvent::CursorMoved { .. } => {
                response.consumed || was_under || self.is_under_pointer()
            }
            // The frame asked for is no reason to ask for the next one.
            WindowEvent::RedrawRequested => false,
            _ => response.repaint,
        };
        let consumed = match event {
            // egui would judge by where the pointer was when it drew last.
            WindowEvent::MouseInput { .. } | WindowEvent::MouseWheel { .. } => {
                self.context.egui_is_using_pointer() || self.is_under_pointer()
            }
            // A button keeps the focus after a click; only a text field wants the letters.
            WindowEvent::KeyboardInput { .. } => self.context.text_edit_focused(),
            _ => response.consumed,
        };
        UiResponse { consumed, repaint }
    }

    /// Whether something of the user interface lies where the pointer is now.
    fn is_under_pointer(&self) -> bool {
        // Motions that egui has not seen yet count, the last one first.
        let moved = self.state.egui_input().events.iter().rev().find_map(|event| match event {
            egui::Event::PointerMoved(position) => Some(*position),
            _ => None,
        });
        moved
            .or_else(|| self.context.pointer_latest_pos())
            .and_then(|position| self.context.layer_id_at(position))
            .is_some_and(|layer| layer.order != egui::Order::Background)
    }

    /// Makes a texture of the scene's device known to the user interface.
    pub fn register(&mut self, gpu: &GpuContext, view: &wgpu::TextureView) -> egui::TextureId {
        self.renderer.register_native_texture(&gpu.device, view, wgpu::FilterMode::Linear)
    }

    /// Builds the user interface and draws it over the picture. Returns how long it may stay as it
    /// is; `Duration::MAX` until something happens.
    pub fn draw(
        &mut self,
        gpu: &GpuContext,
        encoder: &mut wgpu::CommandEncoder,
        window: &Window,
        target: &UiTarget<'_>,
        build: impl FnMut(&mut egui::Ui),
    ) -> Duration {
        let input = self.state.take_egui_input(window);
        let mut output = self.context.run_ui(input, build);
        self.state.handle_platform_output(window, std::mem::take(&mut output.platform_output));
        for (id, deltas) in output.textures_delta.set.drain() {
            for delta in deltas {
                self.renderer.update_texture(&gpu.device, &gpu.queue, id, &delta);
            }
        }
        let shapes = std::mem::take(&mut output.shapes);
        let jobs = self.context.tessellate(shapes, output.pixels_per_point);
        let screen = egui_wgpu::ScreenDescriptor {
            size_in_pixels: target.size_px,
            pixels_per_point: output.pixels_per_point,
        };
        self.paint(gpu, encoder, target.view, &jobs, &screen);
        for id in output.textures_delta.free.drain() {
            self.renderer.free_texture(&id);
        }
        let root = output.viewport_output.get(&egui::ViewportId::ROOT);
        root.map_or(Duration::MAX, |viewport| viewport.repaint_delay)
    }

    fn paint(
        &mut self,
        gpu: &GpuContext,
        encoder: &mut wgpu::CommandEncoder,
        view: &wgpu::TextureView,
        jobs: &[egui::ClippedPrimitive],
        screen: &egui_wgpu::ScreenDescriptor,
    ) {
        // Only paint callbacks bring command buffers of their own, and there are none here.
        self.renderer.update_buffers(&gpu.device, &gpu.queue, encoder, jobs, screen);
        let mut pass = encoder
            .begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("user interface"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store },
                })],
                ..Default::default()
            })
            .forget_lifetime();
        self.renderer.render(&mut pass, jobs, screen);
    }
}
