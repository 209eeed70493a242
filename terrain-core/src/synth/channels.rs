use glam::{DVec2, Vec2};

use super::erosion::ErodedGround;
use super::grid::HeightGrid;
use super::noise::{fractal_noise, hash, mixed, smooth_step, unit_pair};

/// Least area that a stream with a bed of its own drains, in square metres.
const LEAST_AREA_M2: f32 = 1.5e6;
const NO_NODE: u32 = u32::MAX;

/// The beds of all streams, as lines from cell to cell, and quick answers to which of them are near.
#[derive(Debug)]
pub struct Channels {
    cell_m: f64,
    side: usize,
    reaches: Vec<Reach>,
    /// Reaches that matter in cell c: `listed[first[c]..first[c + 1]]`.
    first: Vec<u32>,
    listed: Vec<u32>,
}

/// A straight piece of a stream.
#[derive(Clone, Copy, Debug)]
struct Reach {
    /// Upper end, metres east and south of the ground's corner.
    start_m: DVec2,
    /// From the upper to the lower end.
    along_m: Vec2,
    /// Height of the water at the upper and the lower end.
    level_m: [f32; 2],
    /// Half the width of the water, and of the flat ground it runs through.
    water_m: f32,
    floor_m: f32,
    /// Width of the slope on either side that leans towards the floor.
    foot_m: f32,
}

/// What streams do to a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChannelEffect {
    /// Height in metres, at most the one before.
    pub height_m: f32,
    /// 1 on the floor of a valley, 0 away from it.
    pub floor: f32,
    /// Metres from the edge of the nearest water, negative in it; [`ChannelEffect::FAR_M`] where
    /// there is none near.
    pub to_water_m: f32,
}

impl ChannelEffect {
    /// Farther than any stream reaches.
    pub const FAR_M: f32 = 10_000.0;
}

impl Channels {
    /// The streams of an eroded ground.
    pub fn of(ground: &ErodedGround, seed: u32) -> Self {
        let nodes = Nodes::of(ground);
        let reaches = nodes.reaches(ground, seed);
        let (side, cell_m) = (ground.grid.side, ground.grid.cell_m());
        let (first, listed) = listed_by_cell(&reaches, side, cell_m);
        Self { cell_m, side, reaches, first, listed }
    }

    /// What the streams near a place make of a height there.
    pub fn effect(&self, place_m: DVec2, height_m: f32) -> ChannelEffect {
        let mut effect = ChannelEffect { height_m, floor: 0.0, to_water_m: ChannelEffect::FAR_M };
        for reach in self.near(place_m) {
            let (distance_m, level_m) = reach.nearest(place_m);
            let t = ((distance_m - reach.floor_m) / reach.foot_m).clamp(0.0, 1.0);
            let carved_m = mixed(level_m, height_m, t * (2.0 - t));
            effect.height_m = effect.height_m.min(carved_m);
            effect.floor = effect.floor.max(1.0 - t);
            effect.to_water_m = effect.to_water_m.min(distance_m - reach.water_m);
        }
        effect
    }

    /// Metres from the edge of the nearest water, as in [`ChannelEffect`].
    pub fn to_water_m(&self, place_m: DVec2) -> f32 {
        let distances = self.near(place_m).map(|reach| reach.nearest(place_m).0 - reach.water_m);
        distances.fold(ChannelEffect::FAR_M, f32::min)
    }

    fn near(&self, place_m: DVec2) -> impl Iterator<Item = &Reach> {
        let cell = (place_m / self.cell_m).floor().as_uvec2().as_usizevec2();
        let inside = cell.x < self.side && cell.y < self.side;
        let range = if inside {
            let cell = cell.y * self.side + cell.x;
            self.first[cell] as usize..self.first[cell + 1] as usize
        } else {
            0..0
        };
        self.listed[range].iter().map(|&reach| &self.reaches[reach as usize])
    }
}

impl Reach {
    fn new(ends_m: [DVec2; 2], level_m: [f32; 2], area_m2: f32, seed: u32) -> Self {
        let along_m = (ends_m[1] - ends_m[0]).as_vec2();
        let root_area_km = (area_m2 * 1e-6).sqrt();
        let fall = (level_m[0] - level_m[1]) / along_m.length().max(1.0);
        let gentleness = 1.0 / (1.0 + (fall / 0.02) * (fall / 0.02));
        // Small streams run under trees, too narrow to be seen.
        let water_m = (0.85 * root_area_km - 2.5).min(2.0 * root_area_km - 14.0);
        // Valleys narrow and widen along their way.
        let width = 1.0 + fractal_noise(ends_m[0] / 4_000.0, 3, seed);
        let floor_m =
            water_m.max(0.0) + 4.0 + width * gentleness * (8.0 + 5.0 * root_area_km).min(420.0);
        let foot_m = 120.0 + 0.8 * floor_m;
        Self { start_m: ends_m[0], along_m, level_m, water_m, floor_m, foot_m }
    }

