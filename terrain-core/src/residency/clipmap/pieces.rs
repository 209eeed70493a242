use super::TexelRect;
use crate::tiling::{LayerLayout, TileId};

/// A part of a rectangle that lies in one tile and in one part of the texture that does not wrap round.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Piece {
    /// The tile its texels come from.
    pub tile: TileId,
    /// Column and row of its first texel in the stored tile, gutter counted.
    pub source: [u32; 2],
    /// Column and row of its first texel in the texture.
    pub target: [u32; 2],
    /// Width and height in texels.
    pub size: [u32; 2],
}

/// The tiles that hold the texels of a rectangle of the level, row by row.
pub fn tiles_under(
    rect: &TexelRect,
    layout: &LayerLayout,
    level: u8,
) -> impl Iterator<Item = TileId> + use<> {
    let size = layout.tile_size_texels;
    let columns = rect.west / size..rect.east.div_ceil(size);
    let rows = if rect.is_empty() { 0..0 } else { rect.north / size..rect.south.div_ceil(size) };
    rows.flat_map(move |row| columns.clone().map(move |column| TileId::new(level, row, column)))
}

/// The pieces of a rectangle of the level for a texture of `texture_size` texels a side: texel (column,
/// row) of the level has its place at (column mod size, row mod size).
pub fn pieces(rect: &TexelRect, layout: &LayerLayout, level: u8, texture_size: u32) -> Vec<Piece> {
    let tile_size = layout.tile_size_texels;
    let columns = spans(rect.west, rect.east, tile_size, texture_size);
    let rows = spans(rect.north, rect.south, tile_size, texture_size);
    let piece = |&(row, height): &(u32, u32), &(column, width): &(u32, u32)| Piece {
        tile: TileId::new(level, row / tile_size, column / tile_size),
        source: [column, row].map(|at| at % tile_size + layout.gutter_texels),
        target: [column, row].map(|at| at % texture_size),
        size: [width, height],
    };
    rows.iter().flat_map(|row| columns.iter().map(move |column| piece(row, column))).collect()
}

/// The range cut where a tile ends and where the texture wraps round: starts and lengths.
fn spans(from: u32, to: u32, tile_size: u32, texture_size: u32) -> Vec<(u32, u32)> {
    let mut spans = Vec::new();
    let mut at = from;
    while at < to {
        let next = |size: u32| (at / size + 1).saturating_mul(size);
        let end = to.min(next(tile_size)).min(next(texture_size));
        spans.push((at, end - at));
        at = end;
    }
    spans
}
