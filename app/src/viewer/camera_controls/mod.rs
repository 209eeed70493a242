//! How mouse and keyboard move the camera. Pure: no window types, no clock.

use glam::{DVec2, DVec3, dvec2};
use terrain_core::CameraView;
use terrain_core::tiling::Extent;

use super::camera_glide::CameraGlide;
use super::ground_pick::{GroundHeight, pick_ground, pick_plane};

mod globe;
#[cfg(test)]
mod tests;

/// Rays flatter than this (metres down a metre ahead) do not hold the ground: 3 degrees.
const LEAST_SLOPE: f64 = 0.05;
/// Share of the distance that is left after one step of the wheel towards the ground.
const ZOOM_STEP: f64 = 0.8;
/// Time constants of the softness of wheel and flight, seconds.
const ZOOM_SOFTNESS_S: f64 = 0.07;
const FLIGHT_SOFTNESS_S: f64 = 0.12;
/// Cruising speed, clearances above ground a second, and how much faster with the fast key.
const CRUISE_PER_S: f64 = 0.9;
const FAST_FACTOR: f64 = 4.0;
/// Degrees that the view turns while the mouse crosses the height of the picture.
const TURN_DEG_PER_HEIGHT: f64 = 180.0;
/// The highest and lowest pitch that the mouse can reach, degrees.
const PITCH_RANGE_DEG: (f64, f64) = (-90.0, 60.0);
/// Share of the picture's width or height that the whole area fills.
const HOME_SHARE: f64 = 0.95;
/// How far beyond the data the eye may go, in sizes of the data.
const FREE_SIZES: f64 = 2.0;

/// What the controls must know of the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControlBounds {
    /// The ground that holds data.
    pub data_extent: Extent,
    /// Lowest and highest ground as drawn (exaggerated), metres.
    pub height_range_m: [f64; 2],
    /// The eye keeps at least so far above the ground, metres.
    pub least_clearance_m: f64,
    /// Whether the ground is drawn as a globe.
    pub is_globe: bool,
}

/// What a drag of the mouse does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DragKind {
    /// The ground follows the cursor.
    Pan,
    /// The eye goes round the ground under the cursor.
    Orbit,
    /// The eye stays, the view turns.
    Look,
}

/// Directions held down on the keyboard.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HeldDirections {
    /// Ahead, level.
    pub forward: bool,
    /// Back, level.
    pub backward: bool,
    /// To the left.
    pub left: bool,
    /// To the right.
    pub right: bool,
    /// Up.
    pub up: bool,
    /// Down.
    pub down: bool,
    /// All of them faster.
    pub fast: bool,
}

#[derive(Clone, Copy, Debug)]
enum Drag {
    /// The point of ground that stays under the cursor; over a globe in earth-centred coordinates, as all such points.
    Pan { anchor: DVec3 },
    /// The point to turn about and where the cursor was.
    Turn { centre: DVec3, last_px: [f64; 2] },
}

#[derive(Clone, Copy, Debug)]
struct Zoom {
    target: DVec3,
    /// Steps of the wheel not made yet; positive towards the target.
    steps_left: f64,
}

/// The camera and everything that moves it.
pub struct CameraControls {
    view: CameraView,
    bounds: ControlBounds,
    drag: Option<Drag>,
    zoom: Option<Zoom>,
    glide: Option<CameraGlide>,
    held: HeldDirections,
    /// Flight in clearances a second: right, forward, up.
    velocity: DVec3,
}

impl CameraControls {
    /// Controls that start with this view.
    pub fn new(view: CameraView, bounds: ControlBounds) -> Self {
        Self {
            view,
            bounds,
            drag: None,
            zoom: None,
            glide: None,
            held: HeldDirections::default(),
            velocity: DVec3::ZERO,
        }
    }

    /// Where the camera is now.
    pub fn view(&self) -> &CameraView {
        &self.view
    }

    /// Puts the camera somewhere and stops whatever moved it. The viewport stays.
    pub fn set_view(&mut self, view: CameraView) {
        self.stop();
        self.view = CameraView { viewport_px: self.view.viewport_px, ..view };
    }

