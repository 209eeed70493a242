//! How far apart two surfaces must be for the depth test to tell them apart, against distance.
//!
//! Depth runs in reverse from 1 at the near plane to 0 at infinity: `z = n / d`. A float's steps shrink
//! with its value, so the step in distance is a constant part of the distance, at most `2^-23`, whatever
//! the near plane (Nathan Reed, "Depth Precision Visualized", 2015). The usual depth, near 1 for all that
//! is far away, has steps that grow with the square of the distance over the near plane's.

use glam::Mat4;
use serde::Serialize;

use crate::CameraView;
use crate::frame_setup::NEAR_PLANE_M;

/// Far plane of the usual projections, metres: the reach of the renderer's own on the Earth.
pub const FAR_PLANE_M: f64 = 5.0e7;

/// A way to turn distance into depth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum DepthKind {
    /// The renderer's: reverse, float32, no far plane.
    ReverseFloat,
    /// 0 near to 1 far, float32.
    UsualFloat,
    /// 0 near to 1 far, 24-bit integers.
    Usual24Bit,
}

impl DepthKind {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::ReverseFloat, Self::UsualFloat, Self::Usual24Bit];

    /// Its name in tables and plots.
    pub fn name(self) -> &'static str {
        match self {
            Self::ReverseFloat => "reverse, float32, infinite far plane",
            Self::UsualFloat => "usual, float32",
            Self::Usual24Bit => "usual, 24 bits",
        }
    }

    /// Whether nearer surfaces have the larger depth.
    pub fn is_reverse(self) -> bool {
        self == Self::ReverseFloat
    }

    /// Clip-space z as `scale * distance + offset`; w is the distance.
    fn scale_and_offset(self) -> [f64; 2] {
        if self.is_reverse() {
            return [0.0, NEAR_PLANE_M];
        }
        let scale = FAR_PLANE_M / (FAR_PLANE_M - NEAR_PLANE_M);
        [scale, -scale * NEAR_PLANE_M]
    }

    /// The projection as the shaders are given it.
    pub fn clip_from_relative(self, view: &CameraView) -> Mat4 {
        let shipped = view.clip_from_relative(NEAR_PLANE_M);
        if self.is_reverse() {
            return shipped;
        }
        let [scale, offset] = self.scale_and_offset().map(|value| value as f32);
        let mut rows = shipped.transpose();
        rows.z_axis = rows.w_axis * scale;
        rows.z_axis.w += offset;
        rows.transpose()
    }

    /// Step in metres between neighbouring depths at a distance: the gap below which two surfaces may
    /// share a depth.
    pub fn step_m(self, distance_m: f64) -> f64 {
        let [scale, offset] = self.scale_and_offset();
        let depth = scale + offset / distance_m;
        // Depth changes by |offset| / d^2 a metre.
        self.depth_step(depth) * distance_m * distance_m / offset.abs()
    }

    fn depth_step(self, depth: f64) -> f64 {
        match self {
            Self::Usual24Bit => (-24.0_f64).exp2(),
            // A value below a power of two has that power's step.
            _ => (depth.log2().ceil() - 24.0).exp2(),
        }
    }

    /// The stored depth of a point as the CPU computes it in f32.
    fn depth(self, distance_m: f32) -> f32 {
        let [scale, offset] = self.scale_and_offset().map(|value| value as f32);
        let depth = (scale * distance_m + offset) / distance_m;
        match self {
            Self::Usual24Bit => (f64::from(depth) * 16_777_215.0).round() as f32,
            _ => depth,
        }
    }
}

/// Neighbouring distances that stand for one: what the rounding of one of them hides by luck, another
/// shows.
const NEIGHBOURS: usize = 8;

/// Pairs of surfaces: every distance with every gap behind it.
#[derive(Clone, Debug, PartialEq)]
pub struct DepthGrid {
    /// Distance of the nearer surface, metres, eight neighbours after another.
    pub distances_m: Vec<f32>,
    /// Gaps to the farther one, as parts of the distance, ascending.
    pub gaps: Vec<f64>,
}

