//! What the window's events do.

use winit::event::{ElementState, KeyEvent, MouseButton, MouseScrollDelta, WindowEvent};
use winit::keyboard::ModifiersState;
use winit::window::CursorIcon;

use super::Next;
use super::camera_controls::{DragKind, HeldDirections};
use super::keys::{self, Action};
use super::window::TerrainWindow;

/// Pixels of a touchpad's motion that make a step of a wheel.
const PIXELS_A_STEP: f64 = 60.0;

/// Where the pointer is and which keys are down.
#[derive(Default)]
pub struct Pointer {
    position_px: [f64; 2],
    /// The button that began the drag under way.
    drag_button: Option<MouseButton>,
    /// Whether the comparison's divider is under the pointer.
    is_over_divider: bool,
    /// Whether it is being dragged.
    drags_divider: bool,
    modifiers: ModifiersState,
    held: HeldDirections,
}

impl TerrainWindow {
    /// Takes an event of the window.
    pub(super) fn on_event(&mut self, event: &WindowEvent) -> anyhow::Result<Next> {
        let mut wants_frame = false;
        let mut consumed = false;
        if self.has_ui() {
            let response = self.ui.on_event(&self.window, event);
            wants_frame = response.repaint;
            consumed = response.consumed;
        }
        match event {
            WindowEvent::RedrawRequested => return self.draw(),
            WindowEvent::CloseRequested => return Ok(Next::Close),
            WindowEvent::Resized(size) => wants_frame |= self.on_resize((*size).into()),
            WindowEvent::ScaleFactorChanged { .. } => wants_frame = true,
            WindowEvent::Occluded(hidden) => {
                self.hidden = *hidden;
                wants_frame |= !hidden;
            }
            WindowEvent::Focused(false) => {
                self.let_go();
                wants_frame = true;
            }
            WindowEvent::ModifiersChanged(modifiers) => self.pointer.modifiers = modifiers.state(),
            WindowEvent::KeyboardInput { event, .. } => {
                match self.on_key(event, consumed) {
                    Some(Action::Quit) => return Ok(Next::Close),
                    Some(action) => {
                        self.act(action)?;
                        wants_frame = true;
                    }
                    None => wants_frame |= self.controls.is_moving(),
                };
            }
            WindowEvent::CursorMoved { position, .. } => {
                wants_frame |= self.on_cursor((*position).into());
            }
            WindowEvent::MouseInput { state, button, .. } => {
                self.on_button(*state, *button, consumed);
            }
            WindowEvent::MouseWheel { delta, .. } if !consumed => {
                self.on_wheel(*delta);
                wants_frame = true;
            }
            _ => {}
        }
        Ok(if wants_frame { Next::Frame } else { Next::Rest })
    }

    fn on_resize(&mut self, size_px: [u32; 2]) -> bool {
        let is_visible = !size_px.contains(&0);
        self.hidden = !is_visible;
        if is_visible {
            self.surface.resize(&self.gpu, size_px);
            self.controls.resize(size_px);
        }
        is_visible
    }

    /// Lets go of all keys and buttons: their release will not be told to a window without focus.
    fn let_go(&mut self) {
        self.pointer.held = HeldDirections::default();
        self.controls.set_held(self.pointer.held);
        self.pointer.drag_button = None;
        self.controls.end_drag();
        self.pointer.drags_divider = false;
        self.comparison.shows_second_alone = false;
    }

    fn on_key(&mut self, event: &KeyEvent, consumed: bool) -> Option<Action> {
        let down = event.state == ElementState::Pressed;
        // A key that goes up is always noted, or it would stay held.
        if consumed && down {
            return None;
        }
        let with_command =
            self.pointer.modifiers.control_key() || self.pointer.modifiers.super_key();
        if !(with_command && down) && keys::hold(&mut self.pointer.held, &event.physical_key, down)
        {
            if self.pointer.held.is_any() {
                self.take_over();
            }
            self.controls.set_held(self.pointer.held);
            return None;
        }
        if !down {
            return keys::release(&event.logical_key);
        }
        (!event.repeat && !with_command)
            .then(|| keys::action(&event.logical_key, &event.physical_key))
            .flatten()
    }

    fn on_cursor(&mut self, position_px: [f64; 2]) -> bool {
        self.pointer.position_px = position_px;
        let width_px = self.surface.size_px()[0];
        if self.pointer.drags_divider {
            self.comparison.move_divider(position_px[0], width_px);
            return true;
        }
        self.find_divider(width_px);
        self.controls.drag_to(position_px, &self.scene.ground())
    }

    /// Notes whether the divider is under the pointer, and shows it by the pointer's form.
    fn find_divider(&mut self, width_px: u32) {
        let scale = self.window.scale_factor();
        let is_over = self.comparison.has_divider_at(self.pointer.position_px[0], width_px, scale);
        if std::mem::replace(&mut self.pointer.is_over_divider, is_over) != is_over {
            let icon = if is_over { CursorIcon::ColResize } else { CursorIcon::Default };
            self.window.set_cursor(icon);
        }
    }

    fn on_button(&mut self, state: ElementState, button: MouseButton, consumed: bool) {
        if button == MouseButton::Left {
            let is_down = state == ElementState::Pressed;
            self.pointer.drags_divider = is_down && !consumed && self.pointer.is_over_divider;
            if self.pointer.drags_divider {
                return;
            }
        }
        if state == ElementState::Released {
            if self.pointer.drag_button == Some(button) {
                self.pointer.drag_button = None;
                self.controls.end_drag();
            }
            return;
        }
        let kind = match button {
            MouseButton::Left if self.pointer.modifiers.control_key() => DragKind::Orbit,
            MouseButton::Left => DragKind::Pan,
            MouseButton::Right => DragKind::Orbit,
            MouseButton::Middle => DragKind::Look,
            _ => return,
        };
        if !consumed {
            self.take_over();
            self.pointer.drag_button = Some(button);
            let ground = self.scene.ground();
            self.controls.begin_drag(kind, self.pointer.position_px, &ground);
        }
    }

    fn on_wheel(&mut self, delta: MouseScrollDelta) {
        let steps = match delta {
            MouseScrollDelta::LineDelta(_, lines) => f64::from(lines),
            MouseScrollDelta::PixelDelta(pixels) => pixels.y / PIXELS_A_STEP,
        };
        self.take_over();
        let ground = self.scene.ground();
        self.controls.wheel(steps, self.pointer.position_px, &ground);
    }
}
