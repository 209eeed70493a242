//! Brings rasters of any CRS and cell size onto the grid of a layer's finest level.

mod position_nodes;
mod separable;
mod taps;

use glam::{DVec2, dvec2};
use rayon::prelude::*;

use self::position_nodes::PositionNodes;
use self::separable::sample_rows;
use self::taps::{MOST_INTERPOLATED, TapWindow, sample};
use super::PrepareError;
use super::mosaic::{Mosaic, SignedWindow};
use super::source::RasterGrid;
use super::texel::{FULL, LINEAR_FROM_SRGB, LinearColour, Texel};
use crate::geodesy::{CoordinateSystem, CoordinateTransform, PlateCarree};

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
    to_source: ToSource,
}

/// How positions in the target's CRS become those of a mosaic's.
enum ToSource {
    /// From metres of the plate carrée to degrees, which go on beyond the date line and the poles: so do the texels
    /// around the globe's edges.
    Degrees,
    /// By way of the two systems' definitions.
    Transform(Box<CoordinateTransform>),
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
                let to_source = ToSource::new(crs, mosaic.crs());
                Input { mosaic, to_source }
            })
            .collect();
        Self { target, inputs }
    }

    /// The grid resampled to.
    pub fn target(&self) -> &LayerGrid {
        &self.target
    }

    /// Where the mosaics lie.
    pub fn source_grids(&self) -> Vec<RasterGrid> {
        self.inputs.iter().map(|input| *input.mosaic.grid()).collect()
    }

    /// Heights of some rows in metres, NaN where there is no data: one vector a row.
    pub fn height_rows(&self, row: usize, count: usize) -> Result<Vec<Vec<f32>>, PrepareError> {
        if let Some(mosaic) = self.unchanged() {
            let heights = mosaic.read_heights(self.whole_rows(row, count))?;
            return Ok(heights.chunks_exact(self.target.width).map(<[f32]>::to_vec).collect());
        }
        let premultiplied = |height: f32| if height.is_nan() { [0.0; 2] } else { [height, 1.0] };
        self.rows::<2, true, f32>(
            (row, count),
            |input, window| {
                let heights = input.mosaic.read_heights(window)?;
                Ok(heights.into_iter().map(premultiplied).collect())
            },
            |[height, weight]| if weight >= LEAST_WEIGHT { height / weight } else { f32::NAN },
        )
    }

    /// Colours of some rows: one vector a row.
    pub fn colour_rows(
        &self,
        row: usize,
        count: usize,
    ) -> Result<Vec<Vec<LinearColour>>, PrepareError> {
        if let Some(mosaic) = self.unchanged() {
            let colours = mosaic.read_colours(self.whole_rows(row, count))?;
            let lines = colours.par_chunks(self.target.width);
            return Ok(lines
                .map(|line| line.iter().copied().map(LinearColour::of_srgb).collect())
                .collect());
        }
        let table = &*LINEAR_FROM_SRGB;
        let premultiplied = |[r, g, b, a]: [u8; 4]| {
            let coverage = f32::from(a) / 255.0;
            let linear = |code: u8| coverage * table[usize::from(code)];
            [linear(r), linear(g), linear(b), coverage]
        };
        self.rows::<4, false, LinearColour>(
            (row, count),
            |input, window| {
                let colours = input.mosaic.read_colours(window)?;
                Ok(colours.into_iter().map(premultiplied).collect())
            },
            |[r, g, b, coverage]| {
                // Casts keep what the cubic throws over within 0..=65535.
                let part = |value: f32| (value + 0.5) as u16;
                LinearColour([part(r), part(g), part(b), part(FULL * coverage)])
            },
        )
    }

    /// The one mosaic whose cells are the target's texels, if that is so.
    pub fn unchanged(&self) -> Option<&Mosaic> {
        let [input] = &self.inputs[..] else { return None };
        let grid = input.mosaic.grid();
        let same = input.to_source.is_identity()
            && grid.origin == self.target.origin
            && grid.cell == DVec2::splat(self.target.texel_m);
        same.then_some(&input.mosaic)
    }

    fn whole_rows(&self, row: usize, count: usize) -> SignedWindow {
        SignedWindow { column: 0, row: row as i64, width: self.target.width, height: count }
    }

    fn rows<const N: usize, const HOLD: bool, T: Texel>(
        &self,
        (row, count): (usize, usize),
        read: impl Fn(&Input, SignedWindow) -> Result<Vec<[f32; N]>, PrepareError> + Sync,
        finish: impl Fn([f32; N]) -> T + Sync,
    ) -> Result<Vec<Vec<T>>, PrepareError> {
        let starts: Vec<usize> = (0..self.target.width).step_by(BLOCK_COLUMNS).collect();
        let width_at = |column: usize| BLOCK_COLUMNS.min(self.target.width - column);
        let blocks: Vec<Vec<T>> = starts
            .par_iter()
            .map(|&column| {
                let block = Block { column, row, width: width_at(column), height: count };
                let mut out = vec![T::EMPTY; block.width * count];
                for input in &self.inputs {
                    self.fill::<N, HOLD, T>(input, block, &read, &finish, &mut out, block.width)?;
                }
                Ok(out)
            })
            .collect::<Result<_, PrepareError>>()?;
        let line = |row: usize| {
            let mut line = Vec::with_capacity(self.target.width);
            for (&column, block) in starts.iter().zip(&blocks) {
                let width = width_at(column);
                line.extend_from_slice(&block[row * width..(row + 1) * width]);
            }
            line
        };
        Ok((0..count).map(line).collect())
    }

    /// Samples one input over a block, into rows of `out` that are `stride` apart, where they are
    /// still empty.
    fn fill<const N: usize, const HOLD: bool, T: Texel>(
        &self,
        input: &Input,
        block: Block,
        read: &impl Fn(&Input, SignedWindow) -> Result<Vec<[f32; N]>, PrepareError>,
        finish: &impl Fn([f32; N]) -> T,
        out: &mut [T],
        stride: usize,
    ) -> Result<(), PrepareError> {
        let nodes = self.nodes(input, block);
        for turn in input.turns(&nodes) {
            let nodes = nodes.moved(turn);
            self.fill_from::<N, HOLD, T>(input, (block, &nodes), read, finish, out, stride)?;
        }
        Ok(())
    }

    /// [`Self::fill`] where the block's texels lie at these positions.
    fn fill_from<const N: usize, const HOLD: bool, T: Texel>(
        &self,
        input: &Input,
        (block, nodes): (Block, &PositionNodes),
        read: &impl Fn(&Input, SignedWindow) -> Result<Vec<[f32; N]>, PrepareError>,
        finish: &impl Fn([f32; N]) -> T,
        out: &mut [T],
        stride: usize,
    ) -> Result<(), PrepareError> {
        let Some((low, high)) = nodes.bounds() else { return Ok(()) };
        let Some(window) = input.window(low, high) else { return Ok(()) };
        if window.width as f64 * window.height as f64 > MAX_WINDOW_CELLS
            && block.width.max(block.height) > 8
        {
            return quarters(block).into_iter().try_for_each(|part| {
                let at = (part.row - block.row) * stride + part.column - block.column;
                self.fill::<N, HOLD, T>(input, part, read, finish, &mut out[at..], stride)
            });
        }
        let taps = TapWindow::new(read(input, window)?, window);
        let cells_a_texel = nodes.cells_a_texel();
        let put = |target: &mut T, value: [f32; N]| {
            if !target.holds_data() {
                *target = finish(value);
            }
        };
        let size = [block.width, block.height];
        let done = cells_a_texel <= MOST_INTERPOLATED
            && sample_rows::<N, HOLD>(&taps, nodes, size, |row, line| {
                let targets = &mut out[row * stride..row * stride + block.width];
                targets.iter_mut().zip(line).for_each(|(target, value)| put(target, *value));
            });
        if done {
            return Ok(());
        }
        for row in 0..block.height {
            for column in 0..block.width {
                if let Some(position) = nodes.position(column, row) {
                    let value = sample::<N, HOLD>(&taps, position, cells_a_texel);
                    put(&mut out[row * stride + column], value);
                }
            }
        }
        Ok(())
    }

    fn nodes(&self, input: &Input, block: Block) -> PositionNodes {
        PositionNodes::new(
            block.width,
            block.height,
            |column, row| {
                let centre = self.centre(block.column as f64 + column, block.row as f64 + row);
                input.columns_rows(centre)
            },
            input.columns_to_turn_by(),
            f64::from(input.mosaic.size()[0]),
        )
    }

    /// The world position of the centre of a texel.
    fn centre(&self, column: f64, row: f64) -> DVec2 {
        self.target.origin + self.target.texel_m * dvec2(column + 0.5, -(row + 0.5))
    }
}

