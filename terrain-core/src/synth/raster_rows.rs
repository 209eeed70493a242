use glam::{Vec2, vec2};
use rayon::prelude::*;

use super::ground::{Ground, GroundPoint};
use super::land_cover::{CoverPoint, LandCover};
use super::noise::derived_seed;
use super::preset::{COLOURS_PER_HEIGHT, HEIGHT_CELL_M, Preset};

/// Height cells beyond the border that colours need: one to lie between, one more for its slope.
const RIM: usize = 2;

/// The rasters of a preset, row by row from the north, in bands of rows.
///
/// The ground is evaluated once at the centre of every height cell; colours follow the values between
/// centres, and add texture finer than those.
pub struct RasterRows<'a> {
    ground: &'a Ground,
    cover: LandCover,
    preset: Preset,
    /// Rows of the ground, `RIM` cells wider than the raster on every side.
    rows: Vec<GroundPoint>,
    /// The raster's row that the first of `rows` stands for.
    first_row: isize,
}

impl<'a> RasterRows<'a> {
    /// The rasters of a preset on the ground of a seed.
    pub fn new(ground: &'a Ground, preset: Preset, seed: u32) -> Self {
        let cover = LandCover::new(derived_seed(seed, 50));
        Self { ground, cover, preset, rows: Vec::new(), first_row: -(RIM as isize) }
    }

    /// Makes the band of `count` rows of heights from `row` on, and three times as many of colours, the
    /// current one. Bands have to follow one another from row 0 on.
    pub fn advance(&mut self, row: usize, count: usize) {
        let first_row = row as isize - RIM as isize;
        let passed = (first_row - self.first_row) as usize * self.width();
        self.rows.drain(..passed.min(self.rows.len()));
        self.first_row = first_row;
        let known = self.rows.len() / self.width();
        let missing = first_row + known as isize..(row + count + RIM) as isize;
        let width = self.width() as isize;
        let places = missing.start * width..missing.end * width;
        let points = places.into_par_iter().map(|place| {
            self.ground_at(place.div_euclid(width), place.rem_euclid(width) - RIM as isize)
        });
        let points: Vec<GroundPoint> = points.collect();
        self.rows.extend(points);
    }

    /// Heights of `count` rows of the current band in whole metres, as stored.
    pub fn heights(&self, row: usize, count: usize) -> Vec<i16> {
        let side = self.preset.heights_side;
        let places = (row..row + count).flat_map(|row| (0..side).map(move |column| (row, column)));
        places
            .map(|(row, column)| stored_height(self.known(row as isize, column as isize)))
            .collect()
    }

    /// The colours of the current band's rows from `row` on, counted in rows of colours, RGB.
    pub fn colours(&self, row: usize, count: usize) -> Vec<u8> {
        let side = self.preset.colours_side();
        let mut rgb = vec![0; 3 * side * count];
        rgb.par_chunks_mut(3 * side).enumerate().for_each(|(index, line)| {
            for (column, texel) in line.chunks_exact_mut(3).enumerate() {
                let known = |row: isize, column: isize| *self.known(row, column);
                texel.copy_from_slice(&self.colour_from(row + index, column, known));
            }
        });
        rgb
    }

    /// A stored height by itself.
    #[cfg(test)]
    pub fn height_at(&self, row: usize, column: usize) -> i16 {
        stored_height(&self.ground_at(row as isize, column as isize))
    }

    /// A colour by itself.
    #[cfg(test)]
    pub fn colour_at(&self, row: usize, column: usize) -> [u8; 3] {
        self.colour_from(row, column, |row, column| self.ground_at(row, column))
    }

    fn width(&self) -> usize {
        self.preset.heights_side + 2 * RIM
    }

    fn ground_at(&self, row: isize, column: isize) -> GroundPoint {
        self.ground.at(self.preset.height_centre_m(row, column))
    }

    fn known(&self, row: isize, column: isize) -> &GroundPoint {
        let row = (row - self.first_row) as usize;
        &self.rows[row * self.width() + (column + RIM as isize) as usize]
    }

