//! The height layer: choosing its step, filling voids, encoding its tiles.

use std::path::Path;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::plan::LayerPlan;
use super::row_pyramid::{RowPyramid, TileRow};
use super::run::{Run, read_ahead};
use super::void_fill::{VoidFill, VoidReport, VoidRule};
use super::{PrepareError, PrepareRequest};
use crate::dataset::codec::{EXACT_STEPS, NO_DATA_STEPS, encode_height_steps, encode_heights_m};
use crate::dataset::{
    ArchiveWriter, HeightEncoding, HeightLayer, HeightRange, HeightRanges, Shape,
};
use crate::tiling::{LayerLayout, TileId};

/// A written height layer.
#[derive(Serialize, Deserialize)]
pub struct WrittenHeights {
    /// What the manifest says of it.
    pub layer: HeightLayer,
    /// Number of tiles written.
    pub tiles: u64,
    /// Bytes of their payloads.
    pub payload_bytes: u64,
    /// What became of gaps.
    pub voids: VoidReport,
    /// Cells of a globe that no source has heights of.
    pub cells_at_zero: u64,
}

/// Writes all height tiles to an archive.
pub fn write_heights(
    plan: &LayerPlan,
    source_step_m: f64,
    request: &PrepareRequest,
    archive: &Path,
    run: &Run<'_>,
) -> Result<WrittenHeights, PrepareError> {
    let source_range = scan(plan, request.shape, run)?;
    let step_m = height_step_m(source_range, source_step_m);
    let level_count = request.level_limit.unwrap_or(u8::MAX).min(plan.level_count);
    let layout = request.layout(request.height_tile_texels, level_count);
    let steps_fit = f64::from(source_range.max_m.abs().max(source_range.min_m.abs()))
        / f64::from(step_m)
        < f64::from(EXACT_STEPS);
    let encoding = if steps_fit { request.height_encoding } else { HeightEncoding::Float };

    let encoder = HeightEncoder { layout, encoding, step_m };
    let mut archive = ArchiveWriter::create(archive)?;
    let mut ranges = RangeTable::new(level_count);
    let streamed = {
        let mut emit = |tiles: &TileRow<'_, f32>| -> Result<(), PrepareError> {
            for (tile, range, payload) in encoder.encode_row(tiles) {
                archive.add(tile, &payload)?;
                ranges.add(tile, range);
            }
            Ok(())
        };
        stream(plan, (&layout, request), run, &mut emit)?
    };
    let (tiles, payload_bytes) = (archive.present().len(), archive.payload_bytes());
    archive.finish()?;
    let ranges = ranges.finish();
    let range = ranges.range(TileId::ROOT).unwrap_or(source_range);
    let layer =
        HeightLayer { layout, encoding, step_m, has_voids: streamed.has_voids, range, ranges };
    let Streamed { voids, cells_at_zero, .. } = streamed;
    Ok(WrittenHeights { layer, tiles, payload_bytes, voids, cells_at_zero })
}

/// What came by on the way.
struct Streamed {
    voids: VoidReport,
    /// Whether any cell is left without data.
    has_voids: bool,
    /// Cells of a globe set to 0.
    cells_at_zero: u64,
}

