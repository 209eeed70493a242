use std::collections::VecDeque;

use super::texel::Texel;
use crate::dataset::Shape;
use crate::tiling::LayerLayout;

/// Builds all levels of a layer from the rows of its finest one, in one pass.
///
/// Each level keeps only the rows its next row of tiles needs; a pair of rows makes a row of the
/// coarser level (a 2 x 2 box filter) as soon as it is there. Memory is a few tile rows a level,
/// whatever the height of the raster.
pub struct RowPyramid<T> {
    tile_size: usize,
    gutter: usize,
    /// What lies beyond the raster: nothing, or on a globe its other side.
    shape: Shape,
    /// Coarsest levels whose tiles are handed on.
    emitted_levels: u8,
    /// Coarsest level first.
    levels: Vec<LevelRows<T>>,
}

struct LevelRows<T> {
    width: usize,
    height: usize,
    /// Rows held, the first of them being row `first_row` of the level.
    rows: VecDeque<Vec<T>>,
    first_row: usize,
    next_tile_row: usize,
}

/// One row of tiles of a level, with the texels it needs.
pub struct TileRow<'a, T> {
    /// The level.
    pub level: u8,
    /// Which row of tiles.
    pub row: u32,
    tile_size: usize,
    gutter: usize,
    shape: Shape,
    rows: &'a LevelRows<T>,
}

impl<T: Texel> RowPyramid<T> {
    /// A pyramid of `level_count` levels over a finest raster of this width and height. Of as many levels
    /// as the layout has, the coarsest, tiles are handed on.
    ///
    /// The raster of a [`Shape::Globe`] is a whole number of tiles wide, a power of two of them, and half as high.
    pub fn new(
        (width, height): (usize, usize),
        level_count: u8,
        layout: &LayerLayout,
        shape: Shape,
    ) -> Self {
        let levels = (0..level_count)
            .map(|level| {
                let shift = level_count - 1 - level;
                let ceil = |size: usize| size.div_ceil(1 << shift);
                LevelRows {
                    width: ceil(width),
                    height: ceil(height),
                    rows: VecDeque::new(),
                    first_row: 0,
                    next_tile_row: 0,
                }
            })
            .collect();
        Self {
            tile_size: layout.tile_size_texels as usize,
            gutter: layout.gutter_texels as usize,
            shape,
            emitted_levels: layout.level_count,
            levels,
        }
    }

