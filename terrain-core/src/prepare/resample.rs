//! Brings rasters of any CRS and cell size onto the grid of a layer's finest level.

mod position_nodes;
mod taps;

use glam::{DVec2, dvec2};
use rayon::prelude::*;

use self::position_nodes::PositionNodes;
use self::taps::{TapWindow, sample};
use super::PrepareError;
use super::mosaic::{Mosaic, SignedWindow};
use super::texel::{FULL, LINEAR_FROM_SRGB, LinearColour};
use crate::geodesy::{CoordinateSystem, CoordinateTransform};

/// The finest level of a layer: square texels, north-west corner first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayerGrid {
    /// North-west corner of the first texel, metres.
    pub origin: DVec2,
    /// Side of a texel, metres.
    pub texel_m: f64,
    /// Columns of texels.
    pub width: usize,
    /// Rows of texels.
    pub height: usize,
}

/// Reads rows of a layer's finest level out of mosaics. Where several cover a texel, the first one
/// that holds data there counts.
pub struct Resampler {
    target: LayerGrid,
    inputs: Vec<Input>,
}

struct Input {
    mosaic: Mosaic,
    to_source: CoordinateTransform,
}

/// Columns resampled together: wide enough to pay for its window, narrow enough to spread over
/// threads and to keep the window small where the grids are turned against each other.
const BLOCK_COLUMNS: usize = 256;
/// Most source cells read for one block; blocks that need more are cut in four.
const MAX_WINDOW_CELLS: f64 = 6.0e6;
/// A sample needs at least half of its weight from cells that hold data.
const LEAST_WEIGHT: f32 = 0.4999;

/// A rectangle of target texels.
#[derive(Clone, Copy)]
struct Block {
    column: usize,
    row: usize,
    width: usize,
    height: usize,
}

impl Resampler {
    /// Resamples the mosaics (first ones on top) to the grid in the target CRS.
    pub fn new(target: LayerGrid, crs: &CoordinateSystem, mosaics: Vec<Mosaic>) -> Self {
        let inputs = mosaics
            .into_iter()
            .map(|mosaic| {
                let to_source = CoordinateTransform::new(crs, mosaic.crs());
                Input { mosaic, to_source }
            })
            .collect();
        Self { target, inputs }
    }

    /// The grid resampled to.
    pub fn target(&self) -> &LayerGrid {
        &self.target
    }

    /// Heights of some rows in metres, NaN where there is no data: one vector a row.
    pub fn height_rows(&self, row: usize, count: usize) -> Result<Vec<Vec<f32>>, PrepareError> {
        if let Some(mosaic) = self.unchanged() {
            let (column, width) = (0, self.target.width);
            let window = SignedWindow { column, row: row as i64, width, height: count };
            let heights = mosaic.read_heights(window)?;
            return Ok(heights.chunks_exact(width).map(<[f32]>::to_vec).collect());
        }
        self.rows(
            row,
            count,
            f32::NAN,
            |input, window| {
                let heights = input.mosaic.read_heights(window)?;
                let premultiplied = |height: f32| match height.is_nan() {
                    true => [0.0; 2],
                    false => [height, 1.0],
                };
                Ok(heights.into_iter().map(premultiplied).collect::<Vec<[f32; 2]>>())
            },
            |[height, weight]| (weight >= LEAST_WEIGHT).then(|| height / weight),
        )
    }

    /// Colours of some rows: one vector a row.
    pub fn colour_rows(
        &self,
        row: usize,
        count: usize,
    ) -> Result<Vec<Vec<LinearColour>>, PrepareError> {
        let table = &*LINEAR_FROM_SRGB;
        self.rows(
            row,
            count,
            LinearColour::default(),
            |input, window| {
                let colours = input.mosaic.read_colours(window)?;
                let premultiplied = |[r, g, b, a]: [u8; 4]| {
                    let coverage = f32::from(a) / 255.0;
                    let linear = |code: u8| coverage * table[usize::from(code)];
                    [linear(r), linear(g), linear(b), coverage]
                };
                Ok(colours.into_iter().map(premultiplied).collect::<Vec<[f32; 4]>>())
            },
            |[r, g, b, coverage]| {
                let part = |value: f32| (value + 0.5) as u16;
                (coverage > 0.002)
                    .then(|| LinearColour([part(r), part(g), part(b), part(FULL * coverage)]))
            },
        )
    }

    /// The one mosaic whose cells are the target's texels, if that is so.
    pub fn unchanged(&self) -> Option<&Mosaic> {
        let [input] = &self.inputs[..] else { return None };
        let grid = input.mosaic.grid();
        let same = input.to_source.is_identity()
            && grid.origin == self.target.origin
            && grid.cell.x == self.target.texel_m;
        same.then_some(&input.mosaic)
    }

