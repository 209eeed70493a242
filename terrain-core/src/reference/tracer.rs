use glam::{DVec2, DVec3, Vec3};

/// What rays through a picture see, whatever the ground lies on. May be asked from many threads at once.
pub(super) trait Tracer: Sync {
    /// The ground in a direction of any length but 0, in the eye's axes; `None` where there is sky.
    fn seen(&self, direction: DVec3) -> Option<Seen>;

    /// Linear light seen through a square of the picture with this middle and side.
    fn colour(&self, position: DVec2, side_px: f64) -> Vec3;
}

/// Ground that a ray meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Seen {
    /// The eye of the view and the way from there in its axes: east, north and up, metres.
    pub point: DVec3,
    /// Metres from the eye.
    pub distance_m: f64,
}