    /// Takes the next row of the finest level, from the north, and hands on every row of tiles that
    /// is complete with it, of the levels that are handed on. Rows of tiles come in order within a level.
    pub fn push<E>(
        &mut self,
        row: Vec<T>,
        emit: &mut impl FnMut(&TileRow<'_, T>) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut row = Some(row);
        for level in (0..self.levels.len()).rev() {
            let Some(next) = row.take() else { break };
            let rows = &mut self.levels[level];
            rows.rows.push_back(next);
            if level > 0 {
                row = rows.coarser_row();
            }
            self.emit_complete(level, emit)?;
        }
        Ok(())
    }

    fn emit_complete<E>(
        &mut self,
        level: usize,
        emit: &mut impl FnMut(&TileRow<'_, T>) -> Result<(), E>,
    ) -> Result<(), E> {
        let (tile_size, gutter, shape) = (self.tile_size, self.gutter, self.shape);
        let rows = &mut self.levels[level];
        while rows.next_tile_row * tile_size < rows.height {
            let needed = ((rows.next_tile_row + 1) * tile_size + gutter).min(rows.height);
            if rows.received() < needed {
                break;
            }
            let row = rows.next_tile_row as u32;
            if level < usize::from(self.emitted_levels) {
                emit(&TileRow { level: level as u8, row, tile_size, gutter, shape, rows })?;
            }
            rows.next_tile_row += 1;
            rows.forget_before((rows.next_tile_row * tile_size).saturating_sub(gutter));
        }
        Ok(())
    }
}

impl<T: Texel> LevelRows<T> {
    fn received(&self) -> usize {
        self.first_row + self.rows.len()
    }

    /// A row that is still in memory.
    fn held(&self, row: i64) -> Option<&Vec<T>> {
        let index = usize::try_from(row - self.first_row as i64).ok()?;
        self.rows.get(index)
    }

    /// The coarser row that the last row completes, if it does. The gutter keeps at least the last
    /// two rows in memory.
    fn coarser_row(&self) -> Option<Vec<T>> {
        let received = self.received();
        let pair_complete = received.is_multiple_of(2);
        if !pair_complete && received < self.height {
            return None;
        }
        let last = self.rows.back()?;
        let (north, south) = if pair_complete {
            (self.rows.get(self.rows.len().checked_sub(2)?)?, Some(last))
        } else {
            (last, None)
        };
        let at = |row: Option<&Vec<T>>, column: usize| {
            row.and_then(|row| row.get(column)).copied().unwrap_or(T::EMPTY)
        };
        let average = |column: usize| {
            let (west, east) = (2 * column, 2 * column + 1);
            T::average([north[west], at(Some(north), east), at(south, west), at(south, east)])
        };
        // Whole squares need no look at what is beyond the raster.
        let pairs_of = |row| <[T]>::as_chunks::<2>(row).0;
        let whole = pairs_of(north).iter().zip(south.map_or(&[][..], |south| pairs_of(south)));
        let mut coarser = Vec::with_capacity(self.width.div_ceil(2));
        coarser.extend(
            whole.map(|(north, south)| T::average([north[0], north[1], south[0], south[1]])),
        );
        coarser.extend((coarser.len()..self.width.div_ceil(2)).map(average));
        Some(coarser)
    }

    fn forget_before(&mut self, row: usize) {
        // Two rows are always kept for the coarser level.
        while self.first_row < row && self.rows.len() > 2 {
            self.rows.pop_front();
            self.first_row += 1;
        }
    }
}

impl<T: Texel> TileRow<'_, T> {
    /// Columns of tiles that can hold data.
    pub fn columns(&self) -> u32 {
        self.rows.width.div_ceil(self.tile_size) as u32
    }

    /// The texels of a tile with its gutter; `None` where the tile itself (its gutter not counted) holds nothing.
    /// Beyond the raster they are empty; beyond that of a globe they are those on the other side.
    pub fn tile(&self, column: u32) -> Option<Vec<T>> {
        let stored = self.tile_size + 2 * self.gutter;
        let mut texels = vec![T::EMPTY; stored * stored];
        // Positions are counted from the gutter's corner, which may lie beyond the raster.
        let left = (column as usize * self.tile_size) as i64 - self.gutter as i64;
        let top = (self.row as usize * self.tile_size) as i64 - self.gutter as i64;
        for (y, line) in texels.chunks_exact_mut(stored).enumerate() {
            let row = top + y as i64;
            match self.shape {
                Shape::Plane => self.copy_within(row, left, line),
                Shape::Globe => self.copy_round(row, left, line),
            }
        }
        let inner = self.gutter..self.gutter + self.tile_size;
        let holds_data = inner
            .clone()
            .any(|y| texels[y * stored..][inner.clone()].iter().any(Texel::holds_data));
        holds_data.then_some(texels)
    }

    /// Copies what the raster has of a line of texels that begins at a row and column.
    fn copy_within(&self, row: i64, first: i64, line: &mut [T]) {
        let Some(row) = self.rows.held(row) else { return };
        let from = first.max(0) as usize;
        let to = ((first + line.len() as i64) as usize).min(row.len());
        let start = (from as i64 - first) as usize;
        line[start..start + to - from].copy_from_slice(&row[from..to]);
    }

    /// Copies a line of texels of a globe: after the last column comes the first, and beyond a pole, as far as a
    /// gutter reaches, the row as far from it on the other side.
    fn copy_round(&self, row: i64, first: i64, line: &mut [T]) {
        let (width, height) = (self.rows.width as i64, self.rows.height as i64);
        let (row, turned) = match row {
            _ if row < 0 => (-1 - row, width / 2),
            _ if row < height => (row, 0),
            _ if row < height + self.gutter as i64 => (2 * height - 1 - row, width / 2),
            _ => return,
        };
        let Some(row) = self.rows.held(row) else { return };
        let mut done = 0;
        while done < line.len() {
            let from = (first + turned + done as i64).rem_euclid(width) as usize;
            let count = (line.len() - done).min(row.len() - from);
            line[done..done + count].copy_from_slice(&row[from..from + count]);
            done += count;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use proptest::prelude::*;

    use super::*;

    /// The straightforward pyramid: whole rasters in f64, one level after the other.
    fn brute_force(finest: &[f64], width: usize, height: usize) -> (Vec<f64>, usize, usize) {
        let (w, h) = (width.div_ceil(2), height.div_ceil(2));
        let mut out = vec![f64::NAN; w * h];
        for (index, target) in out.iter_mut().enumerate() {
            let (row, column) = (2 * (index / w), 2 * (index % w));
            let held: Vec<f64> = [(0, 0), (0, 1), (1, 0), (1, 1)]
                .iter()
                .map(|(dy, dx)| (row + dy, column + dx))
                .filter(|&(y, x)| y < height && x < width)
                .map(|(y, x)| finest[y * width + x])
                .filter(|value| !value.is_nan())
                .collect();
            *target = held.iter().sum::<f64>() / held.len() as f64;
        }
        (out, w, h)
    }

    proptest! {
        #[test]
        fn every_texel_of_every_tile_is_the_box_average(
            width in 1_usize..70, height in 1_usize..70, level_count in 1_u8..5, seed in 0_u32..1000,
        ) {
            let tile = 8;
            let layout = LayerLayout { tile_size_texels: 8, gutter_texels: 4, level_count };
            let finest: Vec<f32> = (0..width * height)
                .map(|i| {
                    let word = (i as u32 + seed).wrapping_mul(2_654_435_761) >> 16;
                    if word.is_multiple_of(7) { f32::NAN } else { word as f32 / 64.0 }
                })
                .collect();
            let mut tiles = HashMap::new();
            let mut pyramid = RowPyramid::new((width, height), level_count, &layout, Shape::Plane);
            for row in finest.chunks(width) {
                pyramid.push(row.to_vec(), &mut |tile_row: &TileRow<'_, f32>| {
                    for column in 0..tile_row.columns() {
                        tiles.insert((tile_row.level, tile_row.row, column), tile_row.tile(column));
                    }
                    Ok::<_, ()>(())
                }).unwrap();
            }
            let mut raster: Vec<f64> = finest.iter().copied().map(f64::from).collect();
            let (mut w, mut h) = (width, height);
            for level in (0..level_count).rev() {
                for row in 0..h.div_ceil(tile) {
                    for column in 0..w.div_ceil(tile) {
                        let got = tiles.remove(&(level, row as u32, column as u32));
                        let got = got.expect("every tile of the raster is handed on");
                        check_tile(got.as_deref(), &raster, (w, h), (row, column))?;
                    }
                }
                (raster, w, h) = brute_force(&raster, w, h);
            }
            prop_assert!(tiles.is_empty());
        }
    }

    /// The value of a globe's raster at any row and column: round it, and over the poles.
    fn round_the_globe(raster: &[f64], (w, h): (usize, usize), y: i64, x: i64) -> f64 {
        let (width, height) = (w as i64, h as i64);
        let (y, x) = match y {
            y if y < 0 => (-1 - y, x + width / 2),
            y if y >= height => (2 * height - 1 - y, x + width / 2),
            y => (y, x),
        };
        raster[y as usize * w + x.rem_euclid(width) as usize]
    }

    proptest! {
        #[test]
        fn gutters_of_a_globe_hold_what_lies_beyond_the_date_line_and_the_poles(
            level_count in 1_u8..5, seed in 0_u32..1000,
        ) {
            let (tile, gutter) = (16_usize, 4_i64);
            let layout = LayerLayout { tile_size_texels: 16, gutter_texels: 4, level_count };
            let (mut w, mut h) = (tile << (level_count - 1), (tile << (level_count - 1)) / 2);
            let finest: Vec<f32> = (0..w * h)
                .map(|i| ((i as u32 + seed).wrapping_mul(2_654_435_761) >> 16) as f32 / 64.0)
                .collect();
            let mut tiles = HashMap::new();
            let mut pyramid = RowPyramid::new((w, h), level_count, &layout, Shape::Globe);
            for row in finest.chunks(w) {
                pyramid.push(row.to_vec(), &mut |tile_row: &TileRow<'_, f32>| {
                    for column in 0..tile_row.columns() {
                        tiles.insert((tile_row.level, tile_row.row, column), tile_row.tile(column));
                    }
                    Ok::<_, ()>(())
                }).unwrap();
            }
            let mut raster: Vec<f64> = finest.iter().copied().map(f64::from).collect();
            for level in (0..level_count).rev() {
                for row in 0..h.div_ceil(tile) {
                    for column in 0..w / tile {
                        let got = tiles.remove(&(level, row as u32, column as u32)).unwrap().unwrap();
                        for (index, &value) in got.iter().enumerate() {
                            let y = (row * tile + index / 24) as i64 - gutter;
                            let x = (column * tile + index % 24) as i64 - gutter;
                            if y >= h as i64 + gutter {
                                prop_assert!(value.is_nan(), "below the globe in the root");
                                continue;
                            }
                            let want = round_the_globe(&raster, (w, h), y, x);
                            prop_assert!((f64::from(value) - want).abs() < 1e-3, "{level} {y} {x}");
                        }
                    }
                }
                (raster, w, h) = brute_force(&raster, w, h);
            }
            prop_assert!(tiles.is_empty());
        }
    }

    fn check_tile(
        got: Option<&[f32]>,
        raster: &[f64],
        (w, h): (usize, usize),
        (row, column): (usize, usize),
    ) -> Result<(), TestCaseError> {
        let expected = |y: i64, x: i64| {
            let inside = y >= 0 && x >= 0 && (y as usize) < h && (x as usize) < w;
            if inside { raster[y as usize * w + x as usize] } else { f64::NAN }
        };
        let place = |offset: usize, tile: usize| (tile * 8 + offset) as i64 - 4;
        let held =
            (4..12).any(|y| (4..12).any(|x| !expected(place(y, row), place(x, column)).is_nan()));
        prop_assert_eq!(got.is_some(), held);
        for (index, &value) in got.unwrap_or_default().iter().enumerate() {
            let want = expected(place(index / 16, row), place(index % 16, column));
            prop_assert_eq!(value.is_nan(), want.is_nan());
            prop_assert!(value.is_nan() || (f64::from(value) - want).abs() < 1e-3);
        }
        Ok(())
    }
}
