//! A linear predictor fitted to each tile, in integers so that decoding repeats it exactly.
//!
//! A sample is predicted from six neighbours already known: west, north, north-west, north-east, two
//! to the west and two to the north. The weights are those of least squares over the tile (the
//! normal equations, solved by elimination), rounded to 1/4096. Fitting adapts to the terrain: smooth
//! slopes get the weights of a plane or a curve, noisy ones those of an average.
//!
//! Source of the idea: adaptive linear prediction as in M. Weinberger, G. Seroussi and G. Sapiro,
//! "The LOCO-I Lossless Image Compression Algorithm" (2000), which switches between fixed weights;
//! here one set is fitted a tile, since a tile is small and its terrain of one kind.

/// Neighbours a sample is predicted from.
pub const TAPS: usize = 6;
/// A weight of one.
const ONE: i64 = 1 << 12;

/// Weights in units of 1/4096: west, north, north-west, north-east, west twice, north twice.
pub type Weights = [i16; TAPS];

/// The weights of the plane through west, north and north-west.
pub const PLANE: Weights = [ONE as i16, ONE as i16, -(ONE as i16), 0, 0, 0];

/// The six neighbours of an inner sample at `index`.
fn neighbours(samples: &[i32], index: usize, size: usize) -> [i32; TAPS] {
    let north = index - size;
    [
        samples[index - 1],
        samples[north],
        samples[north - 1],
        samples[north + 1],
        samples[index - 2],
        samples[north - size],
    ]
}

/// Predicts the sample at `index` of a square of `size` samples a side from those before it.
pub fn predict(samples: &[i32], index: usize, size: usize, weights: &Weights) -> i32 {
    let (row, column) = (index / size, index % size);
    match (row, column) {
        (0, 0) => 0,
        (0, _) => samples[index - 1],
        (_, 0) => samples[index - size],
        _ if row >= 2 && column >= 2 && column + 1 < size => {
            let neighbours = neighbours(samples, index, size);
            let sum: i64 =
                neighbours.iter().zip(weights).map(|(&n, &w)| i64::from(n) * i64::from(w)).sum();
            ((sum + ONE / 2) >> 12) as i32
        }
        _ => samples[index - 1]
            .wrapping_add(samples[index - size])
            .wrapping_sub(samples[index - size - 1]),
    }
}

/// The weights that predict the square best in the sense of least squares; [`PLANE`] where the
/// equations have no solution that fits a weight's range (flat tiles).
pub fn fit(samples: &[i32], size: usize) -> Weights {
    let mut matrix = [[0.0_f64; TAPS + 1]; TAPS];
    for row in 2..size {
        for column in 2..size - 1 {
            let index = row * size + column;
            // Differences from the west neighbour keep the sums small and the weights summing to 1.
            let base = samples[index - 1];
            let taps = neighbours(samples, index, size).map(|n| f64::from(n.wrapping_sub(base)));
            let target = f64::from(samples[index].wrapping_sub(base));
            for (equation, &tap) in matrix.iter_mut().zip(&taps).skip(1) {
                for (sum, &other) in equation.iter_mut().zip(&taps).skip(1) {
                    *sum += tap * other;
                }
                equation[TAPS] += tap * target;
            }
        }
    }
    let Some(solution) = solve(&mut matrix) else { return PLANE };
    let mut weights = [0; TAPS];
    for (weight, value) in weights.iter_mut().zip(solution).skip(1) {
        let scaled = (value * ONE as f64).round();
        if scaled.abs() > 4.0 * ONE as f64 {
            return PLANE;
        }
        *weight = scaled as i16;
    }
    let rest = ONE - weights.iter().map(|&w| i64::from(w)).sum::<i64>();
    i16::try_from(rest).map_or(PLANE, |west| {
        weights[0] = west;
        weights
    })
}

/// Solves the system in rows and columns 1.. by Gauss elimination with pivots.
fn solve(matrix: &mut [[f64; TAPS + 1]; TAPS]) -> Option<[f64; TAPS]> {
    for step in 1..TAPS {
        let pivot = (step..TAPS)
            .max_by(|&a, &b| f64::total_cmp(&matrix[a][step].abs(), &matrix[b][step].abs()))?;
        matrix.swap(step, pivot);
        let lead = matrix[step];
        if lead[step].abs() < 1e-6 {
            return None;
        }
        for (row, equation) in matrix.iter_mut().enumerate().skip(1) {
            if row != step {
                let factor = equation[step] / lead[step];
                for (value, &above) in equation.iter_mut().zip(&lead) {
                    *value -= factor * above;
                }
            }
        }
    }
    let mut solution = [0.0; TAPS];
    for (row, value) in solution.iter_mut().enumerate().skip(1) {
        *value = matrix[row][TAPS] / matrix[row][row];
    }
    Some(solution)
}
