//! A way along the floor of a valley.
//!
//! Heights are surveyed on a grid round the highest ground. A cell is the deeper the more it lies below
//! the mean of its surroundings, the topographic position index of A. Weiss, "Topographic position and
//! landforms analysis" (2001). From the deepest cell the cheapest ways lead everywhere (E. W. Dijkstra,
//! "A note on two problems in connexion with graphs", 1959), deep ground being cheap to cross; of those
//! that are long enough the cheapest for its length is flown.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use glam::{DVec2, dvec2};

use super::FlightGround;
use super::forward::keyframe;
use super::height_profile::above_ground;
use crate::measure::{Flight, FlightError};

/// Cells a side of the survey.
const SIDE: usize = 96;
/// Side of the surveyed window: in parts of the dataset's shorter side, and at the most in clearances.
const WINDOW: f64 = 0.8;
const WINDOW_CLEARANCES: f64 = 75.0;
/// Cells on each side that count as the surroundings of a cell.
const SURROUNDINGS: usize = 8;
/// Length of the flight in sides of the window.
const LENGTH: f64 = 0.5;
const FLIGHT_S: u32 = 20;
const KEYFRAMES_A_SECOND: u32 = 4;
/// Seconds that the eye looks ahead along the valley.
const AHEAD_S: f64 = 1.5;
const PITCH_DEG: f64 = -6.0;
/// Times that the corners of the way over the grid are rounded off.
const ROUNDS: usize = 6;

/// The flight along a valley near the highest ground.
pub(super) fn along(ground: &FlightGround) -> Result<Flight, FlightError> {
    let survey = Survey::of(ground);
    let floor = Way::new(rounded(survey.valley_floor()));
    let duration_s = f64::from(FLIGHT_S);
    let steps = FLIGHT_S * KEYFRAMES_A_SECOND;
    let keyframes = (0..=steps).map(|step| {
        let t = f64::from(step) / f64::from(KEYFRAMES_A_SECOND);
        let place = floor.at(t / duration_s);
        // At the end the eye keeps looking the way it came.
        let ahead = floor.at((t + AHEAD_S) / duration_s) - floor.at((t - AHEAD_S) / duration_s);
        keyframe(t, place, ahead, PITCH_DEG)
    });
    above_ground(ground, keyframes.collect(), ground.low_clearance_m())
}

/// Heights on a square grid, and how deep each cell lies below its surroundings.
struct Survey {
    corner: DVec2,
    cell_m: f64,
    depths_m: Vec<f64>,
}

impl Survey {
    fn of(ground: &FlightGround) -> Self {
        let side_m = (WINDOW * ground.side_m()).min(WINDOW_CLEARANCES * ground.low_clearance_m());
        let extent = ground.extent;
        let corner = ground.summit().truncate() - 0.5 * side_m;
        let corner = corner.clamp(extent.min, extent.max - side_m);
        let cell_m = side_m / SIDE as f64;
        let heights = (0..SIDE * SIDE)
            .map(|cell| ground.about_m(centre(corner, cell_m, cell), cell_m))
            .collect::<Vec<_>>();
        let depths_m = (0..SIDE * SIDE).map(|cell| depth_m(&heights, cell)).collect();
        Self { corner, cell_m, depths_m }
    }

    /// The places of a way along the valley's floor.
    fn valley_floor(&self) -> Vec<DVec2> {
        let deepest = (0..SIDE * SIDE)
            .max_by(|&a, &b| self.depths_m[a].total_cmp(&self.depths_m[b]))
            .unwrap_or(0);
        let ways = self.cheapest_ways(deepest);
        let wanted = LENGTH * SIDE as f64;
        let price = |end: &usize| ways[*end].cost / ways[*end].length;
        let long_enough = (0..SIDE * SIDE).filter(|&end| ways[end].length >= wanted);
        let end = long_enough.min_by(|a, b| price(a).total_cmp(&price(b))).unwrap_or(deepest);
        let back = std::iter::successors(Some(end), |&cell| ways[cell].from);
        let mut floor = back.map(|cell| centre(self.corner, self.cell_m, cell)).collect::<Vec<_>>();
        floor.reverse();
        floor
    }

