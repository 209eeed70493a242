//! One frame's cuts and joins.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::bisection::NONE;
use super::{Sight, ViewMesh};

/// How fine a mesh is to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RefineSettings {
    /// A triangle in the picture is cut while the ground may look farther from it than this many pixels.
    pub tolerance_px: f64,
    /// Most triangles; at least what the tiles in use need by themselves. Where the tolerance wants
    /// more, it is raised.
    pub most_triangles: usize,
}

/// What a refinement did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Refined {
    /// Pairs of triangles that were cut because they looked too coarse.
    pub cuts: usize,
    /// Pairs that were joined.
    pub joins: usize,
    /// Whether there is nothing more to do for this view.
    pub is_done: bool,
}

/// A triangle to cut: the one with the largest error first, then the one found first in the heap's order
/// of ids.
type Candidate = (u64, Reverse<u32>);

impl ViewMesh {
    /// A pair is joined when both errors are below this part of the tolerance. Between the two nothing
    /// is done, so that a trembling camera changes nothing.
    pub const JOIN_PART: f64 = 0.6;
    /// Step by which the tolerance is raised where the mesh would grow too large.
    const COARSENING_STEP: f64 = 1.19;

    /// Brings the mesh closer to what the view wants by at most `most_steps` cuts and joins.
    ///
    /// The largest error in pixels is cut first. For the same sight, settings and tiles in use, repeated
    /// calls come to an end at which nothing changes any more.
    pub fn refine(
        &mut self,
        sight: &Sight,
        settings: RefineSettings,
        most_steps: usize,
    ) -> Refined {
        let asked = Some((*sight, settings));
        let is_roomy = self.leaves.len() < settings.most_triangles / 2;
        if self.refined_for != asked && is_roomy {
            self.coarsening = (self.coarsening / Self::COARSENING_STEP).max(1.0);
        }
        self.refined_for = asked;
        let mut refined = Refined { is_done: true, ..Refined::default() };
        self.cut_where_coarse(sight, settings, most_steps, &mut refined);
        let steps_left = most_steps.saturating_sub(refined.cuts);
        self.join_where_fine(sight, settings, steps_left, &mut refined);
        refined
    }

    fn cut_where_coarse(
        &mut self,
        sight: &Sight,
        settings: RefineSettings,
        most: usize,
        refined: &mut Refined,
    ) {
        let tolerance_px = settings.tolerance_px * self.coarsening;
        self.fresh.clear();
        let leaves = self.leaves.ids().iter();
        let mut coarse: BinaryHeap<Candidate> =
            leaves.filter_map(|&id| self.candidate(id, sight, tolerance_px)).collect();
        while let Some((_, Reverse(id))) = coarse.pop() {
            if !self.bisection.is_leaf(id) {
                continue;
            }
            if refined.cuts >= most {
                refined.is_done = false;
                break;
            }
            if self.leaves.len() + 2 > settings.most_triangles {
                self.coarsening *= Self::COARSENING_STEP;
                refined.is_done = false;
                break;
            }
            self.cut(id);
            // Each pair cut leaves up to four.
            refined.cuts += self.fresh.len().div_ceil(4);
            for id in std::mem::take(&mut self.fresh) {
                coarse.extend(self.candidate(id, sight, tolerance_px));
            }
        }
    }

    fn candidate(&self, id: u32, sight: &Sight, tolerance_px: f64) -> Option<Candidate> {
        let bounds = &self.bounds[id as usize];
        (sight.exceeds(bounds, tolerance_px) && sight.sees(bounds))
            .then(|| (sight.error_px(bounds).to_bits(), Reverse(id)))
    }

    fn join_where_fine(
        &mut self,
        sight: &Sight,
        settings: RefineSettings,
        most: usize,
        refined: &mut Refined,
    ) {
        let tolerance_px = Self::JOIN_PART * settings.tolerance_px * self.coarsening;
        let is_crowded = self.leaves.len() > settings.most_triangles / 4 * 3;
        let is_needless = |mesh: &Self, name: u32| {
            let partner = mesh.bisection.get(name).base;
            [name, partner].into_iter().filter(|&id| id != NONE).all(|id| {
                let bounds = &mesh.bounds[id as usize];
                let is_hidden = is_crowded && bounds.error_m.is_finite() && !sight.sees(bounds);
                is_hidden || !sight.exceeds(bounds, tolerance_px)
            })
        };
        let joinable = self.joinable.ids().iter().copied();
        let mut needless: Vec<u32> = joinable.filter(|&name| is_needless(self, name)).collect();
        while let Some(name) = needless.pop() {
            if refined.joins >= most {
                refined.is_done = false;
                break;
            }
            let above = self.join(name).collect::<Vec<_>>();
            needless.extend(above.into_iter().filter(|&name| is_needless(self, name)));
            refined.joins += 1;
        }
    }
}
