use super::triangle_colours::TriangleColours;

/// Finds the least error limit under which all triangles together fit into memory.
///
/// Every triangle tells its least errors for 1, 2, .. knots. Under a limit it keeps one knot more than
/// there are numbers of knots whose error exceeds the limit. Histograms of these errors, over all
/// triangles, thus tell the memory of any limit without keeping any triangle: the limit found is the
/// least possible largest error of a triangle, to within a bin of 1/16 step.
#[derive(Clone, Debug, PartialEq)]
pub struct KnotBudget {
    triangles: u64,
    /// Errors with one knot, by bin: exceeding the limit costs a run of two.
    with_one: Vec<u64>,
    /// Errors with more knots: exceeding the limit costs one more.
    with_more: Vec<u64>,
}

impl Default for KnotBudget {
    fn default() -> Self {
        let bins = vec![0; Self::BINS];
        Self { triangles: 0, with_one: bins.clone(), with_more: bins }
    }
}

impl KnotBudget {
    const BINS_PER_STEP: f32 = 16.0;
    const BINS: usize = 255 * 16 + 1;

    /// Counts a triangle by its least errors ([`super::KnotSearch::least_errors`]); none for a
    /// triangle that is absent.
    pub fn count(&mut self, least_errors: &[f32]) {
        self.triangles += 1;
        for (index, &error) in least_errors.iter().enumerate() {
            let bin = ((error * Self::BINS_PER_STEP).ceil() as usize).min(Self::BINS - 1);
            let bins = if index == 0 { &mut self.with_one } else { &mut self.with_more };
            bins[bin] += 1;
        }
    }

    /// Adds what another has counted.
    pub fn add(&mut self, other: &Self) {
        self.triangles += other.triangles;
        let own = self.with_one.iter_mut().chain(&mut self.with_more);
        for (own, others) in own.zip(other.with_one.iter().chain(&other.with_more)) {
            *own += others;
        }
    }

    /// Bytes of all triangles' colours with one knot each: the least there can be.
    pub fn least_bytes(&self) -> u64 {
        TriangleColours::WORD_BYTES * self.triangles
    }

    /// The least error limit, in steps, under which the colours of all triangles take at most
    /// `most_bytes`, and the bytes they take then. `None` below [`Self::least_bytes`].
    pub fn least_limit_steps(&self, most_bytes: u64) -> Option<(f32, u64)> {
        let mut bytes = self.least_bytes();
        let mut found = None;
        // From the loosest limit to the tightest: each bin lets go of the errors just above it.
        for bin in (0..Self::BINS).rev() {
            if bytes > most_bytes {
                break;
            }
            found = Some((bin as f32 / Self::BINS_PER_STEP, bytes));
            let knots = 2 * self.with_one[bin] + self.with_more[bin];
            bytes += TriangleColours::WORD_BYTES * knots;
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::KnotSearch;
    use super::*;

    fn bytes_under(triangles: &[Vec<[u8; 3]>], distances_m: &[f64], limit: f32) -> u64 {
        let knots = |samples: &Vec<[u8; 3]>| KnotSearch::new(distances_m, samples).fewest(limit);
        let bytes = |count: usize| if count == 1 { 4 } else { 4 + 4 * count as u64 };
        triangles.iter().map(|samples| bytes(knots(samples).len())).sum()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        #[test]
        fn the_limit_found_fits_and_a_tighter_one_does_not(
            triangles in proptest::collection::vec(
                proptest::collection::vec(any::<[u8; 3]>(), 6), 1..12),
            spare in 0.0..1.0_f64,
        ) {
            let distances_m = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0];
            let mut budget = KnotBudget::default();
            for samples in &triangles {
                budget.count(&KnotSearch::new(&distances_m, samples).least_errors());
            }
            let least = budget.least_bytes();
            prop_assert_eq!(least, 4 * triangles.len() as u64);
            let most = least + (spare * 24.0 * triangles.len() as f64) as u64;
            let (limit, bytes) = budget.least_limit_steps(most).unwrap();
            prop_assert!(bytes <= most);
            // Rounding to bins may only make the count too high.
            prop_assert!(bytes_under(&triangles, &distances_m, limit) <= bytes);
            let tighter = limit - 1.0 / 8.0;
            if tighter >= 0.0 {
                prop_assert!(bytes_under(&triangles, &distances_m, tighter) > most);
            }
            prop_assert_eq!(budget.least_limit_steps(least - 1), None);
        }
    }
}