    fn cheapest_ways(&self, start: usize) -> Vec<Reached> {
        let square_sum = self.depths_m.iter().map(|depth| depth * depth).sum::<f64>();
        // Ground without any relief costs the same everywhere.
        let typical_m = (square_sum / self.depths_m.len() as f64).sqrt().max(f64::MIN_POSITIVE);
        let price = |cell: usize| (-self.depths_m[cell] / typical_m).exp();
        let mut ways = vec![Reached { cost: f64::INFINITY, length: 0.0, from: None }; SIDE * SIDE];
        ways[start].cost = 0.0;
        let mut open = BinaryHeap::from([Open { cost: 0.0, cell: start }]);
        while let Some(Open { cost, cell }) = open.pop() {
            if cost > ways[cell].cost {
                continue;
            }
            for (next, step) in neighbours(cell) {
                let cost = cost + step * 0.5 * (price(cell) + price(next));
                if cost < ways[next].cost {
                    let length = ways[cell].length + step;
                    ways[next] = Reached { cost, length, from: Some(cell) };
                    open.push(Open { cost, cell: next });
                }
            }
        }
        ways
    }
}

/// The cheapest way to a cell: its cost, its length in cells and the cell before.
#[derive(Clone, Copy)]
struct Reached {
    cost: f64,
    length: f64,
    from: Option<usize>,
}

/// A cell whose neighbours are to be looked at, the cheapest first.
struct Open {
    cost: f64,
    cell: usize,
}

impl Ord for Open {
    fn cmp(&self, other: &Self) -> Ordering {
        // Equal costs in order of the cells: the same way on every run.
        other.cost.total_cmp(&self.cost).then(other.cell.cmp(&self.cell))
    }
}

impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Open {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Open {}

fn centre(corner: DVec2, cell_m: f64, cell: usize) -> DVec2 {
    corner + cell_m * (dvec2((cell % SIDE) as f64, (cell / SIDE) as f64) + 0.5)
}

/// How far the cell lies below the mean of its surroundings.
fn depth_m(heights: &[f64], cell: usize) -> f64 {
    let around =
        |place: usize| place.saturating_sub(SURROUNDINGS)..=(place + SURROUNDINGS).min(SIDE - 1);
    let (columns, rows) = (around(cell % SIDE), around(cell / SIDE));
    let count = (columns.clone().count() * rows.clone().count()) as f64;
    let sum = rows.map(|row| {
        let row = row * SIDE;
        heights[row + columns.start()..=row + columns.end()].iter().sum::<f64>()
    });
    sum.sum::<f64>() / count - heights[cell]
}

/// The up to eight cells round a cell and how far they are, in cells.
fn neighbours(cell: usize) -> impl Iterator<Item = (usize, f64)> {
    let (column, row) = (cell % SIDE, cell / SIDE);
    (0..9).filter_map(move |number| {
        let (column, row) =
            ((column + number % 3).wrapping_sub(1), (row + number / 3).wrapping_sub(1));
        let is_other = number != 4 && column < SIDE && row < SIDE;
        let step = if number % 2 == 0 { std::f64::consts::SQRT_2 } else { 1.0 };
        is_other.then(|| (row * SIDE + column, step))
    })
}

/// The places with the corners between them rounded off; the ends stay.
fn rounded(mut places: Vec<DVec2>) -> Vec<DVec2> {
    for _ in 0..ROUNDS {
        let before = places.clone();
        for (place, around) in places.iter_mut().skip(1).zip(before.windows(3)) {
            *place = 0.25 * (around[0] + 2.0 * around[1] + around[2]);
        }
    }
    places
}

/// A line from place to place.
struct Way {
    places: Vec<DVec2>,
    /// Metres from the first place to each.
    lengths_m: Vec<f64>,
}

impl Way {
    fn new(places: Vec<DVec2>) -> Self {
        let steps = places.windows(2).map(|pair| pair[0].distance(pair[1]));
        let sum = |sum: &mut f64, step: f64| {
            *sum += step;
            Some(*sum)
        };
        let lengths_m = std::iter::once(0.0).chain(steps.scan(0.0, sum)).collect();
        Self { places, lengths_m }
    }

    /// The place at a part (0..=1) of the length.
    fn at(&self, part: f64) -> DVec2 {
        let last = self.places.len() - 1;
        let way_m = part.clamp(0.0, 1.0) * self.lengths_m[last];
        let next = self.lengths_m.partition_point(|length| *length <= way_m).clamp(1, last.max(1));
        let (from, to) = (next - 1, next.min(last));
        let step_m = self.lengths_m[to] - self.lengths_m[from];
        let part = if step_m > 0.0 { (way_m - self.lengths_m[from]) / step_m } else { 0.0 };
        self.places[from].lerp(self.places[to], part)
    }
}
