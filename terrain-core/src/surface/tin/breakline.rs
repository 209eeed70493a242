//! Lines that triangles must not cross: ridges, shores, walls.

use glam::{DVec2, dvec2};

use super::SampleGrid;

/// A line along which the ground may bend sharply: its pieces become edges of triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Breakline {
    /// The line's points, in order.
    pub points: Vec<BreaklinePoint>,
}

/// A point of a [`Breakline`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BreaklinePoint {
    /// Where it lies, in the dataset's CRS.
    pub position: DVec2,
    /// Its height in metres; `None` takes the ground's.
    pub height_m: Option<f64>,
}

/// A place on a breakline: how far along its piece (0 to 1), and where in samples.
pub type LinePlace = (f64, DVec2);

/// The parts of a piece that lie on ground that holds data, each from end to end, cut where they pass
/// through samples. Ends on the border of that ground lie exactly on its row or column of samples: a line that
/// misses a sample or the border by rounding would make triangles without area.
pub fn ground_parts(grid: &SampleGrid<'_>, from: DVec2, to: DVec2) -> Vec<[LinePlace; 2]> {
    let max = dvec2((grid.columns - 1) as f64, (grid.rows - 1) as f64);
    let Some([enter, leave]) = part_within(from, to, DVec2::ZERO, max) else { return Vec::new() };
    let at = |part: f64| (part, snapped(from.lerp(to, part)).clamp(DVec2::ZERO, max));
    let mut places = vec![at(enter), at(leave)];
    for axis in 0..2 {
        let (start, end) = (places[0].1[axis], places[1].1[axis]);
        for line in start.min(end).ceil() as usize..=start.max(end).floor() as usize {
            let part = (line as f64 - from[axis]) / (to[axis] - from[axis]);
            if !(enter..=leave).contains(&part) {
                continue;
            }
            let mut place = from.lerp(to, part);
            place[axis] = line as f64;
            let place = snapped(place).clamp(DVec2::ZERO, max);
            let is_sample = place == place.round();
            if is_sample || is_on_border(grid, place) {
                places.push((part, place));
            }
        }
    }
    places.sort_by(|a, b| a.0.total_cmp(&b.0));
    places.dedup_by(|a, b| a.1 == b.1);
    let pairs = places.windows(2).map(|pair| [pair[0], pair[1]]);
    pairs.filter(|[a, b]| grid.bilinear_m(a.1.midpoint(b.1)).is_some()).collect()
}

/// Whether cells that hold data and cells that do not meet at a place on a row or column of samples.
fn is_on_border(grid: &SampleGrid<'_>, place: DVec2) -> bool {
    let sides = |coordinate: f64| [coordinate.ceil() as i64 - 1, coordinate.floor() as i64];
    let [columns, rows] = [sides(place.x), sides(place.y)];
    let is_held = |column: usize, row: usize| grid.is_cell_held(columns[column], rows[row]);
    let first = is_held(0, 0);
    [is_held(1, 0), is_held(0, 1), is_held(1, 1)].iter().any(|held| *held != first)
}

/// A place as close to a row or column of samples as rounding may bring it lies on it.
fn snapped(place: DVec2) -> DVec2 {
    const SNAP: f64 = 1e-6;
    let nearest = place.round();
    DVec2::select((place - nearest).abs().cmplt(DVec2::splat(SNAP)), nearest, place)
}

/// The part of a piece from `from` to `to` within a rectangle, as parts of the way; `None` where it
/// stays outside or has no length (Y.-D. Liang and B. Barsky, "A New Concept and Method for Line Clipping",
/// 1984).
fn part_within(from: DVec2, to: DVec2, min: DVec2, max: DVec2) -> Option<[f64; 2]> {
    let way = to - from;
    if !(way.is_finite() && from.is_finite()) || way == DVec2::ZERO {
        return None;
    }
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for axis in 0..2 {
        if way[axis] == 0.0 {
            if from[axis] < min[axis] || from[axis] > max[axis] {
                return None;
            }
            continue;
        }
        let sides = [min[axis], max[axis]].map(|side| (side - from[axis]) / way[axis]);
        enter = enter.max(sides[0].min(sides[1]));
        leave = leave.min(sides[0].max(sides[1]));
    }
    (enter < leave).then_some([enter, leave])
}
