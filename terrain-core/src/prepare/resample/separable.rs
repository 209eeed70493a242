//! The same cubic as in `taps`, an axis at a time: where neither CRS is turned against the other,
//! columns depend on x alone and rows on y alone, and eight taps do the work of sixteen.

use std::collections::VecDeque;

use super::position_nodes::PositionNodes;
use super::taps::{TapWindow, catmull_rom, weighted};

/// Where along an axis a texel is drawn from: the first of four cells, and their weights.
type AxisTaps = (i64, [f32; 4]);

/// Samples a whole block row by row; `false` (and nothing done) where the axes are not apart or a
/// cell is missing.
pub fn sample_rows<const N: usize, const HOLD: bool>(
    taps: &TapWindow<N>,
    nodes: &PositionNodes,
    [width, height]: [usize; 2],
    mut take: impl FnMut(usize, &[[f32; N]]),
) -> bool {
    if !taps.is_whole() || !nodes.has_separate_axes() {
        return false;
    }
    let along = |position: Option<f64>| {
        let corner = (position? - 0.5).floor();
        let part = (position? - 0.5 - corner) as f32;
        Some((corner as i64 - 1, catmull_rom(part)))
    };
    let across: Option<Vec<AxisTaps>> =
        (0..width).map(|column| along(nodes.position(column, 0).map(|at| at.x))).collect();
    let down: Option<Vec<AxisTaps>> =
        (0..height).map(|row| along(nodes.position(0, row).map(|at| at.y))).collect();
    let (Some(across), Some(down)) = (across, down) else { return false };
    if !across.iter().all(|(column, _)| taps.has_columns(*column, 4))
        || !down.iter().all(|(row, _)| taps.has_rows(*row, 4))
    {
        return false;
    }
    let mut filtered: VecDeque<(i64, Vec<[f32; N]>)> = VecDeque::new();
    let mut line = vec![[0.0; N]; width];
    for (row, (first, weights)) in down.into_iter().enumerate() {
        while filtered.front().is_some_and(|(held, _)| *held < first) {
            filtered.pop_front();
        }
        // Rows run south, so what is missing is missing at the end.
        while filtered.len() < 4 {
            let next = first + filtered.len() as i64;
            filtered.push_back((next, filter_across::<N, HOLD>(taps.row(next), taps, &across)));
        }
        for (column, value) in line.iter_mut().enumerate() {
            let cells = [0, 1, 2, 3].map(|tap| filtered[tap].1[column]);
            *value = weighted::<N, HOLD>(&cells, weights);
        }
        take(row, &line);
    }
    true
}

fn filter_across<const N: usize, const HOLD: bool>(
    row: &[[f32; N]],
    taps: &TapWindow<N>,
    across: &[AxisTaps],
) -> Vec<[f32; N]> {
    across
        .iter()
        .map(|&(column, weights)| {
            let at = taps.index_of_column(column);
            weighted::<N, HOLD>(&[row[at], row[at + 1], row[at + 2], row[at + 3]], weights)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use glam::dvec2;

    use super::super::taps::sample;
    use super::*;
    use crate::prepare::mosaic::SignedWindow;

    #[test]
    fn an_axis_at_a_time_gives_what_both_together_give() {
        let window = SignedWindow { column: 10, row: -4, width: 40, height: 30 };
        let cells: Vec<[f32; 2]> = (0..window.width * window.height)
            .map(|index| [(index * 7919 % 613) as f32, 1.0])
            .collect();
        let taps = TapWindow::new(cells, window);
        let map = |x: f64, y: f64| Some(dvec2(14.3 + 1.21 * x, -1.4 + 0.77 * y));
        let size = [24, 19];
        let nodes = PositionNodes::new(size[0], size[1], map, None, 0.0);
        let mut rows = 0;
        let done = sample_rows::<2, false>(&taps, &nodes, size, |row, line| {
            for (column, value) in line.iter().enumerate() {
                let position = nodes.position(column, row).unwrap();
                let expected = sample::<2, false>(&taps, position, 1.0);
                assert!((value[0] - expected[0]).abs() < 0.01, "{row} {column}");
            }
            rows += 1;
        });
        assert!(done && rows == size[1]);
        let turned = |x: f64, y: f64| Some(dvec2(14.3 + x + 0.01 * y, -1.0 + y));
        let nodes = PositionNodes::new(size[0], size[1], turned, None, 0.0);
        assert!(!sample_rows::<2, false>(&taps, &nodes, size, |_, _| {}));
    }
}
