use super::colour_codes::{code_from_linear, linear_from_code};

/// Finds the best piecewise-linear approximation of one triangle's colour over distance, for any
/// number of knots.
///
/// Knots lie at sampled distances and take the sampled colours. Between knots colours run linearly
/// in linear light (formula (4)), before the first and after the last they stay. The error of an
/// approximation is its largest departure from the samples in any channel, in steps of 1/255 of
/// sRGB, which is how a screen shows it.
///
/// The search is dynamic programming over the number of knots: the best approximation of the first
/// samples with k knots, the last one at sample j, extends the best one with k - 1 knots, the last one
/// at some i < j. That is optimal among all choices of sampled distances. It costs time in proportion
/// to n^3 for the n samples and n^2 a knot.
pub struct KnotSearch {
    count: usize,
    /// `segments[from * count + to]`: error at the samples between two neighbouring knots.
    segments: Vec<f32>,
    /// Error at the samples after the last knot.
    after: Vec<f32>,
    /// `reached[k][j]`: least error up to sample j with k + 1 knots, the last at j.
    reached: Vec<Vec<f32>>,
    /// `before[k][j]`: the knot before it.
    before: Vec<Vec<u8>>,
}

impl KnotSearch {
    /// Sets up the search for colours (sRGB codes) sampled at increasing distances (metres): at
    /// least one, at most [`super::DistanceSet::MOST`], as many of either.
    pub fn new(distances_m: &[f64], samples: &[[u8; 3]]) -> Self {
        let count = samples.len().min(distances_m.len());
        let mut segments = vec![0.0; count * count];
        for from in 0..count {
            for to in from + 2..count {
                segments[from * count + to] = segment_error(distances_m, samples, from, to);
            }
        }
        let run = |range: std::ops::Range<usize>, to: usize| {
            range.map(|i| difference(samples[i], samples[to])).fold(0.0, f32::max)
        };
        let first = (0..count).map(|j| run(0..j, j)).collect();
        let after = (0..count).map(|j| run(j + 1..count, j)).collect();
        Self { count, segments, after, reached: vec![first], before: vec![vec![0; count]] }
    }

    /// The least error with exactly this many knots (at least 1), and where its last knot lies.
    fn error_with(&mut self, knots: usize) -> (f32, usize) {
        while self.reached.len() < knots {
            self.deepen();
        }
        let reached = &self.reached[knots - 1];
        let whole = (0..self.count).map(|j| (reached[j].max(self.after[j]), j));
        whole.fold((f32::INFINITY, 0), |best, next| if next.0 < best.0 { next } else { best })
    }

    fn deepen(&mut self) {
        let last = &self.reached[self.reached.len() - 1];
        let mut reached = vec![f32::INFINITY; self.count];
        let mut before = vec![0; self.count];
        for j in 1..self.count {
            for (i, reached_before) in last.iter().enumerate().take(j) {
                let error = reached_before.max(self.segments[i * self.count + j]);
                if error < reached[j] {
                    (reached[j], before[j]) = (error, i as u8);
                }
            }
        }
        self.reached.push(reached);
        self.before.push(before);
    }

    /// The least error with at most 1, 2, .. knots, up to as many as there are samples (error 0).
    pub fn least_errors(&mut self) -> Vec<f32> {
        let mut best = f32::INFINITY;
        let mut errors = Vec::with_capacity(self.count);
        for knots in 1..=self.count {
            best = best.min(self.error_with(knots).0);
            errors.push(best);
            if best == 0.0 {
                break;
            }
        }
        errors.resize(self.count, 0.0);
        errors
    }

    /// The fewest knots that keep the error at or below a limit, as numbers of samples.
    pub fn fewest(&mut self, limit_steps: f32) -> Vec<u8> {
        let limit_steps = limit_steps.max(0.0);
        for knots in 1..self.count {
            let (error, last) = self.error_with(knots);
            if error <= limit_steps {
                return self.traced(knots, last);
            }
        }
        (0..self.count).map(|sample| sample as u8).collect()
    }

    /// The knots of the best approximation with so many whose last is `last`.
    fn traced(&self, knots: usize, last: usize) -> Vec<u8> {
        let mut found = vec![last as u8];
        for layer in (1..knots).rev() {
            let knot = usize::from(found[found.len() - 1]);
            found.push(self.before[layer][knot]);
        }
        found.reverse();
        found
    }
}

/// Largest difference of two colours in any channel, in steps.
fn difference(a: [u8; 3], b: [u8; 3]) -> f32 {
    let apart = |channel: usize| a[channel].abs_diff(b[channel]);
    f32::from(apart(0).max(apart(1)).max(apart(2)))
}

