//! Where the ground that holds data ends.

use super::SampleGrid;

/// A straight piece of border between two samples, each given as column and row.
pub type BorderPiece = [[usize; 2]; 2];

/// The lines between cells that hold data and those that do not (or lie outside), each as long as the
/// ground stays on one side. Pieces meet at their ends only.
pub fn border_of(grid: &SampleGrid<'_>) -> Vec<BorderPiece> {
    let mut pieces = Vec::new();
    for row in 0..grid.rows {
        let sides = |column: usize| {
            let (column, row) = (column as i64, row as i64);
            [grid.is_cell_held(column, row - 1), grid.is_cell_held(column, row)]
        };
        let runs = runs_of(grid.columns - 1, sides);
        pieces.extend(runs.into_iter().map(|[start, end]| [[start, row], [end, row]]));
    }
    for column in 0..grid.columns {
        let sides = |row: usize| {
            let (column, row) = (column as i64, row as i64);
            [grid.is_cell_held(column - 1, row), grid.is_cell_held(column, row)]
        };
        let runs = runs_of(grid.rows - 1, sides);
        pieces.extend(runs.into_iter().map(|[start, end]| [[column, start], [column, end]]));
    }
    pieces
}

/// Start and end of the stretches of a line along which one side, always the same, is held.
fn runs_of(length: usize, sides: impl Fn(usize) -> [bool; 2]) -> Vec<[usize; 2]> {
    let mut runs = Vec::new();
    let mut open: Option<(usize, [bool; 2])> = None;
    for index in 0..=length {
        let here = (index < length).then(|| sides(index)).filter(|[a, b]| a != b);
        if open.map(|(_, sides)| sides) == here {
            continue;
        }
        if let Some((start, _)) = open {
            runs.push([start, index]);
        }
        open = here.map(|sides| (index, sides));
    }
    runs
}
