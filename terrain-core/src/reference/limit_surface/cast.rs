use glam::{DVec2, DVec3, dvec2};

use super::LimitRelief;
use crate::reference::ray_box::part_within_box;

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitHit {
    /// The triangle.
    pub triangle: u32,
    /// Distance along the ray, metres.
    pub distance_m: f64,
    /// The point, metres of the CRS.
    pub point: DVec3,
}

impl LimitRelief {
    /// The first triangle that a ray meets, from above or from below. `direction` is a unit vector.
    ///
    /// The ray walks over the grid, through the largest blocks of cells whose heights it passes over
    /// or under (Tevs, Ihrke and Seidel, "Maximum Mipmaps for Fast, Accurate, and Scalable Dynamic
    /// Height Field Rendering", 2008), and in a cell compares its height with the two planes where it
    /// enters, crosses the diagonal and leaves. Which side of the surface it is on is carried from
    /// cell to cell, so that it cannot slip through between two.
    pub fn first_hit(&self, origin: DVec3, direction: DVec3) -> Option<LimitHit> {
        self.walk(origin, direction, self.pyramid().top_level())
    }

    /// The same by trying every cell along the ray: what the blocks may not change.
    pub fn first_hit_by_cells(&self, origin: DVec3, direction: DVec3) -> Option<LimitHit> {
        self.walk(origin, direction, 0)
    }

    fn walk(&self, origin: DVec3, direction: DVec3, top_level: u32) -> Option<LimitHit> {
        let mut walk = Walk::new(self, origin, direction, top_level)?;
        let (triangle, distance_m) = walk.run()?;
        Some(LimitHit { triangle, distance_m, point: origin + direction * distance_m })
    }
}

/// A ray on its way: x and y in cells east and south of the grid's corner, z in metres, its parameter
/// in metres.
struct Walk<'a> {
    relief: &'a LimitRelief,
    origin: DVec3,
    direction: DVec3,
    top_level: u32,
    level: u32,
    cell: [i32; 2],
    from_m: f64,
    end_m: f64,
    is_above: Option<bool>,
}

impl<'a> Walk<'a> {
    /// `None` where the ray does not come over the grid between its lowest and highest height.
    fn new(
        relief: &'a LimitRelief,
        origin: DVec3,
        direction: DVec3,
        top_level: u32,
    ) -> Option<Self> {
        let grid = relief.grid();
        let per_m = 1.0 / grid.cell_m;
        let corner = grid.origin;
        let local =
            DVec3::new((origin.x - corner.x) * per_m, (corner.y - origin.y) * per_m, origin.z);
        let step = DVec3::new(direction.x * per_m, -direction.y * per_m, direction.z);
        let [lowest_m, highest_m] = relief.pyramid().whole().map(f64::from);
        // A metre of air above and below, so that a ray knows its side before it meets anything.
        let low = DVec3::new(0.0, 0.0, lowest_m - 1.0);
        let high = DVec3::new(f64::from(grid.columns), f64::from(grid.rows), highest_m + 1.0);
        let [from_m, end_m] = part_within_box(local, step, [low, high])
            .filter(|[from_m, end_m]| from_m < end_m && end_m.is_finite())?;
        let place = (local + step * from_m).floor();
        let cell = [
            (place.x as i32).clamp(0, grid.columns as i32 - 1),
            (place.y as i32).clamp(0, grid.rows as i32 - 1),
        ];
        let (level, is_above) = (top_level, None);
        Some(Self {
            relief,
            origin: local,
            direction: step,
            top_level,
            level,
            cell,
            from_m,
            end_m,
            is_above,
        })
    }

    fn run(&mut self) -> Option<(u32, f64)> {
        loop {
            let (to_m, axis) = self.exit();
            if self.level > 0 && !self.passes_block(to_m) {
                self.level -= 1;
                continue;
            }
            if self.level == 0
                && let Some(hit) = self.meet_cell(to_m)
            {
                return Some(hit);
            }
            if to_m >= self.end_m || !self.advance(to_m, axis) {
                return None;
            }
        }
    }

    fn at(&self, t_m: f64) -> DVec3 {
        self.origin + self.direction * t_m
    }

    /// Where the ray leaves the block, and across which axis.
    fn exit(&self) -> (f64, usize) {
        let border_m = |axis: usize| {
            let direction = self.direction[axis];
            if direction == 0.0 {
                return f64::INFINITY;
            }
            let block = (self.cell[axis] >> self.level) + i32::from(direction > 0.0);
            (f64::from(block << self.level) - self.origin[axis]) / direction
        };
        let (x_m, y_m) = (border_m(0), border_m(1));
        let (out_m, axis) = if x_m <= y_m { (x_m, 0) } else { (y_m, 1) };
        (out_m.clamp(self.from_m, self.end_m), axis)
    }

