//! How many rings the circular mesh has, where they lie and how finely each is divided.

use std::f64::consts::TAU;

use glam::{DVec2, dvec2};

/// The rings of a circular mesh, in units of the mesh's scale.
///
/// Ring `k` lies at `sinh(k * alpha)`, the solution of `d rho / dk = alpha * sqrt(rho^2 + 1)`: the
/// spacing is `alpha` times the distance from an eye at height 1 over the centre, wherever on the
/// ground. Ring 0 is the centre point.
pub(super) struct RingLayout {
    /// Radius of each ring, and of one more beyond the last.
    radii: Vec<f64>,
    /// Every ring has `base << shift` segments with its own shift.
    base: u32,
    /// Shift of each ring, never falling outwards; entry 0 (the centre point) is unused.
    shifts: Vec<u32>,
    /// Unit directions of the outermost ring's vertices, counter-clockwise from east. Every ring
    /// uses each one, each second one and so on.
    directions: Vec<DVec2>,
}

impl RingLayout {
    /// Rings out to the first one at or beyond `rho_max`.
    ///
    /// The count of segments follows `2 pi rho / spacing`, rounded to `base * 2^j`, so that arcs are
    /// within a factor sqrt(2) of the spacing between rings, and neighbouring rings have equal
    /// counts or the outer one twice the inner's.
    pub fn new(spacing_ratio: f64, rho_max: f64) -> Self {
        let ring_count = (rho_max.asinh() / spacing_ratio).ceil().max(1.0) as usize;
        let base = base_segments(spacing_ratio);
        let mut shifts = vec![0];
        for ring in 1..=ring_count {
            let target = TAU * (ring as f64 * spacing_ratio).tanh() / spacing_ratio;
            let nearest = (target / f64::from(base)).log2().round().max(0.0) as u32;
            let inner = shifts[ring - 1];
            let shift = if ring == 1 { nearest } else { nearest.clamp(inner, inner + 1) };
            shifts.push(shift);
        }
        let radii = (0..=ring_count + 1).map(|ring| (ring as f64 * spacing_ratio).sinh()).collect();
        let segments = base << shifts[ring_count];
        let angle = |segment: u32| TAU * f64::from(segment) / f64::from(segments);
        let directions = (0..segments).map(|i| dvec2(angle(i).cos(), angle(i).sin())).collect();
        Self { radii, base, shifts, directions }
    }

    /// Index of the outermost ring.
    pub fn last_ring(&self) -> usize {
        self.shifts.len() - 1
    }

    /// Radius of the ring.
    pub fn radius(&self, ring: usize) -> f64 {
        self.radii[ring]
    }

    /// Segments of the ring (at least 3 for every ring but the centre).
    pub fn segments(&self, ring: usize) -> u32 {
        self.base << self.shifts[ring]
    }

    /// Distance to the farthest neighbour on the ring or on the next one out: what heights must be
    /// band-limited to.
    pub fn vertex_spacing(&self, ring: usize) -> f64 {
        let radial = self.radii[ring + 1] - self.radii[ring];
        if ring == 0 {
            return radial;
        }
        radial.max(TAU * self.radius(ring) / f64::from(self.segments(ring)))
    }

    /// East and north of a vertex; `segment` counts counter-clockwise from east and wraps round.
    /// The same arguments give the same bits, which is what makes duplicated vertices meet.
    pub fn position(&self, ring: usize, segment: u32) -> [f32; 2] {
        let stride = self.shifts[self.last_ring()] - self.shifts[ring];
        let index = (segment % self.segments(ring)) << stride;
        (self.radii[ring] * self.directions[index as usize]).as_vec2().to_array()
    }

    /// Into how many sectors the band of rings `first..=last` is cut so that a sector is at most
    /// `target_segments` (a power of two) wide: a count that divides every ring of the band.
    pub fn sectors(&self, first: usize, last: usize, target_segments: u32) -> u32 {
        let outer = self.shifts[last].saturating_sub(target_segments.ilog2());
        self.base << outer.min(self.shifts[first])
    }
}

/// The factor common to all segment counts: in 4..=8, so that `base << j` for some `j` comes
/// within an eighth of the count far out, `2 pi / alpha`.
fn base_segments(spacing_ratio: f64) -> u32 {
    let far_out = TAU / spacing_ratio;
    let shift = (far_out / 4.0).log2().floor().max(0.0);
    ((far_out / shift.exp2()).round() as u32).max(4)
}