impl ToSource {
    fn new(crs: &CoordinateSystem, source: &CoordinateSystem) -> Self {
        if crs.epsg() == PlateCarree::EPSG && has_degrees_of_wgs84(source) {
            return Self::Degrees;
        }
        Self::Transform(Box::new(CoordinateTransform::new(crs, source)))
    }

    fn apply(&self, position: DVec2) -> Option<DVec2> {
        match self {
            Self::Degrees => Some(PlateCarree::degrees_from_metres(position)),
            Self::Transform(transform) => transform.apply(position),
        }
    }

    fn is_identity(&self) -> bool {
        matches!(self, Self::Transform(transform) if transform.is_identity())
    }
}

/// Whether a system's coordinates are the longitudes and latitudes of WGS 84, by that or another name.
fn has_degrees_of_wgs84(system: &CoordinateSystem) -> bool {
    let Ok(wgs84) = CoordinateSystem::from_epsg(CoordinateSystem::WGS84) else { return false };
    let transform = CoordinateTransform::new(&wgs84, system);
    let is_same = |place: DVec2| {
        transform.apply(place).is_some_and(|found| (found - place).length() < 1.0e-9)
    };
    system.is_geographic() && is_same(dvec2(7.0, 46.0)) && is_same(dvec2(-101.0, -33.0))
}

