use glam::DVec2;
use rayon::prelude::*;

use super::drainage::{Drainage, fill_hollows};
use super::grid::HeightGrid;
use super::noise::{derived_seed, fractal_noise, gradient_noise};
use super::uplift::{Uplift, UpliftAt};

/// Height of the plain where rivers leave the ground.
pub const BASE_LEVEL_M: f32 = 450.0;
/// A stream falls at least so much from cell to cell.
const LEAST_FALL_M: f32 = 0.002;

/// Cells along a side of the coarsest grid, and how many steps of how long each grid is eroded.
/// Time is in units in which erodibility is 1; rivers of the whole ground are in balance after about
/// fifteen, what a finer grid adds after one or two.
const COARSEST_SIDE: usize = 60;
const STEPS: [(usize, f32); 6] = [(60, 0.5), (40, 0.4), (30, 0.3), (20, 0.2), (14, 0.15), (10, 0.1)];

/// The eroded ground and how water drains it.
#[derive(Clone, Debug)]
pub struct ErodedGround {
    /// Heights; every cell but the outlets has a lower neighbour.
    pub grid: HeightGrid,
    /// Drainage of these heights.
    pub drainage: Drainage,
}

/// Lets mountains rise and rivers cut into them, from a coarse grid to finer ones.
///
/// Rivers erode by the law of stream power, dz/dt = U - K sqrt(A) S, with uplift U, drained area A and
/// slope S; slopes steeper than rock stands slide. `advanced` hears of every step, as a share of all
/// work done; where it says no, there is no ground.
pub fn erode(seed: u32, mut advanced: impl FnMut(f64) -> bool) -> Option<ErodedGround> {
    let uplift = Uplift::new(derived_seed(seed, 1));
    let mut grid = first_ground(derived_seed(seed, 2));
    let total: f64 = (0..STEPS.len()).map(|level| work_of(level) * STEPS[level].0 as f64).sum();
    let mut done = 0.0;
    let mut drainage = None;
    for (level, (steps, duration)) in STEPS.into_iter().enumerate() {
        if level > 0 {
            grid = refined(&grid, derived_seed(seed, 10 + level as u32));
        }
        fill_hollows(&mut grid);
        let forces = forces_of(&grid, uplift);
        for step in 0..steps {
            let routed = Drainage::of(&grid, derived_seed(seed, 3));
            step_forward(&mut grid, &routed, &forces, duration);
            let last = level + 1 == STEPS.len() && step + 1 == steps;
            drainage = last.then_some(routed);
            done += work_of(level);
            if !advanced(done / total) {
                return None;
            }
        }
    }
    // The last step followed this drainage, so all water still flows down it.
    drainage.map(|drainage| ErodedGround { grid, drainage })
}

fn work_of(level: usize) -> f64 {
    f64::from(1 << (2 * level))
}

/// Low rough ground that rises away from the outlets.
fn first_ground(seed: u32) -> HeightGrid {
    let mut grid = HeightGrid { side: COARSEST_SIDE, heights_m: Vec::new() };
    let height_m = |cell: usize| {
        let place = grid.centre_m(cell) / 40_000.0;
        let rise = 12.0 - (place.x + place.y) as f32;
        BASE_LEVEL_M + 25.0 * rise.max(0.0) + 90.0 * (1.0 + fractal_noise(place, 5, seed)).max(0.0)
    };
    let heights_m = (0..grid.side * grid.side).map(height_m).collect();
    grid.heights_m = heights_m;
    grid
}

/// The same ground on cells half as wide, bent by a part of a coarse cell, and with bumps from which
/// finer streams can start.
///
/// Streams on a grid have eight directions. Bent at every refinement, they wind at every scale.
fn refined(coarse: &HeightGrid, seed: u32) -> HeightGrid {
    let mut fine = HeightGrid { side: 2 * coarse.side, heights_m: Vec::new() };
    let (coarse_m, fine_m) = (coarse.cell_m(), fine.cell_m());
    let height_m = |cell: usize| {
        let place_m = fine.centre_m(cell);
        let bend = |purpose: u32| {
            let noise = gradient_noise(place_m / (3.6 * coarse_m), derived_seed(seed, purpose));
            1.0 * coarse_m * f64::from(noise)
        };
        let bumps = gradient_noise(place_m / (2.7 * fine_m), derived_seed(seed, 3));
        let bent_m = coarse.height_at_m(place_m + DVec2::new(bend(1), bend(2)));
        (bent_m + 0.12 * fine_m as f32 * bumps).max(BASE_LEVEL_M)
    };
    let cells = 0..fine.side * fine.side;
    fine.heights_m = cells.into_par_iter().map(height_m).collect();
    fine
}

fn forces_of(grid: &HeightGrid, uplift: Uplift) -> Vec<UpliftAt> {
    let cells = 0..grid.heights_m.len();
    cells.into_par_iter().map(|cell| uplift.at(grid.centre_m(cell))).collect()
}

/// One implicit step of any length: from the outlets up, every cell is solved with its receiver's new
/// height (Braun and Willett 2013).
fn step_forward(grid: &mut HeightGrid, drainage: &Drainage, forces: &[UpliftAt], duration: f32) {
    let cell_m = grid.cell_m() as f32;
    for &cell in &drainage.upstream_order {
        let cell = cell as usize;
        let receiver = drainage.receivers[cell] as usize;
        if receiver == cell {
            grid.heights_m[cell] = BASE_LEVEL_M;
            continue;
        }
        let is_diagonal = cell % grid.side != receiver % grid.side
            && cell / grid.side != receiver / grid.side;
        let length_m = if is_diagonal { std::f32::consts::SQRT_2 * cell_m } else { cell_m };
        let UpliftAt { steepness_m, critical_slope } = forces[cell];
        let pull = duration * drainage.areas_m2[cell].sqrt() / length_m;
        let below_m = grid.heights_m[receiver];
        let risen_m = grid.heights_m[cell] + duration * steepness_m;
        let cut_m = (risen_m + pull * below_m) / (1.0 + pull);
        let highest_m = below_m + critical_slope * length_m;
        grid.heights_m[cell] = cut_m.min(highest_m).max(below_m + LEAST_FALL_M);
    }
}
