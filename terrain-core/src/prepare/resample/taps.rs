use glam::DVec2;

use crate::prepare::mosaic::SignedWindow;

/// Source cells in memory, premultiplied by their weight (the last part: 1 where there is data, 0
/// where there is none, between for half-clear colours).
pub struct TapWindow<const N: usize> {
    cells: Vec<[f32; N]>,
    window: SignedWindow,
    /// Whether every cell has its whole weight.
    is_whole: bool,
}

impl<const N: usize> TapWindow<N> {
    /// The cells of a window, row by row.
    pub fn new(cells: Vec<[f32; N]>, window: SignedWindow) -> Self {
        let is_whole = cells.iter().all(|cell| cell[N - 1] == 1.0);
        Self { cells, window, is_whole }
    }

    /// Whether every cell has its whole weight.
    pub fn is_whole(&self) -> bool {
        self.is_whole
    }

    /// Whether the window holds `count` columns from the first one on.
    pub fn has_columns(&self, first: i64, count: usize) -> bool {
        let from = first - self.window.column;
        from >= 0 && from as usize + count <= self.window.width
    }

    /// Whether the window holds `count` rows from the first one on.
    pub fn has_rows(&self, first: i64, count: usize) -> bool {
        let from = first - self.window.row;
        from >= 0 && from as usize + count <= self.window.height
    }

    /// Index in a row of a column the window holds.
    pub fn index_of_column(&self, column: i64) -> usize {
        (column - self.window.column) as usize
    }

    /// A row the window holds.
    pub fn row(&self, row: i64) -> &[[f32; N]] {
        let at = (row - self.window.row) as usize * self.window.width;
        &self.cells[at..at + self.window.width]
    }

    /// The cell, or nothing beyond the window.
    fn cell(&self, column: i64, row: i64) -> [f32; N] {
        if self.has_columns(column, 1) && self.has_rows(row, 1) {
            self.row(row)[self.index_of_column(column)]
        } else {
            [0.0; N]
        }
    }

    /// Sixteen cells around a corner, or `None` at the window's edge.
    fn around(&self, column: i64, row: i64) -> Option<[[[f32; N]; 4]; 4]> {
        if !(self.has_columns(column - 1, 4) && self.has_rows(row - 1, 4)) {
            return None;
        }
        let at = self.index_of_column(column - 1);
        Some(std::array::from_fn(|line| {
            let row = self.row(row - 1 + line as i64);
            [row[at], row[at + 1], row[at + 2], row[at + 3]]
        }))
    }
}

/// The value at a position in columns and rows (cell centres at .5), premultiplied by its weight.
///
/// A texel that spans up to 1.5 cells is interpolated: with the cubic of E. Catmull and R. Rom, "A
/// Class of Local Interpolating Splines" (1974), where all sixteen cells are whole; bilinearly with
/// weights elsewhere. `HOLD` keeps the cubic within the cells it is drawn from. A texel that spans
/// more is the average of such samples, as many as it spans cells.
pub fn sample<const N: usize, const HOLD: bool>(
    taps: &TapWindow<N>,
    position: DVec2,
    cells_a_texel: f64,
) -> [f32; N] {
    if cells_a_texel <= MOST_INTERPOLATED {
        return interpolate::<N, HOLD>(taps, position);
    }
    const MOST_SAMPLES: f64 = 16.0;
    let spread = cells_a_texel.ceil().min(MOST_SAMPLES) as usize;
    let mut sum = [0.0; N];
    for step in 0..spread * spread {
        let place = DVec2::new((step % spread) as f64, (step / spread) as f64);
        let offset = ((place + 0.5) / spread as f64 - 0.5) * cells_a_texel;
        let value = interpolate::<N, HOLD>(taps, position + offset);
        sum = std::array::from_fn(|part| sum[part] + value[part]);
    }
    sum.map(|part| part / (spread * spread) as f32)
}

/// Cells a texel may span and still be interpolated between them.
pub const MOST_INTERPOLATED: f64 = 1.5;

