//! The colour layer: encoding its tiles.

use std::path::Path;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::plan::LayerPlan;
use super::row_pyramid::{RowPyramid, TileRow};
use super::run::{Run, read_ahead};
use super::texel::LinearColour;
use super::{PrepareError, PrepareRequest};
use crate::dataset::codec::encode_colours;
use crate::dataset::{ArchiveWriteError, ArchiveWriter, ColourEncoding, ColourLayer};
use crate::tiling::{LayerLayout, TileId};

/// A written colour layer.
#[derive(Serialize, Deserialize)]
pub struct WrittenColours {
    /// What the manifest says of it.
    pub layer: ColourLayer,
    /// Number of tiles written.
    pub tiles: u64,
    /// Bytes of their payloads.
    pub payload_bytes: u64,
}

/// Writes all colour tiles to an archive.
pub fn write_colours(
    plan: &LayerPlan,
    request: &PrepareRequest,
    path: &Path,
    run: &Run<'_>,
) -> Result<WrittenColours, PrepareError> {
    let level_count = request.level_limit.unwrap_or(u8::MAX).min(plan.level_count);
    let layout = request.layout(request.colour_tile_texels, level_count);
    let target = *plan.rows.target();
    let size = (target.width, target.height);
    let mut pyramid = RowPyramid::new(size, plan.level_count, &layout, request.shape);
    let mut archive = ArchiveWriter::create(path)?;
    let mut emit = |tiles: &TileRow<'_, LinearColour>| -> Result<(), PrepareError> {
        for encoded in encode_row(tiles, &layout, request.colour_encoding) {
            let (tile, payload) =
                encoded.map_err(|reason| ArchiveWriteError { path: path.to_owned(), reason })?;
            archive.add(tile, &payload)?;
        }
        Ok(())
    };
    read_ahead(
        &target,
        "colours",
        run,
        |row, count| plan.rows.colour_rows(row, count),
        |rows: Vec<Vec<LinearColour>>| {
            rows.into_iter().try_for_each(|row| pyramid.push(row, &mut emit))
        },
    )?;
    let (tiles, payload_bytes) = (archive.present().len(), archive.payload_bytes());
    archive.finish()?;
    let layer =
        ColourLayer { layout, encoding: request.colour_encoding, format: request.colour_format() };
    Ok(WrittenColours { layer, tiles, payload_bytes })
}

fn encode_row(
    tiles: &TileRow<'_, LinearColour>,
    layout: &LayerLayout,
    encoding: ColourEncoding,
) -> Vec<Result<(TileId, Vec<u8>), String>> {
    let size = layout.stored_size_texels();
    (0..tiles.columns())
        .into_par_iter()
        .filter_map(|column| {
            let texels = tiles.tile(column)?;
            let rgba = srgb_of(&texels, size as usize);
            let tile = TileId::new(tiles.level, tiles.row, column);
            let payload = encode_colours(&rgba, size, encoding);
            Some(payload.map(|payload| (tile, payload)).map_err(|error| error.to_string()))
        })
        .collect()
}

/// sRGB and coverage of a tile. Uncovered texels beside covered ones borrow their colour (not their
/// coverage), so that filtering across the edge of a picture darkens nothing.
fn srgb_of(texels: &[LinearColour], size: usize) -> Vec<u8> {
    let mut rgba: Vec<[u8; 4]> = texels.iter().map(|texel| texel.to_srgb()).collect();
    let uncovered = |texel: &[u8; 4]| texel[3] == 0;
    if rgba.iter().any(uncovered) {
        let mut known: Vec<bool> = rgba.iter().map(|texel| !uncovered(texel)).collect();
        // As far as a gutter and its two halvings reach.
        for _ in 0..LayerLayout::GUTTER_TEXELS {
            spread_colours(&mut rgba, &mut known, size);
        }
    }
    rgba.into_flattened()
}

fn spread_colours(rgba: &mut [[u8; 4]], known: &mut [bool], size: usize) {
    let before = known.to_vec();
    for index in (0..rgba.len()).filter(|&index| !before[index]) {
        let (row, column) = (index / size, index % size);
        let near = [
            (column > 0).then(|| index - 1),
            (column + 1 < size).then(|| index + 1),
            (row > 0).then(|| index - size),
            (row + 1 < size).then(|| index + size),
        ];
        if let Some(from) = near.into_iter().flatten().find(|&near| before[near]) {
            let [r, g, b, _] = rgba[from];
            rgba[index] = [r, g, b, 0];
            known[index] = true;
        }
    }
}
