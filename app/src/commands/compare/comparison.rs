//! What strategies cost beside one another: with the settings they were given, and at one error.

use serde::Serialize;
use terrain_core::measure::equal_error::{CostAt, CostCurve, tightest_common_error};

use super::run_summary::{RunSummary, RunTime};

/// Whose bytes the others' are divided by, where it is among them.
const YARDSTICK: &str = "rtt-quadtree";

/// How many times the least error that all reach costs are compared at. Where a sweep's errors level out
/// the last hundredth of an error can double the bytes: no comparison should hang on that.
const EASE: f64 = 1.02;

/// What a picture's error is told by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ErrorColumn {
    /// The mean FLIP error.
    FlipMean,
    /// The screen-space error that 99 in a hundred pixels keep.
    ScreenErrorPxP99,
}

impl ErrorColumn {
    /// What `frames.csv` calls it.
    pub fn column(self) -> &'static str {
        match self {
            Self::FlipMean => "flip_mean",
            Self::ScreenErrorPxP99 => "screen_error_px_p99",
        }
    }

    /// What a plot's axis calls it.
    pub fn label(self) -> &'static str {
        match self {
            Self::FlipMean => "FLIP, mean",
            Self::ScreenErrorPxP99 => "screen-space error, 99 % (px)",
        }
    }

    /// The error with as many digits as tell it.
    pub fn shown(self, error: f64) -> String {
        match self {
            Self::FlipMean => format!("{error:.4}"),
            Self::ScreenErrorPxP99 => format!("{error:.2}"),
        }
    }
}

/// What every strategy costs on every flight, on one basis.
#[derive(Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// The error that is the same for all; `None` where each has that of its own settings.
    pub equal: Option<ErrorColumn>,
    /// The strategies, in the order of each flight's costs.
    pub strategies: Vec<String>,
    /// A row a flight.
    pub flights: Vec<FlightCosts>,
}

/// What the strategies cost on a flight.
#[derive(Debug, PartialEq, Serialize)]
pub struct FlightCosts {
    /// What the flight is called.
    pub flight: String,
    /// The error that is the same for all.
    pub error: Option<f64>,
    /// The strategies' costs.
    pub costs: Vec<Costs>,
}

/// What a strategy costs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Costs {
    /// KiB to the GPU a frame after the first.
    pub upload_kib: CostAt,
    /// KiB to the GPU a frame after the first, and back.
    pub both_ways_kib: CostAt,
    /// Milliseconds a frame: the time that is set against errors.
    pub run_time_ms: CostAt,
}

/// A cost among [`Costs`].
pub type Cost = fn(&Costs) -> CostAt;

impl Comparison {
    /// With the settings they were given: the runs that stand for their strategies.
    pub fn as_given(runs: &[RunSummary], settle: bool) -> Self {
        let time = RunTime::of(runs, settle);
        Self::over_flights(runs, None, |flight, strategies| {
            let typical = |strategy: &String| {
                let is_it = |run: &&&RunSummary| run.is_typical && run.strategy == *strategy;
                flight.iter().find(is_it).map_or(Costs::UNKNOWN, |run| Costs {
                    upload_kib: CostAt::Reached(run.later_upload_kib()),
                    both_ways_kib: CostAt::Reached(run.later_both_ways_kib()),
                    run_time_ms: CostAt::Reached(time.median_ms(run)),
                })
            };
            (None, strategies.iter().map(typical).collect())
        })
    }