fn interpolate<const N: usize, const HOLD: bool>(taps: &TapWindow<N>, position: DVec2) -> [f32; N] {
    let corner = (position - 0.5).floor();
    let along = (position - 0.5 - corner).as_vec2();
    let (column, row) = (corner.x as i64, corner.y as i64);
    let are_whole = |lines: &[[[f32; N]; 4]; 4]| {
        taps.is_whole || lines.iter().flatten().all(|cell| cell[N - 1] == 1.0)
    };
    match taps.around(column, row).filter(are_whole) {
        Some(lines) => {
            let across = catmull_rom(along.x);
            let rows = lines.map(|line| weighted::<N, HOLD>(&line, across));
            weighted::<N, HOLD>(&rows, catmull_rom(along.y))
        }
        None => bilinear(taps, (column, row), along.x, along.y),
    }
}

/// The weighted sum of four cells in a line; with `HOLD` between the least and greatest of them.
pub fn weighted<const N: usize, const HOLD: bool>(
    cells: &[[f32; N]; 4],
    weights: [f32; 4],
) -> [f32; N] {
    std::array::from_fn(|part| {
        let [a, b, c, d] = [cells[0][part], cells[1][part], cells[2][part], cells[3][part]];
        let sum = weights[0] * a + weights[1] * b + weights[2] * c + weights[3] * d;
        if HOLD { sum.clamp(a.min(b).min(c).min(d), a.max(b).max(c).max(d)) } else { sum }
    })
}

fn bilinear<const N: usize>(
    taps: &TapWindow<N>,
    (column, row): (i64, i64),
    x: f32,
    y: f32,
) -> [f32; N] {
    let mut sum = [0.0; N];
    for (dx, dy, weight) in
        [(0, 0, (1.0 - x) * (1.0 - y)), (1, 0, x * (1.0 - y)), (0, 1, (1.0 - x) * y), (1, 1, x * y)]
    {
        let cell = taps.cell(column + dx, row + dy);
        sum = std::array::from_fn(|part| sum[part] + weight * cell[part]);
    }
    sum
}

/// Weights of four cells for a place `t` of the way from the second to the third.
pub fn catmull_rom(t: f32) -> [f32; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [
        0.5 * (-t3 + 2.0 * t2 - t),
        0.5 * (3.0 * t3 - 5.0 * t2 + 2.0),
        0.5 * (-3.0 * t3 + 4.0 * t2 + t),
        0.5 * (t3 - t2),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn window(height: impl Fn(i64, i64) -> Option<f32>) -> TapWindow<2> {
        let window = SignedWindow { column: -3, row: 2, width: 12, height: 10 };
        let cells = (0..window.width * window.height)
            .map(|index| {
                let column = window.column + (index % window.width) as i64;
                let row = window.row + (index / window.width) as i64;
                height(column, row).map_or([0.0; 2], |height| [height, 1.0])
            })
            .collect();
        TapWindow::new(cells, window)
    }

    #[test]
    fn a_plane_is_reproduced_also_beside_a_gap() {
        let plane = |x: f64, y: f64| (3.0 * x - 2.0 * y + 7.0) as f32;
        let taps = window(|column, row| {
            (column != 4 || row != 7).then(|| plane(column as f64 + 0.5, row as f64 + 0.5))
        });
        for position in [DVec2::new(0.5, 5.5), DVec2::new(1.3, 6.9), DVec2::new(0.0, 4.25)] {
            let [height, weight] = sample::<2, true>(&taps, position, 1.0);
            assert!((height / weight - plane(position.x, position.y)).abs() < 1e-4);
            assert!((weight - 1.0).abs() < 1e-5);
        }
        // Beside the gap the weight tells how much is known.
        let [_, weight] = sample::<2, true>(&taps, DVec2::new(4.4, 7.5), 1.0);
        assert!((weight - 0.1).abs() < 1e-6);
    }

    #[test]
    fn shrinking_averages_instead_of_picking() {
        let taps = window(|column, _| Some(if column % 2 == 0 { 0.0 } else { 100.0 }));
        let [height, weight] = sample::<2, true>(&taps, DVec2::new(2.0, 6.0), 4.0);
        assert!((height / weight - 50.0).abs() < 1.0, "{height} {weight}");
    }
}
