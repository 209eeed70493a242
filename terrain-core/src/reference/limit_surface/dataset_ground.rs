//! What a limit-triangulated surface is made of, read from a dataset window by window.

use std::collections::{HashMap, HashSet};
use std::ops::Range;

use glam::{DVec2, dvec2};
use rayon::prelude::*;

use super::{LimitGrid, LimitSurfaceError, MipTexture};
use crate::dataset::{ColourTile, HeightTile, TileSource};
use crate::tiling::{Extent, LayerLayout, TileId, TileSet, TilingScheme};

/// Heights in metres above the datum at the nodes of some rows of a grid, from the finest tiles there
/// are; NaN where there is no data.
///
/// # Errors
/// Where a tile cannot be loaded.
pub fn node_heights_m(
    source: &dyn TileSource,
    grid: &LimitGrid,
    rows: Range<u32>,
    vertical_exaggeration: f64,
) -> Result<Vec<f32>, LimitSurfaceError> {
    let manifest = source.manifest();
    let (scheme, layout) = (manifest.scheme, manifest.heights.layout);
    let present = source.heights_present();
    let north_west = grid.node(rows.start, 0);
    let south_east = grid.node(rows.end.max(1) - 1, grid.columns);
    let window = Extent::new(dvec2(north_west.x, south_east.y), dvec2(south_east.x, north_west.y));
    let finest = layout.finest_level();
    let wanted = tiles_over(&scheme, finest, &window);
    let sources: HashSet<TileId> =
        wanted.filter_map(|tile| finest_present(present, tile)).collect();
    let tiles = sources
        .into_par_iter()
        .map(|tile| Ok((tile, source.load_heights(tile)?.tile)))
        .collect::<Result<HashMap<TileId, HeightTile>, LimitSurfaceError>>()?;
    let height_m = |point: DVec2| {
        let tile = scheme.tile_at(finest, point).and_then(|tile| finest_present(present, tile))?;
        tiles.get(&tile)?.height_at_m(&scheme, &layout, point)
    };
    let row_heights = |row: u32| {
        let at = |column: u32| {
            let height_m = height_m(grid.node(row, column));
            height_m.map_or(f32::NAN, |height_m| (height_m * vertical_exaggeration) as f32)
        };
        (0..=grid.columns).map(at).collect::<Vec<f32>>()
    };
    Ok(rows.into_par_iter().flat_map_iter(row_heights).collect())
}

/// The finest imagery over an extent, with mip levels. `None` without a colour layer.
///
/// The window begins and ends at multiples of 256 texels of the root, so that windows side by side
/// have the same texels at their common border on the first eight mip levels.
///
/// # Errors
/// Where a tile cannot be loaded.
pub fn texture_window(
    source: &dyn TileSource,
    extent: &Extent,
) -> Result<Option<MipTexture>, LimitSurfaceError> {
    let manifest = source.manifest();
    let Some(layer) = &manifest.colours else { return Ok(None) };
    let layout = layer.layout;
    let window = TexelWindow::over(&manifest.scheme, &layout, extent);
    let tiles: Vec<TileId> = window.tiles(&layout).collect();
    let present = source.colours_present();
    let pieces = tiles
        .into_par_iter()
        .filter_map(|tile| finest_present(present, tile).map(|from| (tile, from)))
        .map(|(tile, from)| Ok((tile, source.load_colours(from)?.tile.into_rgba8())))
        .collect::<Result<Vec<(TileId, ColourTile)>, LimitSurfaceError>>()?;
    let mut texels = vec![[0; 4]; window.columns() * window.rows()];
    for (tile, from) in &pieces {
        window.copy(&layout, *tile, from, &mut texels);
    }
    let size = [window.columns(), window.rows()];
    Ok(Some(MipTexture::new(window.origin(), window.texel_m, size, texels)))
}

/// The finest tile there is that covers this one.
fn finest_present(present: &TileSet, tile: TileId) -> Option<TileId> {
    (0..=tile.level).rev().map(|level| tile.ancestor_at(level)).find(|tile| present.contains(*tile))
}