    /// Distance to the line, and the water's level at the nearest place of it.
    ///
    /// Above its upper end the level goes on rising: a floor is wide, and its part beside the next
    /// piece upstream must not be dug to the level down here.
    fn nearest(&self, place_m: DVec2) -> (f32, f32) {
        let to_place = (place_m - self.start_m).as_vec2();
        let length_squared = self.along_m.length_squared().max(1e-6);
        let share = (to_place.dot(self.along_m) / length_squared).min(1.0);
        let distance_m = to_place.distance(share.max(0.0) * self.along_m);
        (distance_m, mixed(self.level_m[0], self.level_m[1], share))
    }

    fn reach_m(&self) -> f64 {
        f64::from(self.floor_m + self.foot_m)
    }
}

/// The cells that streams run through.
struct Nodes {
    /// Cells of the nodes, every one after the one below it.
    cells: Vec<u32>,
    /// Node of a cell.
    node_of: Vec<u32>,
    places_m: Vec<DVec2>,
    levels_m: Vec<f32>,
}

impl Nodes {
    fn of(ground: &ErodedGround) -> Self {
        let (grid, drainage) = (&ground.grid, &ground.drainage);
        let is_stream = |&&cell: &&u32| drainage.areas_m2[cell as usize] >= LEAST_AREA_M2;
        let cells: Vec<u32> = drainage.upstream_order.iter().filter(is_stream).copied().collect();
        let mut node_of = vec![NO_NODE; grid.heights_m.len()];
        for (node, &cell) in cells.iter().enumerate() {
            node_of[cell as usize] = node as u32;
        }
        let places_m = cells.iter().map(|&cell| shifted_centre_m(grid, cell as usize)).collect();
        let levels_m = cells.iter().map(|&cell| grid.heights_m[cell as usize]).collect();
        let mut nodes = Self { cells, node_of, places_m, levels_m };
        for _ in 0..3 {
            nodes.smooth(ground);
        }
        nodes.lower(ground);
        nodes
    }

    fn below(&self, ground: &ErodedGround, node: usize) -> usize {
        let receiver = ground.drainage.receivers[self.cells[node] as usize];
        self.node_of[receiver as usize] as usize
    }

    /// Draws every stream between its neighbours, so that it bends instead of turning by 45 degrees.
    fn smooth(&mut self, ground: &ErodedGround) {
        let mut main_donor = vec![NO_NODE; self.cells.len()];
        let area_m2 = |node: usize| ground.drainage.areas_m2[self.cells[node] as usize];
        for node in 0..self.cells.len() {
            let below = self.below(ground, node);
            let donor = &mut main_donor[below];
            if below != node && (*donor == NO_NODE || area_m2(*donor as usize) < area_m2(node)) {
                *donor = node as u32;
            }
        }
        let (places_m, levels_m) = (self.places_m.clone(), self.levels_m.clone());
        for (node, &donor) in main_donor.iter().enumerate() {
            let below = self.below(ground, node);
            if donor == NO_NODE || below == node {
                continue;
            }
            let donor = donor as usize;
            self.places_m[node] = 0.5 * places_m[node] + 0.25 * (places_m[donor] + places_m[below]);
            self.levels_m[node] = 0.5 * levels_m[node] + 0.25 * (levels_m[donor] + levels_m[below]);
        }
    }

    /// Lets every stream lie no higher than the ground and fall all its way down.
    fn lower(&mut self, ground: &ErodedGround) {
        for (level_m, &place_m) in self.levels_m.iter_mut().zip(&self.places_m) {
            *level_m = level_m.min(ground.grid.smooth_height(place_m).0);
        }
        for node in (0..self.cells.len()).rev() {
            let below = self.below(ground, node);
            self.levels_m[below] = self.levels_m[below].min(self.levels_m[node]);
        }
    }

    fn reaches(&self, ground: &ErodedGround, seed: u32) -> Vec<Reach> {
        let reach_of = |node: usize| {
            let below = self.below(ground, node);
            let ends_m = [self.places_m[node], self.places_m[below]];
            let area_m2 = ground.drainage.areas_m2[self.cells[node] as usize];
            let reach =
                Reach::new(ends_m, [self.levels_m[node], self.levels_m[below]], area_m2, seed);
            (below != node).then_some(reach)
        };
        (0..self.cells.len()).filter_map(reach_of).collect()
    }
}