/// Reads all rows through the void filler into the pyramid.
fn stream(
    plan: &LayerPlan,
    (layout, request): (&LayerLayout, &PrepareRequest),
    run: &Run<'_>,
    emit: &mut (impl FnMut(&TileRow<'_, f32>) -> Result<(), PrepareError> + Send),
) -> Result<Streamed, PrepareError> {
    let target = *plan.rows.target();
    let size = (target.width, target.height);
    let mut pyramid = RowPyramid::new(size, plan.level_count, layout, request.shape);
    let (mut has_voids, mut cells_at_zero) = (false, 0);
    let rule = void_rule(request, target.texel_m);
    let mut filler = rule.map(|rule| VoidFill::new(target.width, target.height, rule));
    read_ahead(
        &target,
        "heights",
        run,
        |row, count| plan.rows.height_rows(row, count),
        |rows: Vec<Vec<f32>>| {
            for row in rows {
                let done = match &mut filler {
                    Some(filler) => filler.push(row),
                    None => vec![row],
                };
                for mut row in done {
                    if request.shape == Shape::Globe {
                        cells_at_zero += zero_where_empty(&mut row);
                    }
                    has_voids |= row.iter().any(|height_m| height_m.is_nan());
                    pyramid.push(row, emit)?;
                }
            }
            Ok(())
        },
    )?;
    let voids = filler.map(|filler| filler.report).unwrap_or_default();
    Ok(Streamed { voids, has_voids, cells_at_zero })
}

/// Sets what holds no height to 0; returns how many cells that was.
fn zero_where_empty(row: &mut [f32]) -> u64 {
    let mut count = 0;
    for height_m in row.iter_mut().filter(|height_m| height_m.is_nan()) {
        *height_m = 0.0;
        count += 1;
    }
    count
}

/// Which gaps are filled, of heights in cells of this side.
fn void_rule(request: &PrepareRequest, texel_m: f64) -> Option<VoidRule> {
    if request.keep_voids {
        return None;
    }
    Some(match request.fill_voids_km2 {
        None => VoidRule::Small,
        Some(km2) => VoidRule::Large { most_cells: (km2 * 1e6 / (texel_m * texel_m)) as usize },
    })
}

/// The range of all heights, of a globe that of its ground without any included. Reading everything once before
/// anything is written also finds damaged sources early.
fn scan(plan: &LayerPlan, shape: Shape, run: &Run<'_>) -> Result<HeightRange, PrepareError> {
    let target = *plan.rows.target();
    let (mut min_m, mut max_m) = (f32::INFINITY, f32::NEG_INFINITY);
    read_ahead(
        &target,
        "scanning heights",
        run,
        |row, count| plan.rows.height_rows(row, count),
        |mut rows: Vec<Vec<f32>>| {
            if shape == Shape::Globe {
                rows.iter_mut().for_each(|row| {
                    zero_where_empty(row);
                });
            }
            for height in rows.iter().flatten() {
                // min and max leave NaN out.
                min_m = min_m.min(*height);
                max_m = max_m.max(*height);
            }
            Ok(())
        },
    )?;
    match min_m <= max_m {
        true => Ok(HeightRange { min_m, max_m }),
        false => Err(PrepareError::Request("the height rasters hold no data at all".to_owned())),
    }
}

/// The step heights are snapped to: the largest power of two that loses at most 1 cm or half the
/// source's own step, made finer while the whole range still fits 16 bits (averages of whole metres
/// are no whole metres), down to an eighth of the source's step or 4 mm.
fn height_step_m(range: HeightRange, source_step_m: f64) -> f32 {
    let largest_loss_m = f64::max(0.01, 0.5 * source_step_m);
    let mut step_m = (2.0 * largest_loss_m).log2().floor().exp2();
    let finest_m = f64::max(1.0 / 256.0, source_step_m / 8.0);
    let extent_m = f64::from(range.max_m) - f64::from(range.min_m);
    while step_m / 2.0 >= finest_m && extent_m / (step_m / 2.0) <= 65_500.0 {
        step_m /= 2.0;
    }
    step_m as f32
}

struct HeightEncoder {
    layout: LayerLayout,
    encoding: HeightEncoding,
    step_m: f32,
}

type EncodedTile = (TileId, Option<HeightRange>, Vec<u8>);

impl HeightEncoder {
    fn encode_row(&self, tiles: &TileRow<'_, f32>) -> Vec<EncodedTile> {
        (0..tiles.columns())
            .into_par_iter()
            .filter_map(|column| {
                let heights_m = tiles.tile(column)?;
                let tile = TileId::new(tiles.level, tiles.row, column);
                let (range, payload) = self.encode(&heights_m);
                Some((tile, range, payload))
            })
            .collect()
    }

    fn encode(&self, heights_m: &[f32]) -> (Option<HeightRange>, Vec<u8>) {
        let size = self.layout.stored_size_texels();
        match self.encoding {
            HeightEncoding::Float => (range_of(heights_m), encode_heights_m(heights_m, size)),
            HeightEncoding::Steps => {
                let inverse = 1.0 / f64::from(self.step_m);
                let snap = |&height: &f32| match height.is_nan() {
                    true => NO_DATA_STEPS,
                    false => (f64::from(height) * inverse).round() as i32,
                };
                let steps: Vec<i32> = heights_m.iter().map(snap).collect();
                let range = range_of(heights_m).map(|range| self.snapped(range));
                (range, encode_height_steps(&steps, size, self.step_m))
            }
        }
    }

    fn snapped(&self, range: HeightRange) -> HeightRange {
        let snap = |height: f32| (height / self.step_m).round() * self.step_m;
        HeightRange { min_m: snap(range.min_m), max_m: snap(range.max_m) }
    }
}

fn range_of(heights_m: &[f32]) -> Option<HeightRange> {
    let min_m = heights_m.iter().copied().fold(f32::INFINITY, f32::min);
    let max_m = heights_m.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    (min_m <= max_m).then_some(HeightRange { min_m, max_m })
}

/// Gathers tile ranges into those of the coarse levels: a tile's range holds those of everything
/// below it, so that its box encloses the ground at every level.
struct RangeTable {
    levels: Vec<Vec<Option<HeightRange>>>,
}

impl RangeTable {
    fn new(level_count: u8) -> Self {
        let levels = (0..level_count.min(HeightRanges::MAX_LEVELS))
            .map(|level| vec![None; 1 << (2 * level)])
            .collect();
        Self { levels }
    }

    fn add(&mut self, tile: TileId, range: Option<HeightRange>) {
        let Some(range) = range else { return };
        for (level, ranges) in self.levels.iter_mut().enumerate() {
            if level > usize::from(tile.level) {
                break;
            }
            let ancestor = tile.ancestor_at(level as u8);
            let slot = &mut ranges[((ancestor.row as usize) << level) + ancestor.column as usize];
            let known = slot.unwrap_or(range);
            *slot = Some(HeightRange {
                min_m: known.min_m.min(range.min_m),
                max_m: known.max_m.max(range.max_m),
            });
        }
    }

    fn finish(self) -> HeightRanges {
        HeightRanges { levels: self.levels }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_step_follows_the_sources_own_and_the_range() {
        let range = |max_m: f32| HeightRange { min_m: 0.0, max_m };
        // Whole metres: at most half a metre may be lost, an eighth fits.
        assert_eq!(height_step_m(range(2_000.0), 1.0), 0.125);
        assert_eq!(height_step_m(range(18_000.0), 1.0), 0.5);
        assert_eq!(height_step_m(range(60_000.0), 1.0), 1.0);
        // Floats: 1 cm may be lost, so 1/64 m.
        assert_eq!(height_step_m(range(2_460.0), 0.0), 1.0 / 64.0);
        assert_eq!(height_step_m(range(100.0), 0.0), 1.0 / 256.0);
    }
}
