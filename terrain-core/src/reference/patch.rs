//! One bilinear patch and a ray: exact but for rounding.

use glam::{DVec2, dvec2};

/// The part of a ray that crosses a patch, as a function of the distance `s` from where it comes in.
#[derive(Clone, Copy, Debug)]
pub(super) struct PatchRay {
    /// Place in the patch at `s` = 0: parts of its side from its north-west corner, east and south.
    pub place: DVec2,
    /// How it changes a metre of the way.
    pub step: DVec2,
    /// Height of the ray at `s` = 0, and gained a metre of the way.
    pub z_m: f64,
    /// See `z_m`.
    pub rise: f64,
    /// Length of the part in metres.
    pub length_m: f64,
    /// Factor on the heights of the patch.
    pub exaggeration: f64,
}

/// What a ray meets in a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum PatchCrossing {
    /// It goes below the surface after so many metres.
    Hit(f64),
    /// It does not, and leaves on this side of the surface.
    Leaves(Option<Side>),
}

/// On which side of the surface a ray is. On it counts as above.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    Above,
    Below,
}

impl Side {
    /// Of a height above the surface.
    pub fn of(above_m: f64) -> Self {
        if above_m < 0.0 { Self::Below } else { Self::Above }
    }
}

/// The bilinear surface between four heights: of the north-west, north-east, south-west and
/// south-east corners, in metres.
#[derive(Clone, Copy, Debug)]
pub(super) struct BilinearPatch {
    corner: f64,
    east: f64,
    south: f64,
    twist: f64,
}

impl BilinearPatch {
    pub fn new([nw, ne, sw, se]: [f64; 4]) -> Self {
        Self { corner: nw, east: ne - nw, south: sw - nw, twist: (se - sw) - (ne - nw) }
    }

    /// Height at a place.
    pub fn height_m(&self, place: DVec2) -> f64 {
        let along = self.corner + self.east * place.x;
        along + (self.south + self.twist * place.x) * place.y
    }

    /// Height gained over the patch's side going east and south.
    pub fn gradient(&self, place: DVec2) -> DVec2 {
        dvec2(self.east + self.twist * place.y, self.south + self.twist * place.x)
    }

    /// The coefficient of the product of both coordinates.
    pub fn twist(&self) -> f64 {
        self.twist
    }

    /// Where the ray goes below the surface. `before` is the side it was on when it came to this
    /// patch: a ray that was above and comes in below has met the surface at the very border.
    pub fn crossing(&self, ray: &PatchRay, before: Option<Side>) -> PatchCrossing {
        // The ray's height above the surface is a s^2 + b s + c.
        let slope = self.gradient(ray.place).dot(ray.step);
        let a = -ray.exaggeration * self.twist * ray.step.x * ray.step.y;
        let b = ray.rise - ray.exaggeration * slope;
        let c = ray.z_m - ray.exaggeration * self.height_m(ray.place);
        if before == Some(Side::Above) && c < 0.0 {
            return PatchCrossing::Hit(0.0);
        }
        let end = (a * ray.length_m + b) * ray.length_m + c;
        match descending_root([a, b, c], ray.length_m, end) {
            Some(s) => PatchCrossing::Hit(s),
            None => PatchCrossing::Leaves(Some(Side::of(end))),
        }
    }
}

/// The place in `0..=length` where a s^2 + b s + c goes from not negative to negative; `end` is its
/// value at `length`. By the numerically stable one of the two forms of the root: no difference of
/// nearly equal numbers is taken (as in George Forsythe, "How Do You Solve a Quadratic Equation?",
/// 1966).
fn descending_root([a, b, c]: [f64; 3], length: f64, end: f64) -> Option<f64> {
    let (starts_above, ends_above) = (c >= 0.0, end >= 0.0);
    match (starts_above, ends_above) {
        // From above to below there is always one, whatever the rounding.
        (true, false) => {}
        (false, true) => return None,
        // Both ends on one side: the curve must bend back within.
        (true, true) if a <= 0.0 || b >= 0.0 || -b >= 2.0 * a * length => return None,
        (false, false) if a >= 0.0 || b <= 0.0 || b >= -2.0 * a * length => return None,
        _ => {}
    }
    let discriminant = b * b - 4.0 * a * c;
    if starts_above == ends_above && discriminant <= 0.0 {
        return None;
    }
    // The curve descends at the root: its derivative there is minus the root of the discriminant.
    let root = discriminant.max(0.0).sqrt();
    let s = if b <= 0.0 { 2.0 * c / (root - b) } else { -(b + root) / (2.0 * a) };
    // A ray that touches the surface along its whole length: 0 / 0.
    Some(if s.is_nan() { 0.0 } else { s.clamp(0.0, length) })
}
