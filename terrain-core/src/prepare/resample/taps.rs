use glam::DVec2;

use crate::prepare::mosaic::SignedWindow;

/// Source cells in memory, premultiplied by their weight (the last part: 1 where there is data, 0
/// where there is none, between for half-clear colours).
pub struct TapWindow<const N: usize> {
    cells: Vec<[f32; N]>,
    window: SignedWindow,
}

impl<const N: usize> TapWindow<N> {
    /// The cells of a window, row by row.
    pub fn new(cells: Vec<[f32; N]>, window: SignedWindow) -> Self {
        Self { cells, window }
    }

    /// The cell, or nothing beyond the window.
    fn cell(&self, column: i64, row: i64) -> [f32; N] {
        let x = usize::try_from(column - self.window.column).unwrap_or(usize::MAX);
        let y = usize::try_from(row - self.window.row).unwrap_or(usize::MAX);
        if x >= self.window.width || y >= self.window.height {
            return [0.0; N];
        }
        self.cells[y * self.window.width + x]
    }

    /// Sixteen cells around a corner, or `None` at the window's edge.
    fn around(&self, column: i64, row: i64) -> Option<[&[[f32; N]]; 4]> {
        let x = usize::try_from(column - 1 - self.window.column).ok()?;
        let y = usize::try_from(row - 1 - self.window.row).ok()?;
        if x + 4 > self.window.width || y + 4 > self.window.height {
            return None;
        }
        Some(std::array::from_fn(|line| {
            let at = (y + line) * self.window.width + x;
            &self.cells[at..at + 4]
        }))
    }
}

/// The value at a position in columns and rows (cell centres at .5), premultiplied by its weight.
///
/// A texel that spans up to 1.5 cells is interpolated: with the cubic of E. Catmull and R. Rom, "A
/// Class of Local Interpolating Splines" (1974), held within the cells it is drawn from, where all
/// sixteen are whole; bilinearly with weights elsewhere. One that spans more is the average of
/// such samples, as many as it spans cells.
pub fn sample<const N: usize>(
    taps: &TapWindow<N>,
    position: DVec2,
    cells_a_texel: f64,
) -> [f32; N] {
    if cells_a_texel <= 1.5 {
        return interpolate(taps, position);
    }
    const MOST_SAMPLES: f64 = 16.0;
    let spread = cells_a_texel.ceil().min(MOST_SAMPLES) as usize;
    let mut sum = [0.0; N];
    for step in 0..spread * spread {
        let place = DVec2::new((step % spread) as f64, (step / spread) as f64);
        let offset = ((place + 0.5) / spread as f64 - 0.5) * cells_a_texel;
        let value = interpolate(taps, position + offset);
        sum = std::array::from_fn(|part| sum[part] + value[part]);
    }
    sum.map(|part| part / (spread * spread) as f32)
}

fn interpolate<const N: usize>(taps: &TapWindow<N>, position: DVec2) -> [f32; N] {
    let corner = (position - 0.5).floor();
    let along = (position - 0.5 - corner).as_vec2();
    let (column, row) = (corner.x as i64, corner.y as i64);
    let whole = taps
        .around(column, row)
        .filter(|lines| lines.iter().all(|line| line.iter().all(|cell| cell[N - 1] == 1.0)));
    match whole {
        Some(lines) => cubic(lines, catmull_rom(along.x), catmull_rom(along.y)),
        None => bilinear(taps, (column, row), along.x, along.y),
    }
}

fn cubic<const N: usize>(lines: [&[[f32; N]]; 4], across: [f32; 4], down: [f32; 4]) -> [f32; N] {
    let mut sum = [0.0; N];
    let mut low = [f32::INFINITY; N];
    let mut high = [f32::NEG_INFINITY; N];
    for (line, &weight_down) in lines.iter().zip(&down) {
        for (cell, &weight_across) in line.iter().zip(&across) {
            let weight = weight_down * weight_across;
            for part in 0..N {
                sum[part] += weight * cell[part];
                low[part] = low[part].min(cell[part]);
                high[part] = high[part].max(cell[part]);
            }
        }
    }
    std::array::from_fn(|part| sum[part].clamp(low[part], high[part]))
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

fn catmull_rom(t: f32) -> [f32; 4] {
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
            let [height, weight] = sample(&taps, position, 1.0);
            assert!((height / weight - plane(position.x, position.y)).abs() < 1e-4);
            assert!((weight - 1.0).abs() < 1e-5);
        }
        // Beside the gap the weight tells how much is known.
        let [_, weight] = sample(&taps, DVec2::new(4.4, 7.5), 1.0);
        assert!((weight - 0.1).abs() < 1e-6);
    }

    #[test]
    fn shrinking_averages_instead_of_picking() {
        let taps = window(|column, _| Some(if column % 2 == 0 { 0.0 } else { 100.0 }));
        let [height, weight] = sample(&taps, DVec2::new(2.0, 6.0), 4.0);
        assert!((height / weight - 50.0).abs() < 1.0, "{height} {weight}");
    }
}