    /// At one error a flight: the one given, or 2 % above the tightest that all strategies reach.
    pub fn at_equal(
        runs: &[RunSummary],
        settle: bool,
        error: ErrorColumn,
        given: Option<f64>,
    ) -> Self {
        let time = RunTime::of(runs, settle);
        Self::over_flights(runs, Some(error), |flight, strategies| {
            let curve = |strategy: &str, cost: &dyn Fn(&RunSummary) -> f64| {
                let runs = flight.iter().filter(|run| run.strategy == strategy);
                let points = runs.map(|run| [run.error(error.column()), cost(run)]);
                CostCurve::new(&points.collect::<Vec<_>>())
            };
            let by_upload = |strategy: &String| curve(strategy, &RunSummary::later_upload_kib);
            let curves = strategies.iter().filter_map(by_upload).collect::<Vec<_>>();
            let tightest = || tightest_common_error(&curves).map(|error| EASE * error);
            let Some(target) = given.or_else(tightest) else {
                return (None, vec![Costs::UNKNOWN; strategies.len()]);
            };
            let at = |curve: Option<CostCurve>| {
                curve.map_or(CostAt::NotReached, |curve| curve.at(target))
            };
            let costs = |strategy: &String| Costs {
                upload_kib: at(curve(strategy, &RunSummary::later_upload_kib)),
                both_ways_kib: at(curve(strategy, &RunSummary::later_both_ways_kib)),
                run_time_ms: at(curve(strategy, &|run| time.median_ms(run))),
            };
            (Some(target), strategies.iter().map(costs).collect())
        })
    }

    fn over_flights(
        runs: &[RunSummary],
        equal: Option<ErrorColumn>,
        costs: impl Fn(&[&RunSummary], &[String]) -> (Option<f64>, Vec<Costs>),
    ) -> Self {
        let strategies = distinct(runs.iter().map(|run| run.strategy.clone()));
        let flights = distinct(runs.iter().map(|run| run.flight.as_str()));
        let flights = flights.into_iter().map(|flight| {
            let of_flight = runs.iter().filter(|run| run.flight == flight).collect::<Vec<_>>();
            let (error, costs) = costs(&of_flight, &strategies);
            FlightCosts { flight: flight.to_owned(), error, costs }
        });
        Self { equal, flights: flights.collect(), strategies }
    }

    /// The flights on which every strategy's cost is known.
    pub fn common_flights(&self, cost: Cost) -> impl Iterator<Item = &FlightCosts> {
        let is_known = move |costs: &Costs| cost(costs).most().is_some();
        self.flights.iter().filter(move |flight| flight.costs.iter().all(is_known))
    }

    /// The mean of a strategy's cost over the flights on which every strategy's is known.
    pub fn mean(&self, strategy: usize, cost: Cost) -> CostAt {
        let (mut sum, mut count, mut is_bound) = (0.0, 0.0, false);
        for flight in self.common_flights(cost) {
            let cost = cost(&flight.costs[strategy]);
            sum += cost.most().unwrap_or(0.0);
            count += 1.0;
            is_bound |= matches!(cost, CostAt::AtMost(_));
        }
        match (count > 0.0, is_bound) {
            (false, _) => CostAt::NotReached,
            (true, false) => CostAt::Reached(sum / count),
            (true, true) => CostAt::AtMost(sum / count),
        }
    }

    /// How many times the yardstick's mean cost the strategy's is.
    pub fn ratio(&self, strategy: usize, cost: Cost) -> Option<f64> {
        let yardstick = self.strategies.iter().position(|name| *name == YARDSTICK).unwrap_or(0);
        let of = self.mean(yardstick, cost).most().filter(|cost| *cost > 0.0)?;
        Some(self.mean(strategy, cost).most()? / of)
    }
}

impl Costs {
    const UNKNOWN: Self = Self {
        upload_kib: CostAt::NotReached,
        both_ways_kib: CostAt::NotReached,
        run_time_ms: CostAt::NotReached,
    };
}

/// Each value once, in the order they first appear.
pub fn distinct<T: PartialEq>(values: impl Iterator<Item = T>) -> Vec<T> {
    let mut distinct = Vec::new();
    for value in values {
        if !distinct.contains(&value) {
            distinct.push(value);
        }
    }
    distinct
}

