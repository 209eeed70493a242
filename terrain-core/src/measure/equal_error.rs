//! What strategies cost at one and the same error.
//!
//! Strategies that are turned to the same setting differ in cost *and* in error, and so cannot be
//! compared by either alone. Each is therefore swept through its own settings, and its cost taken where
//! its error is that of all others.

use serde::Serialize;

use super::monotone_curve::MonotoneCurve;
use super::sweep::pareto_front;

/// What a sweep costs at an error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CostAt {
    /// It reaches the error between two of its settings, at this cost.
    Reached(f64),
    /// Its cheapest setting, of this cost, is more exact already. Coarser settings, which were not
    /// tried, might cost less.
    AtMost(f64),
    /// None of its settings is as exact.
    NotReached,
}

impl CostAt {
    /// The cost, or the most it can be; `None` where it is not known.
    pub fn most(self) -> Option<f64> {
        match self {
            Self::Reached(cost) | Self::AtMost(cost) => Some(cost),
            Self::NotReached => None,
        }
    }
}

/// A cost over the errors of a sweep: the least cost of an error no larger.
///
/// A setting that another beats in both says nothing about what the strategy has to cost and is passed
/// over. Between the others the curve is a monotone cubic (M. Steffen, "A simple method for monotonic
/// interpolation in one dimension", 1990), logarithm over logarithm, since both run over decades; where
/// a cost is 0, cost itself over the logarithm of the error.
#[derive(Clone, Debug)]
pub struct CostCurve {
    /// Logarithms of the errors, rising.
    errors: Vec<f64>,
    costs: MonotoneCurve,
    /// Cost of the least and of the greatest error.
    ends: [f64; 2],
    is_log: bool,
}

impl CostCurve {
    /// The curve of measured points (error, cost). Points with an error that is not positive or a cost
    /// that is negative, and those that are not finite, are left out; `None` where none is left.
    pub fn new(points: &[[f64; 2]]) -> Option<Self> {
        let is_known =
            |p: &&[f64; 2]| p[0] > 0.0 && p[1] >= 0.0 && p[0].is_finite() && p[1].is_finite();
        let swapped = points.iter().filter(is_known).map(|p| [p[1], p[0]]).collect::<Vec<_>>();
        // By increasing cost, and so by decreasing error.
        let front = pareto_front(&swapped).into_iter().rev().map(|index| swapped[index]);
        let front = front.collect::<Vec<_>>();
        let (first, last) = (front.first()?, front.last()?);
        let is_log = front.iter().all(|point| point[0] > 0.0);
        let errors = front.iter().map(|point| point[1].ln()).collect::<Vec<_>>();
        let costs = front.iter().map(|p| if is_log { p[0].ln() } else { p[0] }).collect();
        let ends = [first[0], last[0]];
        Some(Self { costs: MonotoneCurve::new(&errors, costs), errors, ends, is_log })
    }

    /// The least error of the sweep.
    pub fn least_error(&self) -> f64 {
        self.errors[0].exp()
    }

    /// What the sweep costs at this error. Nothing is extrapolated.
    pub fn at(&self, error: f64) -> CostAt {
        let last = self.errors.len() - 1;
        // An end is met whatever its logarithm was rounded to.
        let slack = 1.0e-12;
        let place = error.ln();
        if !(error > 0.0 && place >= self.errors[0] - slack) {
            return CostAt::NotReached;
        }
        if place > self.errors[last] + slack {
            return CostAt::AtMost(self.ends[1]);
        }
        if place <= self.errors[0] + slack {
            return CostAt::Reached(self.ends[0]);
        }
        let after = self.errors.partition_point(|error| *error <= place).clamp(1, last);
        let [from, to] = [self.errors[after - 1], self.errors[after]];
        let cost = self.costs.value(after - 1, (place - from) / (to - from), to - from);
        CostAt::Reached(if self.is_log { cost.exp() } else { cost })
    }
}

