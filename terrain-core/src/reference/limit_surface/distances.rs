use super::LimitSurfaceError;

/// The increasing set D of distances at which colours are integrated, metres; one for all triangles.
#[derive(Clone, Debug, PartialEq)]
pub struct DistanceSet {
    distances_m: Vec<f64>,
}

impl DistanceSet {
    /// Most distances a set may hold: a knot has seven bits for its number.
    pub const MOST: usize = 128;

    /// Of distances that are positive, finite and strictly increasing; 1 to [`Self::MOST`].
    ///
    /// # Errors
    /// [`LimitSurfaceError::Setting`] where they are not.
    pub fn new(distances_m: Vec<f64>) -> Result<Self, LimitSurfaceError> {
        let positive = distances_m.iter().all(|d| d.is_finite() && *d > 0.0);
        let increasing = distances_m.windows(2).all(|pair| pair[0] < pair[1]);
        if distances_m.is_empty() || distances_m.len() > Self::MOST || !positive || !increasing {
            let reason = format!(
                "the distances must be 1 to {}, positive and increasing; given {}",
                Self::MOST,
                distances_m.len()
            );
            return Err(LimitSurfaceError::Setting(reason));
        }
        Ok(Self { distances_m })
    }

    /// From `least_m` to at least `farthest_m`, each the same factor beyond the one before,
    /// `per_doubling` of them to a factor of two. A footprint grows with its distance, so equal
    /// factors are equal changes of the filter.
    ///
    /// # Errors
    /// [`LimitSurfaceError::Setting`] where that is no set.
    pub fn geometric(
        least_m: f64,
        farthest_m: f64,
        per_doubling: u32,
    ) -> Result<Self, LimitSurfaceError> {
        let doublings = (farthest_m / least_m).log2();
        if !doublings.is_finite() || doublings < 0.0 || per_doubling == 0 {
            let reason = format!("no distances from {least_m} to {farthest_m} m");
            return Err(LimitSurfaceError::Setting(reason));
        }
        // What rounding adds to the logarithm is no reason for one more distance.
        let steps = (doublings * f64::from(per_doubling) - 1.0e-9).ceil().max(0.0);
        if steps >= Self::MOST as f64 {
            let reason = format!("more than {} distances", Self::MOST);
            return Err(LimitSurfaceError::Setting(reason));
        }
        let at = |step: u32| least_m * (f64::from(step) / f64::from(per_doubling)).exp2();
        Self::new((0..=steps as u32).map(at).collect())
    }

    /// The distances, metres.
    pub fn as_slice(&self) -> &[f64] {
        &self.distances_m
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.distances_m.len()
    }

    /// The least distance, D_min.
    pub fn least_m(&self) -> f64 {
        self.distances_m.first().copied().unwrap_or(f64::NAN)
    }

    /// The farthest distance; colours stay as they are there beyond it.
    pub fn farthest_m(&self) -> f64 {
        self.distances_m.last().copied().unwrap_or(f64::NAN)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn geometric_distances_reach_from_end_to_end() {
        let set = DistanceSet::geometric(100.0, 800.0, 2).unwrap();
        assert_eq!(set.count(), 7);
        assert_eq!((set.least_m(), set.as_slice()[2]), (100.0, 200.0));
        assert!((set.farthest_m() - 800.0).abs() < 1e-9);
        let beyond = DistanceSet::geometric(100.0, 801.0, 1).unwrap();
        assert_eq!(beyond.farthest_m(), 1600.0);
        assert_eq!(DistanceSet::geometric(5.0, 5.0, 4).unwrap().count(), 1);
    }

    #[test]
    fn what_is_no_set_is_refused() {
        for wrong in [vec![], vec![1.0, 1.0], vec![2.0, 1.0], vec![-1.0], vec![f64::NAN]] {
            assert!(DistanceSet::new(wrong).is_err());
        }
        assert!(DistanceSet::new((1..=129).map(f64::from).collect()).is_err());
        assert!(DistanceSet::geometric(0.0, 1.0, 1).is_err());
        assert!(DistanceSet::geometric(2.0, 1.0, 1).is_err());
        assert!(DistanceSet::geometric(1.0, 1.0e30, 4).is_err());
    }
}