    /// Whether the ray stays above or below everything in the block.
    fn passes_block(&mut self, to_m: f64) -> bool {
        let [column, row] = self.cell;
        let [lowest_m, highest_m] =
            self.relief.pyramid().range(self.level, row, column).map(f64::from);
        let (a, b) = (self.at(self.from_m).z, self.at(to_m).z);
        if lowest_m > highest_m {
            self.is_above = None;
            return true;
        }
        if a.min(b) > highest_m {
            return self.pass(true);
        }
        a.max(b) < lowest_m && self.pass(false)
    }

    /// A ray that went under and comes out over has met the surface: the cells are to say where.
    fn pass(&mut self, is_above: bool) -> bool {
        let stays = self.is_above.is_none_or(|before| before == is_above);
        if stays {
            self.is_above = Some(is_above);
        }
        stays
    }

    fn meet_cell(&mut self, to_m: f64) -> Option<(u32, f64)> {
        let corner = dvec2(f64::from(self.cell[0]), f64::from(self.cell[1]));
        let start = self.origin.truncate() - corner;
        let flat = self.direction.truncate();
        let diagonal_m = (start.y - start.x) / (flat.x - flat.y);
        let half_at = |t_m: f64| {
            let place = start + flat * t_m;
            if place.x >= place.y { 0 } else { 1 }
        };
        if diagonal_m > self.from_m && diagonal_m < to_m {
            let first =
                self.meet_half(half_at(0.5 * (self.from_m + diagonal_m)), self.from_m, diagonal_m);
            return first
                .or_else(|| self.meet_half(half_at(0.5 * (diagonal_m + to_m)), diagonal_m, to_m));
        }
        self.meet_half(half_at(0.5 * (self.from_m + to_m)), self.from_m, to_m)
    }

    fn meet_half(&mut self, half: u32, from_m: f64, to_m: f64) -> Option<(u32, f64)> {
        let [column, row] = self.cell;
        let heights = self.relief.cell(row as u32, column as u32);
        let corner = dvec2(f64::from(column), f64::from(row));
        let above = |t_m: f64| {
            let point = self.at(t_m);
            let place: DVec2 = point.truncate() - corner;
            point.z - heights.height_of_half_m(half, place)
        };
        let (start, end) = (above(from_m), above(to_m));
        if start.is_nan() || end.is_nan() {
            self.is_above = None;
            return None;
        }
        let starts_above = start > 0.0;
        let triangle = 2 * (row as u32 * self.relief.grid().columns + column as u32) + half;
        if self.is_above.is_some_and(|before| before != starts_above) {
            return Some((triangle, from_m));
        }
        self.is_above = Some(starts_above);
        if starts_above != (end > 0.0) {
            return Some((triangle, from_m + (to_m - from_m) * (start / (start - end))));
        }
        None
    }

