//! A patch at the edge of the data: some of its corners hold none.
//!
//! Its height is the mean of the corners that do, by their bilinear weights: a quotient N / D. A ray
//! meets it where z D - e N, a cubic along the ray, is zero, within the part where D, the share of
//! the data, is enough.

use glam::DVec2;

use super::patch::{BilinearPatch, PatchCrossing, PatchRay, Side};

/// A patch with corners missing: NaN of the four heights.
#[derive(Clone, Copy, Debug)]
pub(super) struct PartialPatch {
    /// Sum of the heights by their weights, missing ones as 0.
    sum: BilinearPatch,
    /// Sum of the weights.
    share: BilinearPatch,
    /// The least share that counts as ground.
    least_share: f64,
}

impl PartialPatch {
    /// `least_share` within 0..1.
    pub fn new(heights_m: [f64; 4], least_share: f64) -> Self {
        let known = |height: f64| if height.is_nan() { 0.0 } else { height };
        let weight = |height: f64| f64::from(!height.is_nan());
        Self {
            sum: BilinearPatch::new(heights_m.map(known)),
            share: BilinearPatch::new(heights_m.map(weight)),
            least_share,
        }
    }

    /// Height at a place, where there is ground.
    pub fn height_m(&self, place: DVec2) -> Option<f64> {
        let share = self.share.height_m(place);
        (share >= self.least_share).then(|| self.sum.height_m(place) / share)
    }

    /// Height gained over the patch's side going east and south.
    pub fn gradient(&self, place: DVec2) -> DVec2 {
        let (sum, share) = (self.sum.height_m(place), self.share.height_m(place));
        (self.sum.gradient(place) - self.share.gradient(place) * (sum / share)) / share
    }

    /// Where the ray goes below the surface; see [`BilinearPatch::crossing`].
    pub fn crossing(&self, ray: &PatchRay, before: Option<Side>) -> PatchCrossing {
        let share = quadratic_along(&self.share, ray);
        let above = self.above_surface(ray, share);
        let mut side = before;
        let ground = Ground { above, share, least_share: self.least_share };
        for [from, to] in pieces(above, share, self.least_share, ray.length_m) {
            if !ground.is_at(0.5 * (from + to)) {
                side = None;
                continue;
            }
            let [start, end] = [from, to].map(|s| value(above, s));
            if side == Some(Side::Above) && start < 0.0 {
                return PatchCrossing::Hit(from);
            }
            if start >= 0.0 && end < 0.0 {
                return PatchCrossing::Hit(ground.descent(from, to));
            }
            side = Some(Side::of(end));
        }
        PatchCrossing::Leaves(side)
    }

    /// The cubic z D - e N along the ray: of the sign of the ray's height above the surface.
    fn above_surface(&self, ray: &PatchRay, share: Cubic) -> Cubic {
        let sum = quadratic_along(&self.sum, ray);
        let z = [ray.z_m, ray.rise];
        std::array::from_fn(|power| {
            let raised =
                z[0] * share[power] + power.checked_sub(1).map_or(0.0, |p| z[1] * share[p]);
            raised - ray.exaggeration * sum[power]
        })
    }
}

/// Coefficients of the powers 0 to 3.
type Cubic = [f64; 4];

fn value(cubic: Cubic, s: f64) -> f64 {
    cubic.iter().rev().fold(0.0, |sum, &coefficient| sum * s + coefficient)
}

fn quadratic_along(patch: &BilinearPatch, ray: &PatchRay) -> Cubic {
    let bend = patch.twist() * ray.step.x * ray.step.y;
    [patch.height_m(ray.place), patch.gradient(ray.place).dot(ray.step), bend, 0.0]
}

/// Cuts the way into pieces in each of which the cubic only rises or only falls, and the share
/// stays on one side of the least one.
fn pieces(above: Cubic, share: Cubic, least_share: f64, length: f64) -> Vec<[f64; 2]> {
    let mut cuts = vec![0.0, length];
    cuts.extend(roots([above[1], 2.0 * above[2], 3.0 * above[3]]));
    cuts.extend(roots([share[0] - least_share, share[1], share[2]]));
    cuts.retain(|cut| (0.0..=length).contains(cut));
    cuts.sort_by(f64::total_cmp);
    cuts.windows(2).map(|pair| [pair[0], pair[1]]).collect()
}

/// Real roots of c + b s + a s^2, coefficients from the lowest power.
fn roots([c, b, a]: [f64; 3]) -> impl Iterator<Item = f64> {
    let discriminant = b * b - 4.0 * a * c;
    let q = -0.5 * (b + discriminant.max(0.0).sqrt().copysign(b));
    let found = if discriminant < 0.0 { [f64::NAN; 2] } else { [q / a, c / q] };
    found.into_iter().filter(|root| root.is_finite())
}

/// The cubic over the pieces of the way that are ground.
struct Ground {
    above: Cubic,
    share: Cubic,
    least_share: f64,
}

impl Ground {
    fn is_at(&self, s: f64) -> bool {
        value(self.share, s) >= self.least_share
    }

    /// Where a falling cubic passes zero, by bisection to the last bit but few.
    fn descent(&self, mut from: f64, mut to: f64) -> f64 {
        for _ in 0..80 {
            let middle = 0.5 * (from + to);
            if value(self.above, middle) >= 0.0 {
                from = middle;
            } else {
                to = middle;
            }
        }
        to
    }
}
