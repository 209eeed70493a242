//! Surfaces for voids: what their rims suggest.

use rayon::prelude::*;

use crate::surface::tin::{DistinctPoints, NaturalNeighbours};

/// Fills the unknown cells of a raster with heights of their natural neighbours on the rim: the known
/// cells beside them, across edges and corners. The rim goes all round, so every unknown cell lies in its hull.
pub fn fill_by_natural_neighbours(patch: &mut [f32], width: usize, unknown: &[usize]) {
    let beside = |index: usize| {
        let rows = [index - width, index, index + width];
        rows.into_iter().flat_map(|middle| middle - 1..=middle + 1)
    };
    let mut rim: Vec<usize> = unknown
        .iter()
        .flat_map(|&index| beside(index))
        .filter(|&cell| !patch[cell].is_nan())
        .collect();
    rim.sort_unstable();
    rim.dedup();
    let place = |cell: usize| [(cell % width) as f64, (cell / width) as f64];
    let points = rim.iter().map(|&cell| {
        let [x, y] = place(cell);
        [x, y, f64::from(patch[cell])]
    });
    let ground =
        DistinctPoints::new(points.collect()).and_then(|points| NaturalNeighbours::new(&points));
    let Ok(ground) = ground else { return relax(patch, width, unknown) };
    let heights: Vec<Option<f64>> = unknown
        .par_iter()
        .map_init(
            || ground.sampler(),
            |sampler, &cell| {
                let [x, y] = place(cell);
                sampler.height_m(x, y)
            },
        )
        .collect();
    for (&cell, height_m) in unknown.iter().zip(heights) {
        patch[cell] = height_m.map_or(f32::NAN, |height_m| height_m as f32);
    }
}

/// Fills the unknown cells of a small raster with a surface that meets their rim: cells start from coarse
/// averages (pull), refined level by level (push), then relaxed towards their neighbours' mean.
pub fn relax(patch: &mut [f32], width: usize, unknown: &[usize]) {
    pull_push(patch, width);
    // A few rounds of relaxation take the steps of the coarse levels out of the surface.
    const ROUNDS: usize = 48;
    for _ in 0..ROUNDS {
        for &index in unknown {
            let neighbours =
                [index - 1, index + 1, index - width, index + width].map(|near| patch[near]);
            let held = neighbours.iter().filter(|height| !height.is_nan());
            let count = held.clone().count();
            if count > 0 {
                patch[index] = held.sum::<f32>() / count as f32;
            }
        }
    }
}

/// Gives every cell without data the average of the smallest coarse cell that has one.
fn pull_push(patch: &mut [f32], width: usize) {
    let height = patch.len() / width;
    if width == 1 && height == 1 {
        return;
    }
    let (w, h) = (width.div_ceil(2), height.div_ceil(2));
    let mut coarse = vec![(0.0_f32, 0.0_f32); w * h];
    for (index, value) in patch.iter().enumerate() {
        if !value.is_nan() {
            let cell = &mut coarse[index / width / 2 * w + index % width / 2];
            *cell = (cell.0 + value, cell.1 + 1.0);
        }
    }
    let mut coarse: Vec<f32> = coarse.into_iter().map(|(sum, count)| sum / count).collect();
    pull_push(&mut coarse, w);
    for (index, value) in patch.iter_mut().enumerate() {
        if value.is_nan() {
            *value = coarse[index / width / 2 * w + index % width / 2];
        }
    }
}