fn segment_error(distances_m: &[f64], samples: &[[u8; 3]], from: usize, to: usize) -> f32 {
    let [start, end] = [from, to].map(|knot| samples[knot].map(linear_from_code));
    let span_m = distances_m[to] - distances_m[from];
    let mut worst = 0.0_f32;
    for between in from + 1..to {
        let part = ((distances_m[between] - distances_m[from]) / span_m) as f32;
        for channel in 0..3 {
            let linear = start[channel] + (end[channel] - start[channel]) * part;
            let shown = code_from_linear(linear);
            worst = worst.max((shown - f32::from(samples[between][channel])).abs());
        }
    }
    worst
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// The error of the knots in `mask`, by the definition, in f64 with the sRGB formulas.
    fn error_of(distances_m: &[f64], samples: &[[u8; 3]], knots: &[usize]) -> f64 {
        let linear = |code: u8| {
            let encoded = f64::from(code) / 255.0;
            match encoded <= 0.04045 {
                true => encoded / 12.92,
                false => ((encoded + 0.055) / 1.055).powf(2.4),
            }
        };
        let code = |linear: f64| match linear <= 0.003_130_8 {
            true => 255.0 * 12.92 * linear,
            false => 255.0 * (1.055 * linear.powf(1.0 / 2.4) - 0.055),
        };
        let mut worst = 0.0_f64;
        for (i, sample) in samples.iter().enumerate() {
            let next = knots.iter().position(|&knot| knot >= i);
            for channel in 0..3 {
                let at = |knot: usize| linear(samples[knot][channel]);
                let shown = match next {
                    Some(0) => at(knots[0]),
                    None => at(knots[knots.len() - 1]),
                    Some(next) => {
                        let (a, b) = (knots[next - 1], knots[next]);
                        let part =
                            (distances_m[i] - distances_m[a]) / (distances_m[b] - distances_m[a]);
                        at(a) + (at(b) - at(a)) * part
                    }
                };
                worst = worst.max((code(shown) - f64::from(sample[channel])).abs());
            }
        }
        worst
    }

    /// Least error of any choice of at most so many knots.
    fn brute_force(distances_m: &[f64], samples: &[[u8; 3]], most: usize) -> f64 {
        let choices = (1_u32..1 << samples.len()).filter(|mask| mask.count_ones() as usize <= most);
        let knots = |mask: u32| (0..samples.len()).filter(move |i| mask >> i & 1 == 1);
        choices
            .map(|mask| error_of(distances_m, samples, &knots(mask).collect::<Vec<_>>()))
            .fold(f64::INFINITY, f64::min)
    }

    fn cases() -> impl Strategy<Value = (Vec<f64>, Vec<[u8; 3]>)> {
        (1usize..8).prop_flat_map(|count| {
            let steps = proptest::collection::vec(0.1..5.0_f64, count);
            let distances = steps.prop_map(|steps| {
                steps
                    .iter()
                    .scan(10.0, |sum, step| Some(*sum + step).inspect(|d| *sum = *d))
                    .collect()
            });
            (distances, proptest::collection::vec(any::<[u8; 3]>(), count))
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn the_least_errors_are_those_of_trying_every_choice((distances_m, samples) in cases()) {
            let errors = KnotSearch::new(&distances_m, &samples).least_errors();
            for (index, error) in errors.iter().enumerate() {
                let least = brute_force(&distances_m, &samples, index + 1);
                prop_assert!((f64::from(*error) - least).abs() < 0.02, "{index}: {error} {least}");
            }
        }

        #[test]
        fn the_fewest_knots_hold_the_limit_and_none_fewer_do(
            (distances_m, samples) in cases(),
            limit in 0.0..120.0_f32,
        ) {
            let knots = KnotSearch::new(&distances_m, &samples).fewest(limit);
            prop_assert!(knots.windows(2).all(|pair| pair[0] < pair[1]));
            let places: Vec<usize> = knots.iter().map(|&knot| usize::from(knot)).collect();
            prop_assert!(error_of(&distances_m, &samples, &places) <= f64::from(limit) + 0.02);
            if knots.len() > 1 {
                let fewer = brute_force(&distances_m, &samples, knots.len() - 1);
                prop_assert!(fewer > f64::from(limit) - 0.02, "{} knots do", knots.len() - 1);
            }
        }
    }

    #[test]
    fn one_colour_keeps_one_knot() {
        let distances_m: Vec<f64> = (1..=20).map(f64::from).collect();
        let mut search = KnotSearch::new(&distances_m, &[[9, 200, 31]; 20]);
        assert_eq!(search.fewest(0.0).len(), 1);
        assert_eq!(search.least_errors(), vec![0.0; 20]);
    }

    #[test]
    fn a_line_in_linear_light_keeps_its_ends() {
        let distances_m: Vec<f64> = (0..=10).map(|i| 100.0 + 10.0 * f64::from(i)).collect();
        let samples: Vec<[u8; 3]> =
            (0..=10).map(|i| [code_from_linear(0.2 + 0.05 * i as f32).round() as u8; 3]).collect();
        let knots = KnotSearch::new(&distances_m, &samples).fewest(1.0);
        assert_eq!(knots, [0, 10]);
    }
}