    fn colour_from(
        &self,
        row: usize,
        column: usize,
        ground_at: impl Fn(isize, isize) -> GroundPoint,
    ) -> [u8; 3] {
        let point_m = self.preset.colour_centre_m(row, column);
        let ((north, y), (west, x)) = (between_heights(row), between_heights(column));
        let corner = |dy: isize, dx: isize| ground_at(north + dy, west + dx);
        let northern = corner(0, 0).mixed(&corner(0, 1), x);
        let mut ground = northern.mixed(&corner(1, 0).mixed(&corner(1, 1), x), y);
        if ground.is_near_water() {
            ground.to_water_m = self.ground.to_water_m(point_m, ground.bend_m);
        }
        let gradient = |dy: isize, dx: isize| {
            let height_m = |dy: isize, dx: isize| ground_at(north + dy, west + dx).height_m;
            let east = height_m(dy, dx + 1) - height_m(dy, dx - 1);
            let south = height_m(dy + 1, dx) - height_m(dy - 1, dx);
            vec2(east, south) / (2.0 * HEIGHT_CELL_M as f32)
        };
        let gradient = {
            let north: Vec2 = gradient(0, 0).lerp(gradient(0, 1), x);
            north.lerp(gradient(1, 0).lerp(gradient(1, 1), x), y)
        };
        self.cover.colour(point_m, &CoverPoint { ground, gradient })
    }
}

/// The height cell whose centre comes before that of a colour cell, and how far from it to the next.
fn between_heights(index: usize) -> (isize, f32) {
    let per_height = COLOURS_PER_HEIGHT as isize;
    // Three colour cells a height cell: their centres lie a third before, on and a third after its.
    let thirds = index as isize - 1;
    (thirds.div_euclid(per_height), thirds.rem_euclid(per_height) as f32 / per_height as f32)
}

fn stored_height(ground: &GroundPoint) -> i16 {
    ground.height_m.round() as i16
}

#[cfg(test)]
mod tests {
    use super::super::erosion::erode;
    use super::*;

    fn coarse_ground() -> Ground {
        Ground::on(erode(1, 3, |_| true).unwrap(), 1)
    }

    fn preset(name: &str) -> Preset {
        Preset::by_name(name).unwrap()
    }

    #[test]
    fn rows_hold_what_points_are_by_themselves() {
        let ground = coarse_ground();
        let tiny = preset("sichuan-tiny");
        let mut rows = RasterRows::new(&ground, tiny, 1);
        for (row, count) in [(0, 7), (7, 64), (71, 1), (72, 178)] {
            rows.advance(row, count);
            let heights = rows.heights(row, count);
            let colours = rows.colours(3 * row, 3 * count);
            let side = tiny.heights_side;
            for place in (0..side * count).step_by(101) {
                let by_itself = rows.height_at(row + place / side, place % side);
                assert_eq!(heights[place], by_itself);
            }
            let side = tiny.colours_side();
            for place in (0..side * 3 * count).step_by(211) {
                let by_itself = rows.colour_at(3 * row + place / side, place % side);
                assert_eq!(colours[3 * place..3 * place + 3], by_itself);
            }
        }
    }

    #[test]
    fn presets_are_parts_of_one_ground() {
        let ground = coarse_ground();
        let whole = RasterRows::new(&ground, preset("sichuan"), 1);
        for name in ["sichuan-half", "sichuan-small", "sichuan-tiny"] {
            let part = RasterRows::new(&ground, preset(name), 1);
            let [[x, y], [whole_x, whole_y]] =
                [preset(name).corner_m(), preset("sichuan").corner_m()];
            let column = ((x - whole_x) / HEIGHT_CELL_M) as usize;
            let row = ((whole_y - y) / HEIGHT_CELL_M) as usize;
            for place in (0..250).step_by(17) {
                let there = whole.height_at(row + place, column + 249 - place);
                assert_eq!(part.height_at(place, 249 - place), there);
                let there = whole.colour_at(3 * row + place, 3 * column + place);
                assert_eq!(part.colour_at(place, place), there);
            }
        }
    }

    #[test]
    fn presets_lie_within_the_ground() {
        for preset in Preset::ALL {
            let last = preset.heights_side as isize + RIM as isize;
            for corner in [preset.height_centre_m(-2, -2), preset.height_centre_m(last, last)] {
                let inside = 10_000.0..super::super::grid::GROUND_SIZE_M - 10_000.0;
                assert!(inside.contains(&corner.x) && inside.contains(&corner.y), "{corner}");
            }
        }
    }

    #[test]
    fn three_colours_lie_on_every_height() {
        let thirds = [(0, 0.0), (0, 1.0 / 3.0), (0, 2.0 / 3.0), (1, 0.0)];
        assert_eq!([1, 2, 3, 4].map(between_heights), thirds);
        assert_eq!(between_heights(0), (-1, 2.0 / 3.0));
    }
}