    /// The picture has another size now. Sizes of 0 (a minimised window) are taken as 1.
    pub fn resize(&mut self, viewport_px: [u32; 2]) {
        self.view.viewport_px = viewport_px.map(|side| side.max(1));
        self.drag = None;
    }

    /// The heights are drawn `scale` times as high as before. The eye keeps its height above the
    /// ground; `ground` tells heights as they were drawn before.
    pub fn scale_heights(&mut self, scale: f64, ground: GroundHeight<'_>) {
        let lowest_m = self.bounds.height_range_m[0];
        let ground_m = ground(self.view.eye.truncate()).unwrap_or(lowest_m);
        self.view.eye.z += ground_m * (scale - 1.0);
        self.bounds.height_range_m = self.bounds.height_range_m.map(|height_m| height_m * scale);
    }

    /// A mouse button goes down at a pixel.
    pub fn begin_drag(&mut self, kind: DragKind, pixel: [f64; 2], ground: GroundHeight<'_>) {
        self.stop();
        let point = self.point_under(pixel, ground);
        self.drag = Some(match kind {
            DragKind::Pan if self.bounds.is_globe => Drag::Pan { anchor: point },
            DragKind::Pan => {
                // Through the same bent ray as later moves, or the first one would jump.
                Drag::Pan { anchor: pick_plane(&self.view, pixel, point.z, LEAST_SLOPE) }
            }
            DragKind::Orbit => Drag::Turn { centre: point, last_px: pixel },
            DragKind::Look => Drag::Turn { centre: self.view.eye, last_px: pixel },
        });
    }

    /// The mouse moves to a pixel. Returns whether the camera moved.
    pub fn drag_to(&mut self, pixel: [f64; 2], ground: GroundHeight<'_>) -> bool {
        match &mut self.drag {
            None => return false,
            Some(Drag::Pan { anchor }) if self.bounds.is_globe => {
                self.view = globe::pan(&self.view, *anchor, pixel);
            }
            Some(Drag::Pan { anchor }) => {
                let under = pick_plane(&self.view, pixel, anchor.z, LEAST_SLOPE);
                self.view.eye += (*anchor - under).with_z(0.0);
            }
            Some(Drag::Turn { centre, last_px }) => {
                let centre = *centre;
                let moved = [pixel[0] - last_px[0], pixel[1] - last_px[1]];
                *last_px = pixel;
                self.turn_about(centre, moved);
            }
        }
        self.stay_in_bounds(ground);
        true
    }

    /// The mouse button goes up.
    pub fn end_drag(&mut self) {
        self.drag = None;
    }

    /// The wheel turns over a pixel; positive steps go towards the ground.
    pub fn wheel(&mut self, steps: f64, pixel: [f64; 2], ground: GroundHeight<'_>) {
        self.glide = None;
        let steps_left = self.zoom.map_or(0.0, |zoom| zoom.steps_left) + steps;
        self.zoom = Some(Zoom { target: self.point_under(pixel, ground), steps_left });
    }

    /// The keys held down have changed.
    pub fn set_held(&mut self, held: HeldDirections) {
        self.held = held;
        if held.is_any() {
            self.glide = None;
        }
    }

    /// Says whether the ground is drawn as a globe from now on, or as a plane.
    pub fn set_is_globe(&mut self, is_globe: bool) {
        if is_globe != self.bounds.is_globe {
            self.bounds.is_globe = is_globe;
            self.drag = None;
            self.stop();
        }
    }

    /// Goes to where the whole area can be seen.
    pub fn go_home(&mut self) {
        let home = self.home_view();
        self.glide_to(home);
    }

    /// Turns north up about the middle of the picture.
    pub fn go_north_up(&mut self, ground: GroundHeight<'_>) {
        let [width, height] = self.view.viewport_px.map(f64::from);
        let centre = self.point_under([0.5 * width, 0.5 * height], ground);
        if self.bounds.is_globe {
            let turn_deg = -self.view.heading_deg;
            self.glide_to(globe::turn_about(&self.view, centre, turn_deg, self.view.pitch_deg));
            return;
        }
        let mut goal = self.view;
        goal.heading_deg = 0.0;
        let distance_m = (centre - self.view.eye).length();
        goal.eye = centre - goal.forward() * distance_m;
        self.glide_to(goal);
    }

