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