    /// Goes on to the next block across the border; `false` beyond the grid.
    fn advance(&mut self, to_m: f64, axis: usize) -> bool {
        let other = 1 - axis;
        let grid = self.relief.grid();
        let sizes = [grid.columns as i32, grid.rows as i32];
        let block = self.cell[axis] >> self.level;
        let forward = self.direction[axis] > 0.0;
        let next = if forward { (block + 1) << self.level } else { (block << self.level) - 1 };
        if next < 0 || next >= sizes[axis] {
            return false;
        }
        let first = (self.cell[other] >> self.level) << self.level;
        let last = (first + (1 << self.level) - 1).min(sizes[other] - 1);
        self.cell[axis] = next;
        self.cell[other] = (self.at(to_m)[other].floor() as i32).clamp(first, last);
        self.from_m = to_m;
        // Into another block of the next level: that one may be passed as a whole.
        if self.level < self.top_level && (next >> self.level) >> 1 != block >> 1 {
            self.level += 1;
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::LimitGrid;
    use super::*;

    fn hilly(columns: u32, rows: u32, void_every: usize) -> LimitRelief {
        let grid = LimitGrid { origin: dvec2(500.0, 900.0), cell_m: 3.0, columns, rows };
        let height = |index: usize| {
            let (row, column) = (index / (columns as usize + 1), index % (columns as usize + 1));
            let wave = (0.7 * row as f32).sin() * (0.4 * column as f32).cos();
            let is_void = void_every > 0 && (index * 7919).is_multiple_of(void_every);
            if is_void { f32::NAN } else { 40.0 + 6.0 * wave + ((index * 37) % 11) as f32 * 0.2 }
        };
        LimitRelief::new(grid, (0..grid.node_count()).map(height).collect()).unwrap()
    }

    /// The nearest triangle by trying all of them (Möller and Trumbore, "Fast, Minimum Storage
    /// Ray/Triangle Intersection", 1997).
    fn brute_force(relief: &LimitRelief, origin: DVec3, direction: DVec3) -> Option<(u32, f64)> {
        let meet = |triangle: usize| {
            let [a, b, c] = relief.corners(triangle)?;
            let (ab, ac) = (b - a, c - a);
            let p = direction.cross(ac);
            let scale = 1.0 / ab.dot(p);
            let s = origin - a;
            let (u, q) = (s.dot(p) * scale, s.cross(ab));
            let (v, t) = (direction.dot(q) * scale, ac.dot(q) * scale);
            (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t >= 0.0).then_some((triangle as u32, t))
        };
        let hits = (0..relief.grid().triangle_count()).filter_map(meet);
        hits.min_by(|a, b| a.1.total_cmp(&b.1))
    }

    fn rays() -> impl Strategy<Value = (DVec3, DVec3)> {
        let target = (500.0..560.0, 840.0..900.0, 30.0..50.0);
        let eye = (400.0..660.0, 740.0..1000.0, 20.0..200.0);
        (eye, target).prop_filter_map("the two are apart", |(eye, target)| {
            let (eye, target) = (DVec3::from(eye), DVec3::from(target));
            (target - eye).try_normalize().map(|direction| (eye, direction))
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(400))]

        #[test]
        fn rays_meet_what_trying_all_triangles_finds((eye, direction) in rays(), voids in 0usize..2) {
            let relief = hilly(20, 20, voids * 13);
            let found = relief.first_hit(eye, direction);
            let expected = brute_force(&relief, eye, direction);
            match (found, expected) {
                (Some(hit), Some((triangle, distance_m))) => {
                    prop_assert!((hit.distance_m - distance_m).abs() < 1e-6, "{hit:?}");
                    prop_assert_eq!(hit.triangle, triangle);
                }
                (found, expected) => prop_assert!(found.is_none() && expected.is_none(), "{found:?} {expected:?}"),
            }
        }

        #[test]
        fn skipping_blocks_changes_nothing((eye, direction) in rays(), rows in 1u32..40) {
            let relief = hilly(33, rows, 0);
            let skipping = relief.first_hit(eye, direction);
            let all = relief.first_hit_by_cells(eye, direction);
            prop_assert_eq!(skipping.map(|hit| hit.triangle), all.map(|hit| hit.triangle));
            let apart = skipping.zip(all).map_or(0.0, |(a, b)| (a.distance_m - b.distance_m).abs());
            prop_assert!(apart < 1e-9);
        }
    }

    #[test]
    fn no_ray_slips_through_nodes_edges_or_straight_down() {
        let relief = hilly(20, 20, 0);
        let grid = *relief.grid();
        for (row, column) in (1..20).flat_map(|row| (1..20).map(move |column| (row, column))) {
            let node = grid.node(row, column);
            let height_m = f64::from(relief.heights_m()[grid.node_index(row, column)]);
            let target = node.extend(height_m);
            for offset in [
                DVec3::Z,
                DVec3::new(1.0, 0.0, 2.0),
                DVec3::new(0.0, -1.0, 3.0),
                DVec3::new(1.0, -1.0, 4.0),
            ] {
                let eye = target + 30.0 * offset;
                let hit = relief.first_hit(eye, -offset.normalize()).unwrap();
                // A ridge before the node may be met first; nothing beyond it may.
                assert!(hit.distance_m < 30.0 * offset.length() + 1e-9, "{row} {column} {offset}");
                if offset == DVec3::Z {
                    assert!((hit.point.z - height_m).abs() < 1e-9);
                }
            }
        }
    }

    #[test]
    fn rays_that_miss_or_mean_nothing_meet_nothing() {
        let relief = hilly(20, 20, 0);
        let over = DVec3::new(530.0, 870.0, 100.0);
        assert_eq!(relief.first_hit(over, DVec3::Z), None);
        assert_eq!(relief.first_hit(over, DVec3::X), None);
        assert_eq!(relief.first_hit(DVec3::new(0.0, 0.0, 100.0), DVec3::NEG_Z), None);
        assert_eq!(relief.first_hit(over, DVec3::NAN), None);
        assert_eq!(relief.first_hit(over, DVec3::ZERO), None);
        let from_below = relief.first_hit(DVec3::new(530.0, 870.0, -5.0), DVec3::Z).unwrap();
        assert!((from_below.point.z - relief.height_m(dvec2(530.0, 870.0))).abs() < 1e-9);
    }
}
