use rayon::prelude::*;

/// Four channels that are filtered at once, each with weights of its own.
pub(super) type Four = [f32; 4];

/// Filters each row. Weights are those of the offsets `-radius..=radius`, so their number is odd.
pub(super) fn along_rows(values: &[Four], [width, _]: [usize; 2], weights: &[Four]) -> Vec<Four> {
    let radius = weights.len() / 2;
    let filtered = values.par_chunks(width.max(1)).flat_map_iter(|row| {
        let sum = move |x: usize| {
            let taps = weights.iter().enumerate();
            taps.fold([0.0; 4], |sum, (tap, weight)| {
                let column = (x + tap).saturating_sub(radius).min(width - 1);
                add_weighted(sum, row[column], *weight)
            })
        };
        (0..row.len()).map(sum)
    });
    filtered.collect()
}

/// Filters each column; see [`along_rows`].
pub(super) fn along_columns(
    values: &[Four],
    [width, height]: [usize; 2],
    weights: &[Four],
) -> Vec<Four> {
    let radius = weights.len() / 2;
    let mut filtered = vec![[0.0; 4]; values.len()];
    filtered.par_chunks_mut(width.max(1)).enumerate().for_each(|(y, sums)| {
        for (tap, weight) in weights.iter().enumerate() {
            let row = (y + tap).saturating_sub(radius).min(height - 1);
            let row = &values[row * width..(row + 1) * width];
            for (sum, value) in sums.iter_mut().zip(row) {
                *sum = add_weighted(*sum, *value, *weight);
            }
        }
    });
    filtered
}

fn add_weighted(sum: Four, value: Four, weight: Four) -> Four {
    std::array::from_fn(|channel| sum[channel] + weight[channel] * value[channel])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_and_columns_are_filtered_with_the_border_continued() {
        // 3 columns x 2 rows, the same in every channel; weights of the left, own and right value.
        let values = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0].map(|value: f32| [value; 4]);
        let weights = [100.0, 10.0, 1.0].map(|weight: f32| [weight; 4]);
        let rows = along_rows(&values, [3, 2], &weights).into_iter().map(|four| four[0]);
        assert_eq!(rows.collect::<Vec<_>>(), [112.0, 124.0, 244.0, 896.0, 992.0, 1952.0]);
        let columns = along_columns(&values, [3, 2], &weights).into_iter().map(|four| four[3]);
        assert_eq!(columns.collect::<Vec<_>>(), [118.0, 236.0, 472.0, 188.0, 376.0, 752.0]);
    }

    #[test]
    fn each_channel_has_its_own_weights() {
        let weights = [[1.0, 2.0, 3.0, 4.0]];
        assert_eq!(along_rows(&[[1.0; 4]], [1, 1], &weights), [[1.0, 2.0, 3.0, 4.0]]);
    }

    #[test]
    fn nothing_gives_nothing() {
        assert!(along_rows(&[], [0, 0], &[[1.0; 4]]).is_empty());
        assert!(along_columns(&[], [0, 0], &[[1.0; 4]]).is_empty());
    }
}
