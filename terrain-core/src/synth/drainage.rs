use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

use rayon::prelude::*;

use super::grid::HeightGrid;
use super::noise::{hash, unit};

/// Metres by which a filled hollow rises from cell to cell, so that it drains.
const FILL_RISE_M: f32 = 0.01;

/// Where water goes from every cell.
#[derive(Clone, Debug)]
pub struct Drainage {
    /// The cell that a cell's water flows to; itself for those where it leaves the ground.
    pub receivers: Vec<u32>,
    /// Every cell, each after the one that receives its water.
    pub upstream_order: Vec<u32>,
    /// Area that drains through a cell, its own included, in square metres.
    pub areas_m2: Vec<f32>,
}

impl Drainage {
    /// Drainage along the steepest way down.
    ///
    /// Steepness is perturbed a little by the seed: among eight directions of equal standing, streams
    /// would run straight for kilometres. Cells without a lower neighbour keep their water;
    /// [`fill_hollows`] leaves none.
    pub fn of(grid: &HeightGrid, seed: u32) -> Self {
        let receivers = receivers_of(grid, seed);
        let upstream_order = upstream_order_of(&receivers);
        let cell_m2 = (grid.cell_m() * grid.cell_m()) as f32;
        let mut areas_m2 = vec![cell_m2; receivers.len()];
        for &cell in upstream_order.iter().rev() {
            let receiver = receivers[cell as usize];
            if receiver != cell {
                areas_m2[receiver as usize] += areas_m2[cell as usize];
            }
        }
        Self { receivers, upstream_order, areas_m2 }
    }
}

fn receivers_of(grid: &HeightGrid, seed: u32) -> Vec<u32> {
    let receiver_of = |cell: usize| {
        if grid.is_outlet(cell) {
            return cell as u32;
        }
        let height_m = grid.heights_m[cell];
        let (mut steepest, mut receiver) = (0.0, cell);
        for (neighbour, distance) in grid.neighbours(cell) {
            let drop_m = height_m - grid.heights_m[neighbour];
            if drop_m > 0.0 {
                let ease = 0.8 + 0.4 * unit(hash(cell as i32, neighbour as i32, seed));
                let slope = ease * drop_m / distance;
                if slope > steepest {
                    (steepest, receiver) = (slope, neighbour);
                }
            }
        }
        receiver as u32
    };
    (0..grid.heights_m.len()).into_par_iter().map(receiver_of).collect()
}

/// The order of J. Braun and S. Willett, "A very efficient O(n), implicit and parallel method to solve
/// the stream power equation governing fluvial incision and landscape evolution", 2013: from where
/// water leaves, up every tree of streams.
fn upstream_order_of(receivers: &[u32]) -> Vec<u32> {
    let mut first_donor = vec![0_u32; receivers.len() + 1];
    let donors = || receivers.iter().enumerate().filter(|&(cell, &to)| cell as u32 != to);
    for (_, &receiver) in donors() {
        first_donor[receiver as usize + 1] += 1;
    }
    for cell in 0..receivers.len() {
        first_donor[cell + 1] += first_donor[cell];
    }
    let mut next_free = first_donor.clone();
    let mut donor_list = vec![0_u32; first_donor[receivers.len()] as usize];
    for (cell, &receiver) in donors() {
        let slot = &mut next_free[receiver as usize];
        donor_list[*slot as usize] = cell as u32;
        *slot += 1;
    }
    let mut order = Vec::with_capacity(receivers.len());
    let mut open: Vec<u32> = (0..receivers.len() as u32)
        .rev()
        .filter(|&cell| receivers[cell as usize] == cell)
        .collect();
    while let Some(cell) = open.pop() {
        order.push(cell);
        let range = first_donor[cell as usize] as usize..first_donor[cell as usize + 1] as usize;
        open.extend(&donor_list[range]);
    }
    order
}