impl DepthGrid {
    /// Distances from just beyond the near plane to once round the Earth; gaps by powers of two.
    pub fn studied() -> Self {
        let distances_m = (-5..=61).flat_map(|eighth| {
            let distance_m = 10.0_f64.powf(f64::from(eighth) / 8.0);
            (0..NEIGHBOURS).map(move |n| (distance_m * (1.0 + 0.0173 * n as f64)) as f32)
        });
        Self {
            distances_m: distances_m.collect(),
            gaps: (-26..10).map(|exponent| f64::from(exponent).exp2()).collect(),
        }
    }

    /// Distance of the farther surface of a cell.
    pub fn farther_m(&self, column: usize, row: usize) -> f32 {
        (f64::from(self.distances_m[column]) * (1.0 + self.gaps[row])) as f32
    }

    /// Whether the CPU's depths keep the surfaces of each cell apart, row by row.
    pub fn told_apart_on_cpu(&self, kind: DepthKind) -> Vec<bool> {
        let rows = 0..self.gaps.len();
        let cells = rows.flat_map(|row| (0..self.distances_m.len()).map(move |c| (c, row)));
        let told_apart = cells.map(|(column, row)| {
            let near = kind.depth(self.distances_m[column]);
            let far = kind.depth(self.farther_m(column, row));
            if kind.is_reverse() { near > far } else { near < far }
        });
        told_apart.collect()
    }

    /// The studied distances, metres.
    pub fn places_m(&self) -> impl Iterator<Item = f64> {
        self.distances_m.iter().step_by(NEIGHBOURS).copied().map(f64::from)
    }

    /// For each studied distance the smallest gap in metres from which on all are told apart, at the
    /// distance and at its neighbours.
    pub fn least_gaps_m(&self, told_apart: &[bool]) -> Vec<f64> {
        let columns = self.distances_m.len();
        let least = |column: usize| {
            let fails = |row: &usize| !told_apart[row * columns + column];
            (0..self.gaps.len()).rev().find(fails).map_or(0, |row| row + 1)
        };
        let rows = (0..columns).map(least).collect::<Vec<_>>();
        let worst = rows.chunks(NEIGHBOURS).map(|rows| rows.iter().copied().max().unwrap_or(0));
        let gap = |row: usize| self.gaps.get(row).copied().unwrap_or(f64::INFINITY);
        worst.zip(self.places_m()).map(|(row, distance_m)| gap(row) * distance_m).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reverse_depth_tells_a_part_in_four_million_apart_at_any_distance() {
        let grid = DepthGrid::studied();
        let gaps = grid.least_gaps_m(&grid.told_apart_on_cpu(DepthKind::ReverseFloat));
        for (distance_m, gap_m) in grid.places_m().zip(gaps) {
            assert!(gap_m <= distance_m * (-22.0_f64).exp2(), "{distance_m}: {gap_m}");
        }
    }

    /// Two roundings, of the distance and of the depth, against one step: two steps at the most, three
    /// where the grid's powers of two fall short.
    #[test]
    fn the_gaps_found_are_the_steps_derived() {
        let grid = DepthGrid::studied();
        for kind in DepthKind::ALL {
            let gaps = grid.least_gaps_m(&grid.told_apart_on_cpu(kind));
            for (distance_m, gap_m) in grid.places_m().zip(gaps) {
                // A gap as large as the distance leaves what the step is at the distance itself.
                if gap_m > 0.25 * distance_m {
                    continue;
                }
                let step_m = kind.step_m(distance_m) + distance_m * (-24.0_f64).exp2();
                let ratio = gap_m / step_m;
                assert!((0.2..4.0).contains(&ratio), "{kind:?} {distance_m}: {gap_m} {step_m}");
            }
        }
    }

    #[test]
    fn the_usual_depth_loses_everything_beyond_a_thousand_kilometres() {
        for kind in [DepthKind::UsualFloat, DepthKind::Usual24Bit] {
            assert!(kind.step_m(2.0e6) > 1.0e6);
            assert!(DepthKind::ReverseFloat.step_m(2.0e6) < 0.25);
        }
    }
}
