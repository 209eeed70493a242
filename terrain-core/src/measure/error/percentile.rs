use serde::{Deserialize, Serialize};

/// The smallest of the values that `percent` of them do not exceed (nearest rank); `None` of none.
/// Values that are not numbers are passed over. `percent` is within 0..=100.
pub fn percentile(values: impl IntoIterator<Item = f64>, percent: f64) -> Option<f64> {
    Sorted::of(values).at(percent)
}

/// How values spread.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// Their mean.
    pub mean: f64,
    /// Half of them are not above this.
    pub p50: f64,
    /// 99 in a hundred are not above this.
    pub p99: f64,
    /// The greatest.
    pub max: f64,
}

impl Spread {
    /// The spread of the values, `None` of none. Values that are not numbers are passed over.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let sorted = Sorted::of(values);
        let mean = sorted.0.iter().sum::<f64>() / sorted.0.len() as f64;
        Some(Self { mean, p50: sorted.at(50.0)?, p99: sorted.at(99.0)?, max: *sorted.0.last()? })
    }
}

/// Numbers in ascending order.
struct Sorted(Vec<f64>);

impl Sorted {
    fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let mut numbers = values.into_iter().filter(|value| !value.is_nan()).collect::<Vec<_>>();
        numbers.sort_unstable_by(f64::total_cmp);
        Self(numbers)
    }

    fn at(&self, percent: f64) -> Option<f64> {
        let rank = (percent / 100.0 * self.0.len() as f64).ceil() as usize;
        self.0.get(rank.saturating_sub(1)).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_are_counted_from_the_smallest() {
        let values = [15.0, 20.0, f64::NAN, 35.0, 40.0, 50.0];
        for (percent, expected) in [(5.0, 15.0), (30.0, 20.0), (40.0, 20.0), (50.0, 35.0)] {
            assert_eq!(percentile(values, percent), Some(expected), "{percent}");
        }
        assert_eq!(percentile(values, 100.0), Some(50.0));
        assert_eq!(percentile(values, 0.0), Some(15.0));
        assert_eq!(percentile([], 50.0), None);
    }

    #[test]
    fn a_spread_is_of_the_numbers_alone() {
        let spread = Spread::of([3.0, f64::NAN, 1.0, 2.0, 10.0]).unwrap();
        assert_eq!(spread, Spread { mean: 4.0, p50: 2.0, p99: 10.0, max: 10.0 });
        assert_eq!(Spread::of([f64::NAN]), None);
    }
}