    /// Lets `dt_s` seconds pass. Returns whether the camera moved or still moves.
    pub fn advance(&mut self, dt_s: f64, ground: GroundHeight<'_>) -> bool {
        let before = self.view;
        if let Some(mut glide) = self.glide.take() {
            let (view, arrived) = glide.advance(dt_s);
            self.view = view;
            self.glide = (!arrived).then_some(glide);
        }
        self.advance_zoom(dt_s);
        self.advance_flight(dt_s, ground);
        self.stay_in_bounds(ground);
        self.view != before || self.is_moving()
    }

    /// Whether the camera moves by itself: a key is held, or a soft move is not at its end.
    pub fn is_moving(&self) -> bool {
        self.glide.is_some()
            || self.zoom.is_some()
            || self.held.is_any()
            || self.velocity != DVec3::ZERO
    }

    /// Metres above the ground below the eye, or above the lowest ground where there is no data.
    pub fn clearance_m(&self, ground: GroundHeight<'_>) -> f64 {
        let ground_m = ground(self.view.eye.truncate()).unwrap_or(self.bounds.height_range_m[0]);
        (self.view.eye.z - ground_m).max(self.bounds.least_clearance_m)
    }

    /// The view of the whole area, from the south: as near as shows every corner.
    pub fn home_view(&self) -> CameraView {
        if self.bounds.is_globe {
            return globe::home(&self.view);
        }
        let extent = &self.bounds.data_extent;
        let [lowest_m, highest_m] = self.bounds.height_range_m;
        let mut view = CameraView { heading_deg: 0.0, pitch_deg: -45.0, ..self.view };
        let half_height = HOME_SHARE * (0.5 * view.fov_y_deg.to_radians()).tan();
        let half_width = half_height * view.aspect();
        let middle = extent.centre().extend(0.5 * (lowest_m + highest_m));
        let half = (0.5 * extent.size_m()).extend(0.5 * (highest_m - lowest_m));
        let in_view = view.view_from_world();
        let distance_for = |corner: u8| {
            let sign = |bit: u8| if corner & bit == 0 { -1.0 } else { 1.0 };
            let corner = in_view * (half * DVec3::new(sign(1), sign(2), sign(4)));
            // |x| <= half_width * depth and |y| <= half_height * depth, depth = distance - z.
            corner.z + (corner.x.abs() / half_width).max(corner.y.abs() / half_height)
        };
        let distance_m = (0..8).map(distance_for).fold(0.0, f64::max);
        view.eye = middle - view.forward() * distance_m;
        view
    }

    fn stop(&mut self) {
        self.glide = None;
        self.zoom = None;
        self.velocity = DVec3::ZERO;
    }

    fn glide_to(&mut self, goal: CameraView) {
        self.stop();
        self.glide = Some(CameraGlide::new(self.view, goal));
    }

    /// The ground under a pixel; without data there, the level of the ground below the eye.
    fn point_under(&self, pixel: [f64; 2], ground: GroundHeight<'_>) -> DVec3 {
        let clearance_m = self.clearance_m(ground);
        if self.bounds.is_globe {
            return globe::point_under(&self.view, pixel, ground, clearance_m);
        }
        let near_m = 0.1 * clearance_m;
        let far_m = 4.0 * self.bounds.data_extent.size_m().length() + 2.0 * clearance_m;
        pick_ground(&self.view, pixel, ground, near_m, far_m).unwrap_or_else(|| {
            pick_plane(&self.view, pixel, self.view.eye.z - clearance_m, LEAST_SLOPE)
        })
    }

