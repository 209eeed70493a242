use std::collections::VecDeque;

/// Widest void that is filled, in cells.
pub const MAX_VOID_CELLS: usize = 64;

/// Fills small gaps in heights as rows stream through.
///
/// A void is a connected set of cells without data (by edges) that data encloses, at most
/// [`MAX_VOID_CELLS`] wide and high. It is filled with a surface that meets its rim: cells start from
/// coarse averages (pull), refined level by level (push), then relaxed towards their neighbours'
/// mean. What touches the raster's border is not enclosed and stays; so does what is larger.
pub struct VoidFill {
    width: usize,
    height: usize,
    rows: VecDeque<Vec<f32>>,
    first_row: usize,
    /// Voids still open at the last row.
    open: Vec<Void>,
    /// What was done.
    pub report: VoidReport,
}

/// What became of the voids.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct VoidReport {
    /// Voids filled.
    pub voids_filled: u64,
    /// Cells filled.
    pub cells_filled: u64,
    /// Enclosed voids that were too large and stay.
    pub voids_left: u64,
}

/// A connected set of runs.
#[derive(Clone, Debug)]
struct Void {
    /// Row, first column, end column.
    runs: Vec<(usize, usize, usize)>,
    touches_border: bool,
    /// Runs are no longer kept: the void is too large to fill.
    too_large: bool,
    last_row: usize,
    left: usize,
    right: usize,
    top: usize,
}

impl VoidFill {
    /// A filler for a raster of this size.
    pub fn new(width: usize, height: usize) -> Self {
        Self {
            width,
            height,
            rows: VecDeque::new(),
            first_row: 0,
            open: Vec::new(),
            report: VoidReport::default(),
        }
    }

    /// Takes the next row and returns the rows that can no longer change.
    pub fn push(&mut self, row: Vec<f32>) -> Vec<Vec<f32>> {
        let index = self.first_row + self.rows.len();
        let runs = runs_without_data(&row);
        self.rows.push_back(row);
        self.join(index, &runs);
        self.close_ended(index);
        let last = index + 1 == self.height;
        if last {
            self.close_ended(index + 1);
        }
        // Rows still wanted: those of open voids that may yet be filled, with a rim of one.
        let wanted = self.open.iter().filter(|void| !void.too_large && !void.touches_border);
        let oldest = wanted.map(|void| void.top).min().unwrap_or(index + 1).min(index);
        let keep_from = if last { self.height } else { oldest.saturating_sub(1) };
        let mut done = Vec::new();
        while self.first_row < keep_from {
            let Some(row) = self.rows.pop_front() else { break };
            done.push(row);
            self.first_row += 1;
        }
        done
    }

    /// Adds the row's runs to the voids they touch, joining voids that meet.
    fn join(&mut self, index: usize, runs: &[(usize, usize)]) {
        for &(start, end) in runs {
            let on_border =
                start == 0 || end == self.width || index == 0 || index + 1 == self.height;
            let mut joined = Void {
                runs: vec![(index, start, end)],
                touches_border: on_border,
                too_large: false,
                last_row: index,
                left: start,
                right: end,
                top: index,
            };
            let (touching, apart) = std::mem::take(&mut self.open)
                .into_iter()
                .partition(|void| void.touches_run(index, start, end));
            self.open = apart;
            let touching: Vec<Void> = touching;
            for void in touching {
                joined.absorb(void);
            }
            joined.drop_if_hopeless();
            self.open.push(joined);
        }
    }

    /// Deals with the voids that have no run in the row `index`.
    fn close_ended(&mut self, index: usize) {
        let (ended, open) =
            std::mem::take(&mut self.open).into_iter().partition(|void| void.last_row < index);
        self.open = open;
        let ended: Vec<Void> = ended;
        for void in ended {
            if void.touches_border {
                continue;
            }
            if void.too_large {
                self.report.voids_left += 1;
            } else {
                self.fill(&void);
            }
        }
    }

    fn fill(&mut self, void: &Void) {
        let (width, height) = (void.right - void.left + 2, void.last_row - void.top + 3);
        let (x0, y0) = (void.left - 1, void.top - 1);
        let mut patch = vec![f32::NAN; width * height];
        for y in 0..height {
            if let Some(row) = (y0 + y).checked_sub(self.first_row).and_then(|y| self.rows.get(y)) {
                patch[y * width..(y + 1) * width].copy_from_slice(&row[x0..x0 + width]);
            }
        }
        let unknown: Vec<usize> = void
            .runs
            .iter()
            .flat_map(|&(row, start, end)| {
                (start..end).map(move |column| (row - y0) * width + column - x0)
            })
            .collect();
        fill_patch(&mut patch, width, &unknown);
        for &index in &unknown {
            let (y, x) = (y0 + index / width, x0 + index % width);
            if let Some(row) = y.checked_sub(self.first_row).and_then(|y| self.rows.get_mut(y)) {
                row[x] = patch[index];
            }
        }
        self.report.voids_filled += 1;
        self.report.cells_filled += unknown.len() as u64;
    }
}