/// Raises hollows until every cell has a way down to an outlet.
///
/// R. Barnes, C. Lehman and D. Mulla, "Priority-flood: An optimal depression-filling and
/// watershed-labeling algorithm for digital elevation models", 2014: the ground is flooded from its
/// outlets, lowest cells first; cells in hollows do not have to be sorted. Heights must not be
/// negative.
pub fn fill_hollows(grid: &mut HeightGrid) {
    // Bits of floats that are not negative sort as the floats do.
    let key = |height_m: f32, cell: usize| Reverse((height_m.to_bits(), cell as u32));
    let mut seen = vec![false; grid.heights_m.len()];
    let mut shore = BinaryHeap::new();
    let mut hollow = VecDeque::new();
    for cell in (0..seen.len()).filter(|&cell| grid.is_outlet(cell)) {
        seen[cell] = true;
        shore.push(key(grid.heights_m[cell], cell));
    }
    loop {
        let next = hollow.pop_front();
        let Some(cell) = next.or_else(|| shore.pop().map(|Reverse((_, cell))| cell as usize))
        else {
            return;
        };
        let level_m = grid.heights_m[cell] + FILL_RISE_M;
        for (neighbour, _) in grid.neighbours(cell) {
            if std::mem::replace(&mut seen[neighbour], true) {
                continue;
            }
            if grid.heights_m[neighbour] <= level_m {
                grid.heights_m[neighbour] = level_m;
                hollow.push_back(neighbour);
            } else {
                shore.push(key(grid.heights_m[neighbour], neighbour));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIDE: usize = 40;

    fn rough_grid(seed: u32) -> HeightGrid {
        let height_m = |cell: usize| 100.0 + 80.0 * unit(hash(cell as i32, 0, seed));
        HeightGrid { side: SIDE, heights_m: (0..SIDE * SIDE).map(height_m).collect() }
    }

    /// Lowest level at which water of every cell can leave, by relaxing until nothing changes.
    fn spill_levels_m(grid: &HeightGrid) -> Vec<f32> {
        let start = |cell: usize| match grid.is_outlet(cell) {
            true => grid.heights_m[cell],
            false => f32::INFINITY,
        };
        let mut levels_m: Vec<f32> = (0..SIDE * SIDE).map(start).collect();
        loop {
            let before = levels_m.clone();
            for cell in (0..SIDE * SIDE).filter(|&cell| !grid.is_outlet(cell)) {
                let around = grid.neighbours(cell).map(|(near, _)| levels_m[near]);
                levels_m[cell] = around.fold(f32::INFINITY, f32::min).max(grid.heights_m[cell]);
            }
            if levels_m == before {
                return levels_m;
            }
        }
    }

    #[test]
    fn hollows_are_filled_to_where_they_spill_and_drain() {
        for seed in 0..5 {
            let rough = rough_grid(seed);
            let mut filled = rough.clone();
            fill_hollows(&mut filled);
            let most_rise_m = FILL_RISE_M * (SIDE * SIDE) as f32;
            for (cell, level_m) in spill_levels_m(&rough).into_iter().enumerate() {
                let over_m = filled.heights_m[cell] - level_m;
                assert!((0.0..=most_rise_m).contains(&over_m), "{over_m} m at cell {cell}");
                let is_lower = |near| filled.heights_m[near] < filled.heights_m[cell];
                let drains = filled.neighbours(cell).any(|(near, _)| is_lower(near));
                assert!(drains || filled.is_outlet(cell), "cell {cell} of seed {seed}");
            }
        }
    }

    #[test]
    fn areas_are_those_of_the_cells_whose_water_comes_by() {
        let mut grid = rough_grid(9);
        fill_hollows(&mut grid);
        let drainage = Drainage::of(&grid, 3);
        let mut visits = vec![0.0; SIDE * SIDE];
        for start in 0..SIDE * SIDE {
            let mut cell = start;
            visits[cell] += 1.0;
            while drainage.receivers[cell] as usize != cell {
                cell = drainage.receivers[cell] as usize;
                visits[cell] += 1.0;
            }
            assert!(grid.is_outlet(cell));
        }
        let cell_m2 = grid.cell_m() * grid.cell_m();
        for (area_m2, visits) in drainage.areas_m2.iter().zip(visits) {
            assert!((f64::from(*area_m2) / cell_m2 / visits - 1.0).abs() < 1e-3);
        }
    }

    #[test]
    fn the_order_puts_every_cell_after_its_receiver() {
        let mut grid = rough_grid(4);
        fill_hollows(&mut grid);
        let drainage = Drainage::of(&grid, 3);
        let mut place = vec![usize::MAX; SIDE * SIDE];
        for (index, &cell) in drainage.upstream_order.iter().enumerate() {
            place[cell as usize] = index;
        }
        assert!(!place.contains(&usize::MAX), "every cell is in the order");
        for (cell, &receiver) in drainage.receivers.iter().enumerate() {
            assert!(place[receiver as usize] <= place[cell]);
        }
    }
}