/// The least error that all of these sweeps reach; `None` of none.
pub fn tightest_common_error<'a>(curves: impl IntoIterator<Item = &'a CostCurve>) -> Option<f64> {
    curves.into_iter().map(CostCurve::least_error).reduce(f64::max)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn reached(curve: &CostCurve, error: f64) -> f64 {
        match curve.at(error) {
            CostAt::Reached(cost) => cost,
            other => panic!("{other:?} at {error}"),
        }
    }

    /// A sweep whose cost is `factor` / error^`power`, at errors a factor of root two apart.
    fn power_law(factor: f64, power: f64, errors: std::ops::Range<i32>) -> Vec<[f64; 2]> {
        errors
            .map(|step| 2.0_f64.powf(f64::from(step) / 2.0) * 0.01)
            .map(|error| [error, factor * error.powf(-power)])
            .collect()
    }

    #[test]
    fn power_laws_are_found_exactly_and_their_ratio_with_them() {
        // The same law but for a factor, swept over ranges that overlap in part.
        let ours = CostCurve::new(&power_law(3.0, 1.4, -4..3)).unwrap();
        let theirs = CostCurve::new(&power_law(7.89, 1.4, -1..6)).unwrap();
        let error = tightest_common_error([&ours, &theirs]).unwrap();
        assert!((error - 0.01 / 2.0_f64.sqrt()).abs() < 1e-12, "the least of theirs");
        for error in [error, 0.009, 0.0135, 0.0199] {
            let [ours, theirs] = [reached(&ours, error), reached(&theirs, error)];
            assert!((ours / (3.0 * error.powf(-1.4)) - 1.0).abs() < 1e-9, "{ours} at {error}");
            assert!((theirs / ours - 2.63).abs() < 1e-9);
        }
    }

    #[test]
    fn beyond_the_sweep_nothing_is_made_up() {
        let curve = CostCurve::new(&[[0.02, 100.0], [0.01, 300.0], [0.04, 50.0]]).unwrap();
        assert_eq!(curve.at(0.0099), CostAt::NotReached);
        assert_eq!(curve.at(0.041), CostAt::AtMost(50.0));
        for (error, cost) in [(0.01, 300.0), (0.02, 100.0), (0.04, 50.0)] {
            assert!((reached(&curve, error) / cost - 1.0).abs() < 1e-12);
        }
        for error in [0.0, -1.0, f64::NAN] {
            assert_eq!(curve.at(error), CostAt::NotReached, "{error}");
        }
        assert_eq!(curve.at(f64::INFINITY), CostAt::AtMost(50.0));
    }

    #[test]
    fn settings_that_others_beat_do_not_count() {
        let plain = [[0.01, 300.0], [0.02, 100.0], [0.04, 50.0]];
        let with_bad = [&plain[..], &[[0.03, 400.0], [0.02, 101.0], [f64::NAN, 1.0]]].concat();
        let [plain, with_bad] = [&plain[..], &with_bad].map(|p| CostCurve::new(p).unwrap());
        for step in 0..=30 {
            let error = 0.01 + 0.001 * f64::from(step);
            assert_eq!(plain.at(error), with_bad.at(error), "{error}");
        }
    }

    #[test]
    fn a_cost_of_nothing_is_a_cost() {
        let curve = CostCurve::new(&[[0.01, 10.0], [0.1, 0.0]]).unwrap();
        assert!((reached(&curve, 0.001_f64.sqrt()) - 5.0).abs() < 1e-9);
        assert_eq!(curve.at(0.2), CostAt::AtMost(0.0));
        let same = CostCurve::new(&[[0.01, 7.0], [0.02, 7.0]]).unwrap();
        assert_eq!(same.at(0.015), CostAt::AtMost(7.0), "the finer setting costs no more");
        assert!(CostCurve::new(&[[0.0, 1.0], [f64::NAN, 1.0], [1.0, -1.0]]).is_none());
        assert!(tightest_common_error([]).is_none());
    }

    proptest! {
        #[test]
        fn costs_fall_as_errors_grow_and_stay_between_their_neighbours(
            points in prop::collection::vec([1.0e-4..1.0f64, 0.0..1.0e4f64], 1..12),
        ) {
            let curve = CostCurve::new(&points).unwrap();
            let mut before = f64::INFINITY;
            for step in 0..200 {
                let error = curve.least_error() * 1.05_f64.powi(step);
                let Some(cost) = curve.at(error).most() else { panic!("within the sweep") };
                prop_assert!(cost <= before * (1.0 + 1.0e-9), "{} after {}", cost, before);
                // No cheaper than the cheapest point that is at least as exact would allow.
                let known = points.iter().filter(|p| p[0] <= error * (1.0 - 1.0e-9)).map(|p| p[1]);
                prop_assert!(cost <= known.fold(f64::INFINITY, f64::min) * (1.0 + 1.0e-9));
                before = cost;
            }
        }
    }
}