impl Void {
    fn touches_run(&self, index: usize, start: usize, end: usize) -> bool {
        let above = |&&(row, _, _): &&(usize, usize, usize)| row + 1 == index;
        if self.last_row + 1 < index || end <= self.left || start >= self.right {
            return false;
        }
        self.runs
            .iter()
            .rev()
            .take_while(|run| run.0 + 1 >= index)
            .filter(above)
            .any(|&(_, other_start, other_end)| start < other_end && other_start < end)
    }

    fn absorb(&mut self, other: Self) {
        let own = std::mem::replace(&mut self.runs, other.runs);
        self.runs.extend(own);
        self.runs.sort_unstable();
        self.touches_border |= other.touches_border;
        self.too_large |= other.too_large;
        self.last_row = self.last_row.max(other.last_row);
        self.left = self.left.min(other.left);
        self.right = self.right.max(other.right);
        self.top = self.top.min(other.top);
    }

    /// Forgets all but the last rows' runs of a void that will not be filled.
    fn drop_if_hopeless(&mut self) {
        self.too_large |=
            self.right - self.left > MAX_VOID_CELLS || self.last_row - self.top >= MAX_VOID_CELLS;
        if self.too_large || self.touches_border {
            let last = self.last_row;
            self.runs.retain(|run| run.0 + 1 >= last);
        }
    }
}

/// Start and end columns of the stretches without data.
fn runs_without_data(row: &[f32]) -> Vec<(usize, usize)> {
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for (column, height) in row.iter().enumerate() {
        if !height.is_nan() {
            continue;
        }
        match runs.last_mut() {
            Some(run) if run.1 == column => run.1 = column + 1,
            _ => runs.push((column, column + 1)),
        }
    }
    runs
}

/// Fills the unknown cells of a small raster from those around them.
fn fill_patch(patch: &mut [f32], width: usize, unknown: &[usize]) {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn run(raster: &[f32], width: usize) -> (Vec<f32>, VoidReport) {
        let mut fill = VoidFill::new(width, raster.len() / width);
        let out: Vec<f32> =
            raster.chunks(width).flat_map(|row| fill.push(row.to_vec())).flatten().collect();
        (out, fill.report)
    }

    fn slope(width: usize, height: usize, hole: impl Fn(usize, usize) -> bool) -> Vec<f32> {
        (0..width * height)
            .map(|index| {
                let (row, column) = (index / width, index % width);
                if hole(row, column) { f32::NAN } else { 2.0 * column as f32 - row as f32 }
            })
            .collect()
    }

    #[test]
    fn a_gap_in_a_slope_is_filled_with_the_slope() {
        // Two arms that meet only in their last row: one void, found late.
        let hole = |r: usize, c: usize| {
            (3..9).contains(&r) && (c == 4 || c == 7) || r == 9 && (4..8).contains(&c)
        };
        let (out, report) = run(&slope(14, 16, hole), 14);
        let cells_filled = 6 * 2 + 4;
        assert_eq!(report, VoidReport { voids_filled: 1, cells_filled, voids_left: 0 });
        for (got, expected) in out.iter().zip(slope(14, 16, |_, _| false)) {
            assert!((got - expected).abs() < 0.6, "{got} {expected}");
        }
    }

    #[test]
    fn what_reaches_the_border_or_is_too_large_stays() {
        let open = |r: usize, c: usize| c < 3 && r == 5;
        let (out, report) = run(&slope(20, 12, open), 20);
        assert_eq!(report, VoidReport::default());
        assert_eq!(out.iter().filter(|height| height.is_nan()).count(), 3);
        let large = |r: usize, c: usize| (5..95).contains(&r) && (5..15).contains(&c);
        let (out, report) = run(&slope(20, 100, large), 20);
        assert_eq!(report, VoidReport { voids_left: 1, ..VoidReport::default() });
        assert_eq!(out.iter().filter(|height| height.is_nan()).count(), 900);
    }

    #[test]
    fn known_heights_are_never_touched_and_rows_keep_their_order() {
        let hole = |r: usize, c: usize| (r * 7 + c * 13).is_multiple_of(11);
        let before = slope(40, 90, hole);
        let (after, _) = run(&before, 40);
        assert_eq!(after.len(), before.len());
        for (old, new) in before.iter().zip(&after) {
            assert!(old.is_nan() || old == new);
        }
    }
}
