use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::colour_codes::srgb_from_linear;
use super::grid::middle_and_normal;
use super::{
    DistanceSet, Footprint, FootprintIntegral, Knot, KnotBudget, KnotSearch, LimitRelief,
    LimitSurface, LimitSurfaceError, TriangleColours,
};

/// How many knots triangles keep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum KnotRule {
    /// Each the fewest with which no colour departs further than this, in steps of 1/255 of sRGB.
    ColourError(f32),
    /// As many as fit into so many bytes, the largest error of any triangle being the least possible.
    Memory(u64),
}

/// Integrates and reduces the colours of triangles.
pub struct ColourBuild<'a> {
    /// The triangles.
    pub relief: &'a LimitRelief,
    /// The distances.
    pub distances: &'a DistanceSet,
    /// Apex angle of the cone, radians.
    pub admissible_angle_rad: f64,
    /// What gives a footprint its colour.
    pub integral: &'a dyn FootprintIntegral,
    /// Set by the caller to stop.
    pub cancel: &'a AtomicBool,
}

impl ColourBuild<'_> {
    /// The colours of all triangles.
    ///
    /// # Errors
    /// [`LimitSurfaceError::Setting`] where the memory does not hold a colour a triangle;
    /// [`LimitSurfaceError::Cancelled`].
    pub fn surface(&self, rule: KnotRule) -> Result<LimitSurface, LimitSurfaceError> {
        let rows = 0..self.relief.grid().rows;
        let limit_steps = match rule {
            KnotRule::ColourError(limit_steps) => limit_steps,
            KnotRule::Memory(most_bytes) => limit_for(&self.budget(rows.clone())?, most_bytes)?,
        };
        let colours = self.colours(rows, limit_steps)?;
        LimitSurface::new(self.relief.clone(), colours, self.admissible_angle_rad)
    }

    /// The colours of some rows of cells, reduced under an error limit in steps.
    ///
    /// # Errors
    /// [`LimitSurfaceError::Cancelled`].
    pub fn colours(
        &self,
        rows: Range<u32>,
        limit_steps: f32,
    ) -> Result<TriangleColours, LimitSurfaceError> {
        let parts = self.over_rows(rows, |triangles| {
            let mut part = TriangleColours::new(self.distances.clone());
            for samples in triangles {
                part.push(&self.reduced(samples.as_deref(), limit_steps));
            }
            part
        })?;
        let mut colours = TriangleColours::new(self.distances.clone());
        parts.iter().for_each(|part| colours.append(part));
        Ok(colours)
    }

    /// What all limits would cost over some rows of cells.
    ///
    /// # Errors
    /// [`LimitSurfaceError::Cancelled`].
    pub fn budget(&self, rows: Range<u32>) -> Result<KnotBudget, LimitSurfaceError> {
        let parts = self.over_rows(rows, |triangles| {
            let mut part = KnotBudget::default();
            for samples in triangles {
                match samples {
                    Some(samples) => part.count(&self.search(&samples).least_errors()),
                    None => part.count(&[]),
                }
            }
            part
        })?;
        let mut budget = KnotBudget::default();
        parts.iter().for_each(|part| budget.add(part));
        Ok(budget)
    }

    /// Does something with the samples of each row's triangles, rows in parallel; answers in their
    /// order.
    fn over_rows<T: Send>(
        &self,
        rows: Range<u32>,
        each: impl Fn(&mut dyn Iterator<Item = Option<Vec<[u8; 3]>>>) -> T + Sync,
    ) -> Result<Vec<T>, LimitSurfaceError> {
        let row_triangles = 2 * self.relief.grid().columns as usize;
        let of_row = |row: u32| {
            if self.cancel.load(Ordering::Relaxed) {
                return Err(LimitSurfaceError::Cancelled);
            }
            let first = row as usize * row_triangles;
            let mut triangles =
                (first..first + row_triangles).map(|triangle| self.samples(triangle));
            Ok(each(&mut triangles))
        };
        rows.into_par_iter().map(of_row).collect()
    }

    /// A triangle's colour at every distance; `None` where it holds no data.
    pub fn samples(&self, triangle: usize) -> Option<Vec<[u8; 3]>> {
        let (centre, normal) = middle_and_normal(self.relief.corners(triangle)?);
        let apex_angle_rad = self.admissible_angle_rad;
        let sample = |&distance_m: &f64| {
            let footprint = Footprint { centre, normal, distance_m, apex_angle_rad };
            srgb_from_linear(self.integral.mean_colour(&footprint))
        };
        Some(self.distances.as_slice().iter().map(sample).collect())
    }

    fn search(&self, samples: &[[u8; 3]]) -> KnotSearch {
        KnotSearch::new(self.distances.as_slice(), samples)
    }

    fn reduced(&self, samples: Option<&[[u8; 3]]>, limit_steps: f32) -> Vec<Knot> {
        let Some(samples) = samples else { return Vec::new() };
        let knot = |distance: u8| Knot { distance, srgb: samples[usize::from(distance)] };
        if samples.iter().all(|sample| sample == &samples[0]) {
            return vec![knot(0)];
        }
        self.search(samples).fewest(limit_steps).into_iter().map(knot).collect()
    }
}

/// The error limit under which everything counted fits into memory.
///
/// # Errors
/// [`LimitSurfaceError::Setting`] where one colour a triangle does not fit.
pub fn limit_for(budget: &KnotBudget, most_bytes: u64) -> Result<f32, LimitSurfaceError> {
    let found = budget.least_limit_steps(most_bytes).map(|(limit_steps, _)| limit_steps);
    found.ok_or_else(|| {
        let least = budget.least_bytes();
        LimitSurfaceError::Setting(format!(
            "{most_bytes} bytes do not hold one colour a triangle; that takes {least}"
        ))
    })
}
