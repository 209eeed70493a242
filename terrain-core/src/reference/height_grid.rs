//! The heights of one tile as the ray caster wants them: samples, the cells between them, and the
//! bounds of blocks of cells.
//!
//! Places are in texels east and south of the tile's north-west corner, so samples lie at halves.
//! Cell (i, j) is the square between the samples of columns i - 1 and i and rows j - 1 and j: the
//! first and the last reach into the gutter and belong to the tile by half.

use glam::{DVec2, DVec3, dvec2};

use super::partial_patch::PartialPatch;
use super::patch::BilinearPatch;
use super::range_pyramid::{BlockRange, RangePyramid, range_of};
use crate::dataset::HeightTile;
use crate::tiling::{LayerLayout, TilingScheme};

/// The decoded heights of one tile.
pub(super) struct HeightGrid {
    /// North-west corner of the tile in metres.
    origin: DVec2,
    texel_m: f64,
    /// Samples a side with the gutter, and the gutter.
    stored: usize,
    gutter: usize,
    /// Row by row; NaN where there is no data.
    samples_m: Vec<f32>,
    /// Cells a side: one more than the tile has texels.
    cells: usize,
    ranges: RangePyramid,
    least_share: f64,
}

/// The surface within a cell.
pub(super) enum CellSurface {
    /// All four corners hold data.
    Whole(BilinearPatch),
    /// Some do.
    Partial(PartialPatch),
    /// None does.
    Nothing,
}

impl HeightGrid {
    /// Of a decoded tile. `least_share` is the share of a point's bilinear weights that must hold
    /// data for there to be ground.
    pub fn new(
        scheme: &TilingScheme,
        layout: &LayerLayout,
        tile: &HeightTile,
        least_share: f64,
    ) -> Self {
        let stored = tile.stored_size_texels as usize;
        let gutter = layout.gutter_texels as usize;
        let samples_m: Vec<f32> = (0..stored * stored)
            .map(|index| tile.samples.height_m(index).unwrap_or(f32::NAN))
            .collect();
        let cells = layout.tile_size_texels as usize + 1;
        let corner = |row: usize, column: usize| {
            let nw = (gutter + row - 1) * stored + gutter + column - 1;
            range_of([nw, nw + 1, nw + stored, nw + stored + 1].map(|index| samples_m[index]))
        };
        let ranges = RangePyramid::new(cells, corner);
        Self {
            origin: scheme.tile_origin(tile.id),
            texel_m: layout.texel_size_m(scheme, tile.id.level),
            stored,
            gutter,
            cells,
            ranges,
            least_share,
            samples_m,
        }
    }

    /// Bytes it takes in memory.
    pub fn byte_len(&self) -> u64 {
        size_of_val(self.samples_m.as_slice()) as u64 + self.ranges.byte_len()
    }

    /// Cells a side.
    pub fn cells(&self) -> i32 {
        self.cells as i32
    }

    /// The level of blocks of which one holds the whole tile.
    pub fn top_level(&self) -> u32 {
        self.ranges.top()
    }

    /// The heights of the block of 2^`level` cells a side that holds the cell; see [`RangePyramid`].
    pub fn block_range(&self, level: u32, cell: [i32; 2]) -> BlockRange {
        self.ranges.range(level, cell)
    }

    /// The place of a world point.
    pub fn place_of(&self, point: DVec2) -> DVec2 {
        dvec2(point.x - self.origin.x, self.origin.y - point.y) / self.texel_m
    }

    /// A world direction in texels east, texels south and metres up.
    pub fn direction_of(&self, direction: DVec3) -> DVec3 {
        let horizontal = dvec2(direction.x, -direction.y) / self.texel_m;
        horizontal.extend(direction.z)
    }

    /// The cell of a place in the tile, and the place within it.
    pub fn cell_of(&self, place: DVec2) -> ([i32; 2], DVec2) {
        // Places of the tile are not negative, so that cutting off rounds down.
        let cell = [place.x, place.y].map(|p| ((p + 0.5) as i32).clamp(0, self.cells() - 1));
        (cell, place - (DVec2::from(cell.map(f64::from)) - 0.5))
    }