#[cfg(test)]
mod tests {
    use terrain_core::measure::FrameRecord;
    use terrain_core::selection::Strategy;

    use super::super::course::RunResult;
    use super::*;

    /// A run that sends so many KiB a frame at an error.
    fn run(flight: &str, strategy: Strategy, kib: u64, flip: f64) -> RunSummary {
        let mut record = FrameRecord { upload_bytes: 1024 * kib, ..Default::default() };
        record.readback_bytes = 2048;
        record.errors.flip_mean = Some(flip);
        let run = RunResult::of_records(&format!("{strategy} {flip}"), vec![record]);
        let is_typical = flip == 0.02;
        RunSummary::of(&RunResult {
            flight: flight.into(),
            strategy: strategy.to_string(),
            is_typical,
            ..run
        })
    }

    /// Over two flights, one with ten times the bytes, two strategies whose bytes go with the inverse of
    /// the error: the second sends three times the first's, and does not reach its least error.
    fn runs() -> Vec<RunSummary> {
        let flight = |name: &'static str, factor: u64| {
            let ours = [(1, 0.04), (2, 0.02), (4, 0.01)];
            let ours = ours.map(|point| (Strategy::RttQuadtree, point));
            let theirs = [(3, 0.04), (6, 0.02)].map(|point| (Strategy::CpuFrustum, point));
            let all = ours.into_iter().chain(theirs);
            all.map(move |(strategy, (kib, flip))| run(name, strategy, kib * factor, flip))
        };
        flight("low", 1).chain(flight("high", 10)).collect()
    }

    #[test]
    fn the_tightest_common_error_is_that_of_the_coarser_strategy() {
        let equal = Comparison::at_equal(&runs(), false, ErrorColumn::FlipMean, None);
        assert_eq!(equal.strategies, ["rtt-quadtree", "cpu-frustum"]);
        for (flight, factor) in equal.flights.iter().zip([1.0, 10.0]) {
            assert!((flight.error.unwrap() - 1.02 * 0.02).abs() < 1e-12);
            let kib = flight.costs.iter().map(|costs| costs.upload_kib.most().unwrap());
            let kib = kib.collect::<Vec<_>>();
            assert!((kib[0] / (2.0 / 1.02 * factor) - 1.0).abs() < 1e-9, "{kib:?}");
            assert!((kib[1] / (6.0 / 1.02 * factor) - 1.0).abs() < 1e-9, "{kib:?}");
        }
        let upload: Cost = |costs| costs.upload_kib;
        assert!((equal.mean(0, upload).most().unwrap() - 11.0 / 1.02).abs() < 1e-9);
        assert!((equal.ratio(1, upload).unwrap() - 3.0).abs() < 1e-9);
    }

    #[test]
    fn an_error_that_one_does_not_reach_has_no_mean() {
        let equal = Comparison::at_equal(&runs(), false, ErrorColumn::FlipMean, Some(0.01));
        let upload: Cost = |costs| costs.upload_kib;
        assert!(matches!(equal.flights[0].costs[0].upload_kib, CostAt::Reached(_)));
        assert_eq!(equal.flights[0].costs[1].upload_kib, CostAt::NotReached);
        assert_eq!((equal.mean(0, upload), equal.ratio(0, upload)), (CostAt::NotReached, None));
        let unmeasured = Comparison::at_equal(&runs(), false, ErrorColumn::ScreenErrorPxP99, None);
        assert_eq!(unmeasured.flights[0].costs, [Costs::UNKNOWN; 2]);
    }

    #[test]
    fn as_given_is_the_typical_run() {
        let given = Comparison::as_given(&runs(), false);
        let upload: Cost = |costs| costs.upload_kib;
        assert_eq!(given.mean(0, upload), CostAt::Reached(11.0));
        assert_eq!(given.ratio(1, upload), Some(3.0));
        assert_eq!(given.flights[1].costs[0].both_ways_kib, CostAt::Reached(22.0));
    }
}