    fn rows<const N: usize, T: Copy + Send + Sync>(
        &self,
        row: usize,
        count: usize,
        empty: T,
        read: impl Fn(&Input, SignedWindow) -> Result<Vec<[f32; N]>, PrepareError> + Sync,
        finish: impl Fn([f32; N]) -> Option<T> + Sync,
    ) -> Result<Vec<Vec<T>>, PrepareError> {
        let starts: Vec<usize> = (0..self.target.width).step_by(BLOCK_COLUMNS).collect();
        let blocks: Vec<Vec<T>> = starts
            .par_iter()
            .map(|&column| {
                let width = BLOCK_COLUMNS.min(self.target.width - column);
                let block = Block { column, row, width, height: count };
                let mut out = vec![None; width * count];
                for input in &self.inputs {
                    self.fill(input, block, &read, &finish, &mut |index, value| {
                        out[index] = out[index].or(Some(value));
                    })?;
                }
                Ok(out.into_iter().map(|value| value.unwrap_or(empty)).collect())
            })
            .collect::<Result<_, PrepareError>>()?;
        let line = |row: usize| {
            let parts = starts.iter().zip(&blocks).map(|(&column, block)| {
                let width = BLOCK_COLUMNS.min(self.target.width - column);
                &block[row * width..(row + 1) * width]
            });
            parts.collect::<Vec<_>>().concat()
        };
        Ok((0..count).map(line).collect())
    }

    /// Samples one input over a block and puts every value it has at its index in the block.
    fn fill<const N: usize, T>(
        &self,
        input: &Input,
        block: Block,
        read: &impl Fn(&Input, SignedWindow) -> Result<Vec<[f32; N]>, PrepareError>,
        finish: &impl Fn([f32; N]) -> Option<T>,
        put: &mut dyn FnMut(usize, T),
    ) -> Result<(), PrepareError> {
        let nodes = PositionNodes::new(
            block.width,
            block.height,
            |column, row| {
                input
                    .columns_rows(self.centre(block.column as f64 + column, block.row as f64 + row))
            },
            input.mosaic.columns_round(),
            f64::from(input.mosaic.size()[0]),
        );
        let Some((low, high)) = nodes.bounds() else { return Ok(()) };
        let Some(window) = input.window(low, high) else { return Ok(()) };
        if window.width as f64 * window.height as f64 > MAX_WINDOW_CELLS
            && block.width.max(block.height) > 8
        {
            for (part, offset) in quarters(block) {
                self.fill(input, part, read, finish, &mut |index, value| {
                    put(offset + index / part.width * block.width + index % part.width, value);
                })?;
            }
            return Ok(());
        }
        let taps = TapWindow::new(read(input, window)?, window);
        let cells_a_texel = nodes.cells_a_texel();
        for row in 0..block.height {
            for column in 0..block.width {
                let Some(position) = nodes.position(column, row) else { continue };
                let value = sample(&taps, position, cells_a_texel);
                if let Some(value) = finish(value) {
                    put(row * block.width + column, value);
                }
            }
        }
        Ok(())
    }

    /// The world position of the centre of a texel.
    fn centre(&self, column: f64, row: f64) -> DVec2 {
        self.target.origin + self.target.texel_m * dvec2(column + 0.5, -(row + 0.5))
    }
}

impl Input {
    fn columns_rows(&self, position: DVec2) -> Option<DVec2> {
        Some(self.mosaic.grid().columns_rows(self.to_source.apply(position)?))
    }

    /// The cells needed to sample between two positions; `None` where the mosaic has none of them.
    fn window(&self, low: DVec2, high: DVec2) -> Option<SignedWindow> {
        const MARGIN: f64 = 3.0;
        let [width, height] = self.mosaic.size().map(f64::from);
        let (mut from, mut to) = ((low - MARGIN).floor(), (high + MARGIN).ceil());
        if self.mosaic.columns_round().is_none() {
            (from.x, to.x) = (from.x.max(-MARGIN), to.x.min(width + MARGIN));
        }
        (from.y, to.y) = (from.y.max(-MARGIN), to.y.min(height + MARGIN));
        let size = to - from;
        let apart = size.min_element() < 1.0
            || from.y >= height
            || to.y <= 0.0
            || (self.mosaic.columns_round().is_none() && (from.x >= width || to.x <= 0.0));
        (!apart).then_some(SignedWindow {
            column: from.x as i64,
            row: from.y as i64,
            width: size.x as usize,
            height: size.y as usize,
        })
    }
}

/// A block cut in four (or two), with the index each part begins at.
fn quarters(block: Block) -> Vec<(Block, usize)> {
    let halves = |length: usize| match length {
        0..=1 => vec![(0, length)],
        _ => vec![(0, length / 2), (length / 2, length - length / 2)],
    };
    let mut parts = Vec::new();
    for (y, height) in halves(block.height) {
        for (x, width) in halves(block.width) {
            let part = Block { column: block.column + x, row: block.row + y, width, height };
            parts.push((part, y * block.width + x));
        }
    }
    parts
}
