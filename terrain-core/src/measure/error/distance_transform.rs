use rayon::prelude::*;

/// Distance in pixels from each pixel's centre to the nearest marked one: 0 on marked pixels, infinite
/// where none is marked.
///
/// Exact: Pedro Felzenszwalb and Daniel Huttenlocher, "Distance Transforms of Sampled Functions"
/// (2012). Squared distances along columns first, then the lower envelope of parabolas along rows.
pub(super) fn distances_px(marked: &[bool], [width, height]: [usize; 2]) -> Vec<f64> {
    if width == 0 || height == 0 {
        return Vec::new();
    }
    let mut squares = squares_along_columns(marked, [width, height]);
    squares.par_chunks_mut(width).for_each(|row| {
        let envelope = lower_envelope(row);
        row.copy_from_slice(&envelope);
    });
    squares.into_par_iter().map(f64::sqrt).collect()
}

/// Square of the distance to the nearest marked pixel of the same column.
fn squares_along_columns(marked: &[bool], [width, height]: [usize; 2]) -> Vec<f64> {
    let mut steps = vec![f64::INFINITY; marked.len()];
    let mut sweep = |row: usize, before: Option<usize>| {
        for column in 0..width {
            let index = row * width + column;
            let passed_on = before.map_or(f64::INFINITY, |row| steps[row * width + column] + 1.0);
            steps[index] = if marked[index] { 0.0 } else { steps[index].min(passed_on) };
        }
    };
    (0..height).for_each(|row| sweep(row, row.checked_sub(1)));
    (0..height).rev().for_each(|row| sweep(row, Some(row + 1).filter(|&row| row < height)));
    steps.into_iter().map(|steps| steps * steps).collect()
}

/// At each place the least of `(place - i)² + values[i]` over all i.
fn lower_envelope(values: &[f64]) -> Vec<f64> {
    // Parabolas of the envelope from left to right, and where each begins to be the lowest.
    let mut parabolas: Vec<(usize, f64)> = Vec::new();
    for (vertex, &value) in values.iter().enumerate().filter(|(_, value)| value.is_finite()) {
        let begin = loop {
            let Some(&(last, begin)) = parabolas.last() else { break f64::NEG_INFINITY };
            let (here, there) = (vertex as f64, last as f64);
            let above = (value + here * here) - (values[last] + there * there);
            let crossing = above / (2.0 * (here - there));
            if crossing > begin {
                break crossing;
            }
            parabolas.pop();
        };
        parabolas.push((vertex, begin));
    }
    let mut current = 0;
    let lowest = |place: usize| {
        while parabolas.get(current + 1).is_some_and(|(_, begin)| *begin < place as f64) {
            current += 1;
        }
        parabolas.get(current).map_or(f64::INFINITY, |&(vertex, _)| {
            (place as f64 - vertex as f64).powi(2) + values[vertex]
        })
    };
    (0..values.len()).map(lowest).collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn brute_force(marked: &[bool], width: usize) -> Vec<f64> {
        let place = |index: usize| ((index % width) as f64, (index / width) as f64);
        let nearest = |index: usize| {
            let (x, y) = place(index);
            let marks = (0..marked.len()).filter(|&mark| marked[mark]).map(place);
            marks.map(|(u, v)| (x - u).hypot(y - v)).fold(f64::INFINITY, f64::min)
        };
        (0..marked.len()).map(nearest).collect()
    }

    proptest! {
        #[test]
        fn distances_are_those_of_trying_every_mark(
            width in 1_usize..14,
            height in 1_usize..14,
            seeds in proptest::collection::vec(0_u8..16, 196),
        ) {
            let marked = seeds[..width * height].iter().map(|seed| *seed == 0).collect::<Vec<_>>();
            let found = distances_px(&marked, [width, height]);
            for (found, expected) in found.iter().zip(brute_force(&marked, width)) {
                prop_assert!(*found == expected || (found - expected).abs() < 1.0e-9);
            }
        }
    }

    #[test]
    fn without_a_mark_nothing_is_near() {
        assert!(distances_px(&[false; 6], [3, 2]).iter().all(|d| d.is_infinite()));
        assert!(distances_px(&[], [0, 7]).is_empty());
    }
}