    /// Turns eye and view about a point, which keeps its place in the picture.
    fn turn_about(&mut self, centre: DVec3, moved_px: [f64; 2]) {
        let degrees_per_px = TURN_DEG_PER_HEIGHT / f64::from(self.view.viewport_px[1]);
        let turn_deg = moved_px[0] * degrees_per_px;
        let pitch_deg = (self.view.pitch_deg - moved_px[1] * degrees_per_px)
            .clamp(PITCH_RANGE_DEG.0, PITCH_RANGE_DEG.1);
        let is_about_eye = centre == self.view.eye;
        if self.bounds.is_globe && !is_about_eye {
            self.view = globe::turn_about(&self.view, centre, turn_deg, pitch_deg);
            return;
        }
        let in_view = self.view.view_from_world() * (centre - self.view.eye);
        self.view.heading_deg = (self.view.heading_deg + turn_deg).rem_euclid(360.0);
        self.view.pitch_deg = pitch_deg;
        self.view.eye = centre - self.view.view_from_world().transpose() * in_view;
    }

    fn advance_zoom(&mut self, dt_s: f64) {
        let Some(zoom) = &mut self.zoom else { return };
        let steps = zoom.steps_left * (1.0 - (-dt_s / ZOOM_SOFTNESS_S).exp());
        // The last hundredth of a step is made at once, so that the wheel comes to rest.
        let steps = if zoom.steps_left.abs() < 0.01 { zoom.steps_left } else { steps };
        let part = ZOOM_STEP.powf(steps);
        if self.bounds.is_globe {
            self.view = globe::zoom(&self.view, zoom.target, part);
        } else {
            self.view.eye = zoom.target + (self.view.eye - zoom.target) * part;
        }
        zoom.steps_left -= steps;
        if zoom.steps_left == 0.0 {
            self.zoom = None;
        }
    }

    fn advance_flight(&mut self, dt_s: f64, ground: GroundHeight<'_>) {
        let goal = self.held.velocity();
        self.velocity += (goal - self.velocity) * (1.0 - (-dt_s / FLIGHT_SOFTNESS_S).exp());
        if goal == DVec3::ZERO && self.velocity.length() < 0.005 {
            self.velocity = DVec3::ZERO;
        }
        let metres = self.velocity * (self.clearance_m(ground) * dt_s);
        if self.bounds.is_globe {
            self.view = globe::fly(&self.view, metres);
            return;
        }
        let (sin_heading, cos_heading) = self.view.heading_deg.to_radians().sin_cos();
        let right = dvec2(cos_heading, -sin_heading);
        let forward = dvec2(sin_heading, cos_heading);
        self.view.eye += (right * metres.x + forward * metres.y).extend(metres.z);
    }

    /// Keeps the eye above the ground and near the data.
    fn stay_in_bounds(&mut self, ground: GroundHeight<'_>) {
        let bounds = &self.bounds;
        if bounds.is_globe {
            let ground_m = ground(self.view.eye.truncate()).unwrap_or(bounds.height_range_m[0]);
            let floor_m = ground_m + bounds.least_clearance_m;
            self.view.eye.z = self.view.eye.z.clamp(floor_m, globe::CEILING_M.max(floor_m));
            return;
        }
        let size_m = bounds.data_extent.size_m().max_element();
        let room = bounds.data_extent.grown(FREE_SIZES * size_m);
        let xy: DVec2 = self.view.eye.truncate().clamp(room.min, room.max);
        let floor_m = ground(xy).unwrap_or(bounds.height_range_m[0]) + bounds.least_clearance_m;
        let ceiling_m = bounds.height_range_m[1] + 2.0 * FREE_SIZES * size_m;
        self.view.eye = xy.extend(self.view.eye.z.clamp(floor_m, ceiling_m.max(floor_m)));
    }
}

impl HeldDirections {
    /// Whether any direction is held; the fast key alone moves nothing.
    pub fn is_any(&self) -> bool {
        self.forward || self.backward || self.left || self.right || self.up || self.down
    }

    /// The velocity asked for, clearances a second: right, forward, up.
    fn velocity(&self) -> DVec3 {
        let axis = |plus: bool, minus: bool| f64::from(i8::from(plus) - i8::from(minus));
        let speed = CRUISE_PER_S * if self.fast { FAST_FACTOR } else { 1.0 };
        speed
            * DVec3::new(
                axis(self.right, self.left),
                axis(self.forward, self.backward),
                axis(self.up, self.down),
            )
    }
}
