/// A curve through samples that never overshoots them: between two samples it stays between their
/// values, and where three rise (or fall) in a row it rises (falls) throughout. It is once
/// continuously differentiable and exact at the samples.
///
/// Cubic Hermite with the slopes of M. Steffen, "A simple method for monotonic interpolation in one
/// dimension" (Astronomy and Astrophysics 239, 1990), section 2: at an inner sample the slope of the
/// parabola through it and its two neighbours, limited to twice the smaller of the two secants and 0
/// at an extremum; at the ends the parabola's slope under the same limit.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MonotoneCurve {
    slopes: Vec<f64>,
    values: Vec<f64>,
}

impl MonotoneCurve {
    /// The curve through `values` at the strictly increasing `times`, of the same number.
    pub fn new(times: &[f64], values: Vec<f64>) -> Self {
        let widths: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let secants: Vec<f64> = values
            .windows(2)
            .zip(&widths)
            .map(|(pair, width)| (pair[1] - pair[0]) / width)
            .collect();
        let last = secants.len();
        let slope_at = |index: usize| match (index, last) {
            (_, 0) => 0.0,
            (_, 1) => secants[0],
            (0, _) => end_slope([secants[0], secants[1]], [widths[0], widths[1]]),
            (i, n) if i == n => {
                end_slope([secants[n - 1], secants[n - 2]], [widths[n - 1], widths[n - 2]])
            }
            (i, _) => inner_slope([secants[i - 1], secants[i]], [widths[i - 1], widths[i]]),
        };
        Self { slopes: (0..values.len()).map(slope_at).collect(), values }
    }

    /// The value a fraction (0..=1) into the interval that begins at sample `index` and is `width`
    /// long.
    pub fn value(&self, index: usize, fraction: f64, width: f64) -> f64 {
        let (from, to) = (self.values[index], self.values[index + 1]);
        let (start, end) = (self.slopes[index] * width, self.slopes[index + 1] * width);
        let rise = to - from;
        if fraction >= 1.0 {
            return to;
        }
        // Horner's form of the Hermite cubic; at fraction 0 exactly `from`.
        let cubic = start + end - 2.0 * rise;
        let square = 3.0 * rise - 2.0 * start - end;
        from + fraction * (start + fraction * (square + fraction * cubic))
    }
}

fn inner_slope(secants: [f64; 2], widths: [f64; 2]) -> f64 {
    let [before, after] = secants;
    if before * after <= 0.0 {
        return 0.0;
    }
    let parabola = (before * widths[1] + after * widths[0]) / (widths[0] + widths[1]);
    let limit = 2.0 * before.abs().min(after.abs());
    parabola.clamp(-limit, limit)
}

/// The slope at an end; `secants` and `widths` from the end inwards.
fn end_slope(secants: [f64; 2], widths: [f64; 2]) -> f64 {
    let share = widths[0] / (widths[0] + widths[1]);
    let parabola = secants[0] * (1.0 + share) - secants[1] * share;
    if parabola * secants[0] <= 0.0 {
        return 0.0;
    }
    let limit = 2.0 * secants[0].abs();
    parabola.clamp(-limit, limit)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Times and values of a curve with 2 to 12 samples, among them runs of equal ones.
    fn samples() -> impl Strategy<Value = (Vec<f64>, Vec<f64>)> {
        let value = prop_oneof![-1.0e3..1.0e3f64, Just(5.0), Just(7.0)];
        prop::collection::vec((1.0e-3..10.0f64, value), 2..12).prop_map(|steps| {
            let mut t = 0.0;
            steps
                .into_iter()
                .map(|(width, value)| {
                    t += width;
                    (t, value)
                })
                .unzip()
        })
    }

    proptest! {
        #[test]
        fn it_hits_its_samples_and_never_leaves_their_range((times, values) in samples()) {
            let curve = MonotoneCurve::new(&times, values.clone());
            for (index, pair) in values.windows(2).enumerate() {
                let width = times[index + 1] - times[index];
                prop_assert_eq!(curve.value(index, 0.0, width), pair[0]);
                prop_assert_eq!(curve.value(index, 1.0, width), pair[1]);
                let slack = 1e-9 * (pair[0].abs() + pair[1].abs());
                let mut before = pair[0];
                for step in 1..=64 {
                    let value = curve.value(index, f64::from(step) / 64.0, width);
                    let towards = (pair[1] - pair[0]).signum();
                    prop_assert!((value - before) * towards >= -slack, "turns back at {}", step);
                    before = value;
                }
            }
        }

        #[test]
        fn its_speed_is_continuous((times, values) in samples()) {
            let curve = MonotoneCurve::new(&times, values.clone());
            for index in 1..values.len() - 1 {
                let [left, right] = [index - 1, index].map(|i| times[i + 1] - times[i]);
                let step = 1.0e-6;
                let arriving = (values[index] - curve.value(index - 1, 1.0 - step, left)) / (step * left);
                let leaving = (curve.value(index, step, right) - values[index]) / (step * right);
                let scale = values.iter().fold(1.0, |max: f64, v| max.max(v.abs())) / left.min(right);
                prop_assert!((arriving - leaving).abs() < 1e-3 * scale, "{arriving} {leaving}");
            }
        }
    }

    #[test]
    fn it_reproduces_a_parabola_that_nowhere_bends_too_much() {
        let times: Vec<f64> = (4..12).map(|i| f64::from(i) * 0.5).collect();
        let curve = MonotoneCurve::new(&times, times.iter().map(|t| t * t).collect());
        for (index, start) in times[..times.len() - 1].iter().enumerate() {
            let t = start + 0.2;
            assert!((curve.value(index, 0.4, 0.5) - t * t).abs() < 1e-12);
        }
    }
}