impl Input {
    fn columns_rows(&self, position: DVec2) -> Option<DVec2> {
        Some(self.mosaic.grid().columns_rows(self.to_source.apply(position)?))
    }

    /// Columns once round the Earth where positions may come from different turns.
    fn columns_to_turn_by(&self) -> Option<f64> {
        match self.to_source {
            ToSource::Degrees => None,
            ToSource::Transform(_) => self.mosaic.columns_round(),
        }
    }

    /// What to add to the columns of a block's positions, one after the other, to find all that the mosaic has of the
    /// block: of degrees that go on beyond the date line, whole turns.
    fn turns(&self, nodes: &PositionNodes) -> Vec<f64> {
        let round = self.mosaic.columns_round().filter(|_| !self.mosaic.wraps());
        let (ToSource::Degrees, Some(round), Some((low, high))) =
            (&self.to_source, round, nodes.bounds())
        else {
            return vec![0.0];
        };
        let first = (-high.x / round).floor() as i32;
        let last = ((f64::from(self.mosaic.size()[0]) - low.x) / round).ceil() as i32;
        (first..=last).map(|turns| f64::from(turns) * round).collect()
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
            || (self.columns_to_turn_by().is_none()
                && !self.mosaic.wraps()
                && (from.x >= width || to.x <= 0.0));
        (!apart).then_some(SignedWindow {
            column: from.x as i64,
            row: from.y as i64,
            width: size.x as usize,
            height: size.y as usize,
        })
    }
}

/// A block cut in four (or two).
fn quarters(block: Block) -> Vec<Block> {
    let halves = |first: usize, length: usize| match length {
        0..=1 => vec![(first, length)],
        _ => vec![(first, length / 2), (first + length / 2, length - length / 2)],
    };
    let mut parts = Vec::new();
    for (row, height) in halves(block.row, block.height) {
        for (column, width) in halves(block.column, block.width) {
            parts.push(Block { column, row, width, height });
        }
    }
    parts
}