/// A place in the cell that is not its very centre, so that streams do not follow the grid.
fn shifted_centre_m(grid: &HeightGrid, cell: usize) -> DVec2 {
    let shift = unit_pair(hash(cell as i32, 0, 0x5eed)) - 0.5;
    grid.centre_m(cell) + 0.7 * grid.cell_m() * shift.as_dvec2()
}

/// For every cell the reaches whose effect may touch it.
fn listed_by_cell(reaches: &[Reach], side: usize, cell_m: f64) -> (Vec<u32>, Vec<u32>) {
    let mut first = vec![0_u32; side * side + 1];
    let each = |visit: &mut dyn FnMut(usize, u32)| {
        for (index, reach) in reaches.iter().enumerate() {
            for cell in cells_near(reach, side, cell_m) {
                visit(cell, index as u32);
            }
        }
    };
    each(&mut |cell, _| first[cell + 1] += 1);
    for cell in 0..side * side {
        first[cell + 1] += first[cell];
    }
    let mut next_free = first.clone();
    let mut listed = vec![0_u32; first[side * side] as usize];
    each(&mut |cell, reach| {
        listed[next_free[cell] as usize] = reach;
        next_free[cell] += 1;
    });
    (first, listed)
}

fn cells_near(reach: &Reach, side: usize, cell_m: f64) -> impl Iterator<Item = usize> {
    let end_m = reach.start_m + reach.along_m.as_dvec2();
    let cell_at = |corner_m: DVec2| {
        let cell = (corner_m / cell_m).floor().max(DVec2::ZERO).as_uvec2().as_usizevec2();
        cell.min(glam::USizeVec2::splat(side - 1))
    };
    let low = cell_at(reach.start_m.min(end_m) - reach.reach_m());
    let high = cell_at(reach.start_m.max(end_m) + reach.reach_m());
    // Half a cell's diagonal more than the reach touches the cell.
    let touched_m = reach.reach_m() + 0.708 * cell_m;
    let reach = *reach;
    (low.y..=high.y).flat_map(move |y| (low.x..=high.x).map(move |x| (x, y))).filter_map(
        move |(x, y)| {
            let centre_m = (DVec2::new(x as f64, y as f64) + 0.5) * cell_m;
            (f64::from(reach.nearest(centre_m).0) <= touched_m).then_some(y * side + x)
        },
    )
}

/// How much a place belongs to a valley's floor: all within, nothing a foot's width away.
pub fn floor_weight(floor: f32) -> f32 {
    smooth_step(0.55, 1.0, floor)
}

#[cfg(test)]
mod tests {
    use super::super::erosion::erode;
    use super::*;

    #[test]
    fn streams_fall_all_their_way_and_lie_in_the_ground() {
        let ground = erode(1, 3, |_| true).unwrap();
        let nodes = Nodes::of(&ground);
        assert!(nodes.cells.len() > 1_000);
        for node in 0..nodes.cells.len() {
            assert!(nodes.levels_m[nodes.below(&ground, node)] <= nodes.levels_m[node]);
            let (surface_m, _) = ground.grid.smooth_height(nodes.places_m[node]);
            assert!(nodes.levels_m[node] <= surface_m);
        }
    }

    #[test]
    fn beds_are_carved_to_the_level_of_their_stream_and_no_deeper() {
        let ground = erode(1, 3, |_| true).unwrap();
        let channels = Channels::of(&ground, 1);
        for reach in channels.reaches.iter().step_by(7) {
            let middle_m = reach.start_m + 0.5 * reach.along_m.as_dvec2();
            let (base_m, _) = ground.grid.smooth_height(middle_m);
            let effect = channels.effect(middle_m, base_m);
            let level_m = 0.5 * (reach.level_m[0] + reach.level_m[1]);
            assert!(effect.height_m <= level_m.min(base_m) + 0.01);
            assert_eq!(effect.floor, 1.0);
            assert!(effect.to_water_m <= -reach.water_m + 0.01);
        }
    }

    #[test]
    fn what_is_listed_for_a_cell_is_all_that_reaches_into_it() {
        let ground = erode(1, 3, |_| true).unwrap();
        let channels = Channels::of(&ground, 1);
        for index in 0..400 {
            let place_m =
                DVec2::new(f64::from(index % 20), f64::from(index / 20)) * 14_399.0 + 50.0;
            let (base_m, _) = ground.grid.smooth_height(place_m);
            let is_near = |reach: &&Reach| f64::from(reach.nearest(place_m).0) < reach.reach_m();
            let expected = channels.reaches.iter().filter(is_near).count();
            let listed = channels.near(place_m).filter(is_near).count();
            assert_eq!(listed, expected, "at {place_m}");
            let effect = channels.effect(place_m, base_m);
            assert!(effect.height_m <= base_m && (0.0..=1.0).contains(&effect.floor));
        }
    }
}