/// The tiles of a level that an extent within the root touches.
fn tiles_over(
    scheme: &TilingScheme,
    level: u8,
    extent: &Extent,
) -> impl Iterator<Item = TileId> + use<> {
    let root = scheme.root_extent();
    let inside = |point: DVec2| point.clamp(root.min, root.max);
    let at = |x: f64, y: f64| scheme.tile_at(level, inside(dvec2(x, y))).unwrap_or(TileId::ROOT);
    let first = at(extent.min.x, extent.max.y);
    let last = at(extent.max.x, extent.min.y);
    (first.row..=last.row).flat_map(move |row| {
        (first.column..=last.column).map(move |column| TileId::new(level, row, column))
    })
}

/// Texels of a layer's finest level, counted from the root's north-western corner.
struct TexelWindow {
    level: u8,
    texel_m: f64,
    root_corner: DVec2,
    column_range: Range<u64>,
    row_range: Range<u64>,
}

impl TexelWindow {
    const ALIGNMENT: u64 = 256;

    fn over(scheme: &TilingScheme, layout: &LayerLayout, extent: &Extent) -> Self {
        let level = layout.finest_level();
        let texel_m = layout.texel_size_m(scheme, level);
        let root_texels = u64::from(layout.tile_size_texels) << level;
        let range = |from_m: f64, to_m: f64| {
            let first = (from_m / texel_m).floor().max(0.0) as u64 / Self::ALIGNMENT;
            let last = ((to_m / texel_m).ceil().max(0.0) as u64).div_ceil(Self::ALIGNMENT);
            let first = (first * Self::ALIGNMENT).min(root_texels - 1);
            first..(last * Self::ALIGNMENT).clamp(first + 1, root_texels)
        };
        let corner = scheme.origin;
        Self {
            level,
            texel_m,
            root_corner: corner,
            column_range: range(extent.min.x - corner.x, extent.max.x - corner.x),
            row_range: range(corner.y - extent.max.y, corner.y - extent.min.y),
        }
    }

    fn columns(&self) -> usize {
        (self.column_range.end - self.column_range.start) as usize
    }

    fn rows(&self) -> usize {
        (self.row_range.end - self.row_range.start) as usize
    }

    fn origin(&self) -> DVec2 {
        let texels = dvec2(self.column_range.start as f64, -(self.row_range.start as f64));
        self.root_corner + texels * self.texel_m
    }

    fn tiles(&self, layout: &LayerLayout) -> impl Iterator<Item = TileId> + use<> {
        let side = u64::from(layout.tile_size_texels);
        let tiles =
            |texels: &Range<u64>| (texels.start / side) as u32..=((texels.end - 1) / side) as u32;
        let (level, columns) = (self.level, tiles(&self.column_range));
        tiles(&self.row_range)
            .flat_map(move |row| columns.clone().map(move |column| TileId::new(level, row, column)))
    }

    /// Copies what the window shows of a tile, from the tile itself or magnified from an ancestor.
    fn copy(&self, layout: &LayerLayout, tile: TileId, from: &ColourTile, texels: &mut [[u8; 4]]) {
        let side = u64::from(layout.tile_size_texels);
        let (west, north) = (u64::from(tile.column) * side, u64::from(tile.row) * side);
        let up = tile.level - from.id.level;
        let within = |texel: u64, ancestor: u32| {
            (texel >> up) - u64::from(ancestor) * side + u64::from(layout.gutter_texels)
        };
        let rows = north.max(self.row_range.start)..(north + side).min(self.row_range.end);
        for row in rows {
            let source_row = within(row, from.id.row) as usize;
            let target = (row - self.row_range.start) as usize * self.columns();
            let columns =
                west.max(self.column_range.start)..(west + side).min(self.column_range.end);
            for column in columns {
                let source_column = within(column, from.id.column) as usize;
                let start = 4 * (source_row * from.stored_size_texels as usize + source_column);
                let texel = &mut texels[target + (column - self.column_range.start) as usize];
                texel.copy_from_slice(&from.data[start..start + 4]);
            }
        }
    }
}
