use std::collections::VecDeque;

use super::void_surface::{fill_by_natural_neighbours, relax};

/// Widest void that is always filled, in cells.
pub const MAX_VOID_CELLS: usize = 64;
/// Widest void that is filled on request, in cells: so many rows may have to wait in memory.
pub const MAX_LARGE_VOID_CELLS: usize = 2048;

/// Which voids are filled, and with what.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum VoidRule {
    /// Those at most [`MAX_VOID_CELLS`] wide and high, with a relaxed surface.
    Small,
    /// Those and others of at most so many cells, [`MAX_LARGE_VOID_CELLS`] wide and high, all by the
    /// natural neighbours on their rims.
    Large {
        /// Most cells of a void.
        most_cells: usize,
    },
}

impl VoidRule {
    /// Whether a void of so many columns, rows and cells is filled.
    fn allows(self, columns: usize, rows: usize, cells: usize) -> bool {
        let side = columns.max(rows);
        match self {
            Self::Small => side <= MAX_VOID_CELLS,
            Self::Large { most_cells } => {
                side <= MAX_VOID_CELLS || side <= MAX_LARGE_VOID_CELLS && cells <= most_cells
            }
        }
    }
}

/// Fills gaps in heights as rows stream through.
///
/// A void is a connected set of cells without data (by edges) that data encloses. It is filled with a
/// surface that meets its rim, if it is small enough for the rule. What touches the
/// raster's border is not enclosed and stays; so does what is larger.
pub struct VoidFill {
    width: usize,
    height: usize,
    rule: VoidRule,
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
    cells: usize,
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
    pub fn new(width: usize, height: usize, rule: VoidRule) -> Self {
        Self {
            width,
            height,
            rule,
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
                cells: end - start,
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
            joined.drop_if_hopeless(self.rule);
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
        match self.rule {
            VoidRule::Small => relax(&mut patch, width, &unknown),
            VoidRule::Large { .. } => fill_by_natural_neighbours(&mut patch, width, &unknown),
        }
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
        self.cells += other.cells;
        self.touches_border |= other.touches_border;
        self.too_large |= other.too_large;
        self.last_row = self.last_row.max(other.last_row);
        self.left = self.left.min(other.left);
        self.right = self.right.max(other.right);
        self.top = self.top.min(other.top);
    }

    /// Forgets all but the last rows' runs of a void that will not be filled.
    fn drop_if_hopeless(&mut self, rule: VoidRule) {
        let (columns, rows) = (self.right - self.left, self.last_row - self.top + 1);
        self.too_large |= !rule.allows(columns, rows, self.cells);
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

#[cfg(test)]
mod tests {
    use super::*;

    fn run(raster: &[f32], width: usize) -> (Vec<f32>, VoidReport) {
        run_by(VoidRule::Small, raster, width)
    }

    fn run_by(rule: VoidRule, raster: &[f32], width: usize) -> (Vec<f32>, VoidReport) {
        let mut fill = VoidFill::new(width, raster.len() / width, rule);
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

    #[test]
    fn natural_neighbours_fill_large_voids_with_the_slope_itself() {
        // A lake with an island, wider than what is filled unasked, and one too large.
        let lake = |r: usize, c: usize| {
            let away = (r as f64 - 60.0).hypot(c as f64 - 70.0);
            away < 45.0 && away > 6.0
        };
        let sea = |r: usize, c: usize| r > 120 && r < 220 && (5..135).contains(&c);
        let before = slope(140, 225, |r, c| lake(r, c) || sea(r, c));
        let rule = VoidRule::Large { most_cells: 8000 };
        let (after, report) = run_by(rule, &before, 140);
        let cells_filled = before[..140 * 120].iter().filter(|height| height.is_nan()).count();
        let cells_filled = cells_filled as u64;
        assert_eq!(report, VoidReport { voids_filled: 1, cells_filled, voids_left: 1 });
        for (index, (got, expected)) in after.iter().zip(slope(140, 225, |_, _| false)).enumerate()
        {
            let filled = !sea(index / 140, index % 140);
            assert!(!filled || (got - expected).abs() < 1e-3, "{got} {expected}");
        }
        assert_eq!(run(&before, 140).1, VoidReport { voids_left: 2, ..VoidReport::default() });
    }
}