    /// The surface of a cell of the tile.
    pub fn surface(&self, cell: [i32; 2]) -> CellSurface {
        let nw = self.sample_index([cell[0] - 1, cell[1] - 1]);
        let north = &self.samples_m[nw..nw + 2];
        let south = &self.samples_m[nw + self.stored..nw + self.stored + 2];
        let corners = [north[0], north[1], south[0], south[1]].map(f64::from);
        // NaN shows in the sum.
        if !corners.iter().sum::<f64>().is_nan() {
            return CellSurface::Whole(BilinearPatch::new(corners));
        }
        match corners.iter().all(|height| height.is_nan()) {
            true => CellSurface::Nothing,
            false => CellSurface::Partial(PartialPatch::new(corners, self.least_share)),
        }
    }

    /// Height at a place in the tile, where there is ground.
    pub fn height_m(&self, place: DVec2) -> Option<f64> {
        let (cell, within) = self.cell_of(place);
        match self.surface(cell) {
            CellSurface::Whole(patch) => Some(patch.height_m(within)),
            CellSurface::Partial(patch) => patch.height_m(within),
            CellSurface::Nothing => None,
        }
    }

    /// The gradient of the surface of a cell at a place within it: metres up per metre east and
    /// north.
    pub fn gradient(&self, cell: [i32; 2], within: DVec2) -> DVec2 {
        let gradient = match self.surface(cell) {
            CellSurface::Whole(patch) => patch.gradient(within),
            CellSurface::Partial(patch) => patch.gradient(within),
            CellSurface::Nothing => DVec2::ZERO,
        };
        dvec2(gradient.x, -gradient.y) / self.texel_m
    }

    /// The slope that is lit at a place: bilinear between the slopes of the samples, which are half
    /// the difference of their neighbours; of those that hold data. Metres up per metre east and
    /// north.
    pub fn lit_slope(&self, place: DVec2) -> DVec2 {
        let ([column, row], part) = self.cell_of(place);
        let rest = 1.0 - part;
        let corners = [
            ([column - 1, row - 1], rest.x * rest.y),
            ([column, row - 1], part.x * rest.y),
            ([column - 1, row], rest.x * part.y),
            ([column, row], part.x * part.y),
        ];
        let (mut sum, mut weight) = (DVec2::ZERO, 0.0);
        for (sample, share) in corners {
            if let Some(slope) = self.sample_slope(sample) {
                sum += slope * share;
                weight += share;
            }
        }
        if weight > 0.0 { sum / weight } else { DVec2::ZERO }
    }

    fn sample_slope(&self, [column, row]: [i32; 2]) -> Option<DVec2> {
        let centre = self.sample([column, row])?;
        let along = |before: Option<f64>, after: Option<f64>| {
            let steps = f64::from(u8::from(before.is_some()) + u8::from(after.is_some()));
            let rise = after.unwrap_or(centre) - before.unwrap_or(centre);
            rise / (steps.max(1.0) * self.texel_m)
        };
        let east = along(self.sample([column - 1, row]), self.sample([column + 1, row]));
        let north = along(self.sample([column, row + 1]), self.sample([column, row - 1]));
        Some(dvec2(east, north))
    }

    /// The height of a sample, by column and row of the tile; negative ones lie in the gutter.
    fn sample(&self, place: [i32; 2]) -> Option<f64> {
        let height_m = self.samples_m[self.sample_index(place)];
        (!height_m.is_nan()).then(|| f64::from(height_m))
    }

    /// The gutter is at least 4 samples wide; no more than 2 of them are asked for.
    fn sample_index(&self, [column, row]: [i32; 2]) -> usize {
        let gutter = self.gutter as i32;
        (row + gutter) as usize * self.stored + (column + gutter) as usize
    }
}
