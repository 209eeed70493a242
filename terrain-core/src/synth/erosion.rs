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
const STEPS: [(usize, f32); LEVELS] =
    [(60, 0.5), (40, 0.4), (30, 0.3), (14, 0.3), (8, 0.25), (6, 0.2)];
/// Grids from the coarsest to the finest, each of half as wide cells.
pub const LEVELS: usize = 6;

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
/// slope S; slopes steeper than rock stands slide. The first `levels` grids are eroded, at most
/// [`LEVELS`]; the last is the result. `advanced` hears of every step, as a share of all
/// work done; where it says no, there is no ground.
pub fn erode(
    seed: u32,
    levels: usize,
    mut advanced: impl FnMut(f64) -> bool,
) -> Option<ErodedGround> {
    let uplift = Uplift::new(derived_seed(seed, 1));
    let mut grid = first_ground(derived_seed(seed, 2));
    let total: f64 = (0..levels).map(|level| work_of(level) * STEPS[level].0 as f64).sum();
    let mut done = 0.0;
    let mut drainage = None;
    for (level, (steps, duration)) in STEPS.into_iter().take(levels).enumerate() {
        if level > 0 {
            grid = refined(&grid, derived_seed(seed, 10 + level as u32));
        }
        fill_hollows(&mut grid);
        let forces = forces_of(&grid, uplift);
        for step in 0..steps {
            let routed = Drainage::of(&grid, derived_seed(seed, 3));
            step_forward(&mut grid, &routed, &forces, duration);
            let last = level + 1 == levels && step + 1 == steps;
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
        let is_diagonal =
            cell % grid.side != receiver % grid.side && cell / grid.side != receiver / grid.side;
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

#[cfg(test)]
mod tests {
    use std::sync::LazyLock;

    use super::*;

    /// Cells of 600 m: a sixteenth of the work for what holds at every level.
    const FEW_LEVELS: usize = 4;

    fn eroded() -> &'static ErodedGround {
        static GROUND: LazyLock<ErodedGround> =
            LazyLock::new(|| erode(1, FEW_LEVELS, |_| true).unwrap());
        &GROUND
    }

    #[test]
    fn water_of_every_cell_falls_all_the_way_to_the_border() {
        let ErodedGround { grid, drainage } = eroded();
        for start in 0..grid.heights_m.len() {
            let mut cell = start;
            loop {
                // Steepest descent, with no help of what erosion took for the receivers.
                let lowest = grid.neighbours(cell).min_by(|a, b| {
                    let drop = |(near, distance): &(usize, f32)| {
                        (grid.heights_m[*near] - grid.heights_m[cell]) / distance
                    };
                    drop(a).total_cmp(&drop(b))
                });
                let (next, _) = lowest.unwrap();
                if grid.is_outlet(cell) {
                    break;
                }
                assert!(grid.heights_m[next] < grid.heights_m[cell], "hollow at cell {cell}");
                cell = next;
            }
        }
        for (cell, &receiver) in drainage.receivers.iter().enumerate() {
            let falls = grid.heights_m[receiver as usize] < grid.heights_m[cell];
            assert!(falls || grid.is_outlet(cell), "the stored drainage climbs at cell {cell}");
        }
    }

    #[test]
    fn rivers_come_near_the_balance_of_uplift_and_erosion() {
        let ErodedGround { grid, drainage } = eroded();
        let forces = forces_of(grid, Uplift::new(derived_seed(1, 1)));
        let mut ratios: Vec<f32> = (0..grid.heights_m.len())
            .filter(|&cell| drainage.areas_m2[cell] > 2e7 && forces[cell].steepness_m > 200.0)
            .map(|cell| {
                let receiver = drainage.receivers[cell] as usize;
                let (_, distance) =
                    grid.neighbours(cell).find(|&(near, _)| near == receiver).unwrap();
                let slope = (grid.heights_m[cell] - grid.heights_m[receiver])
                    / (distance * grid.cell_m() as f32);
                slope * drainage.areas_m2[cell].sqrt() / forces[cell].steepness_m
            })
            .collect();
        ratios.sort_by(f32::total_cmp);
        let median = ratios[ratios.len() / 2];
        assert!(ratios.len() > 1_000 && (0.85..1.15).contains(&median), "{median}");
    }

    #[test]
    fn mountains_are_as_high_and_as_steep_as_in_sichuan() {
        let ErodedGround { grid, .. } = eroded();
        let highest_m = grid.heights_m.iter().copied().fold(0.0, f32::max);
        let mean_m = grid.heights_m.iter().sum::<f32>() / grid.heights_m.len() as f32;
        assert!((5_000.0..7_500.0).contains(&highest_m), "{highest_m}");
        assert!((1_800.0..4_000.0).contains(&mean_m), "{mean_m}");
        let plain = grid.heights_m.iter().filter(|&&height_m| height_m < 700.0).count();
        let share = plain as f64 / grid.heights_m.len() as f64;
        assert!((0.05..0.25).contains(&share), "{share} of the ground is plain");
    }

    #[test]
    fn a_seed_is_one_ground_whatever_the_number_of_threads() {
        let on_threads = |count: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build().unwrap();
            pool.install(|| erode(7, 3, |_| true)).unwrap().grid.heights_m
        };
        let heights_m = on_threads(1);
        assert!(heights_m == on_threads(5));
        assert!(heights_m != erode(8, 3, |_| true).unwrap().grid.heights_m);
    }

    #[test]
    fn progress_grows_to_one_and_can_stop_the_work() {
        let mut shares = Vec::new();
        let stopped = erode(1, FEW_LEVELS, |share| {
            shares.push(share);
            shares.len() < 70
        });
        assert!(stopped.is_none() && shares.len() == 70);
        let mut last = 0.0;
        erode(1, 3, |share| {
            assert!(share > last);
            last = share;
            true
        });
        assert!((last - 1.0).abs() < 1e-9);
    }
}
