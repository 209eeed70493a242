//! Imagery continued beyond its finest level by detail made up as it is asked for.

mod detail_patch;
mod real_texels;
mod texel_grid;

use std::path::PathBuf;
use std::sync::Arc;

use self::detail_patch::{DetailLevel, DetailPatch, MARGIN};
use self::real_texels::{Coverage, RealTexels};
use self::texel_grid::{TexelGrid, TexelWindow};
use super::codec::{decode_colours, encode_colours};
use super::{ColourLayer, ColourTile, HeightTile, LoadError, Loaded, Manifest, TileSource};
use crate::srgb::CODE_FROM_LINEAR;
use crate::tiling::{LayerLayout, TileId, TileSet};

/// A source whose imagery goes on below its finest level: the parent's imagery interpolated, with seeded noise of the
/// new octave on it, as strong as the imagery about there is rough.
///
/// Tiles are made one by one when they are loaded, encoded and decoded as those of a file are. Before encoding, the
/// mean of four texels is the texel above them, so levels agree; gutters are the neighbours' texels, on a globe
/// across the date line and the poles too; the same tile comes out however often it is made.
pub struct DetailedSource {
    source: Arc<dyn TileSource>,
    manifest: Manifest,
    /// The imagery's own layout and the layout with all levels.
    layouts: [LayerLayout; 2],
    colours: ColourLayer,
    present: TileSet,
    real: RealTexels,
    seed: u32,
}

/// Why imagery cannot be continued.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DetailError {
    /// There is none.
    #[error("there is no imagery to continue")]
    NoImagery,
    /// It has so many levels already, or there may not be so many.
    #[error(
        "{asked} levels of imagery: the dataset has {real}, give more and at most {}",
        DetailedSource::MOST_LEVELS
    )]
    Levels {
        /// Levels asked for.
        asked: u8,
        /// Levels that there are.
        real: u8,
    },
}

impl DetailedSource {
    /// Most levels in all: the set of tiles has an entry for each row of each level.
    pub const MOST_LEVELS: u8 = 17;

    /// A source with so many levels of imagery in all.
    ///
    /// # Errors
    /// Where the source has no imagery, or as many levels already, or the levels are too many.
    pub fn new(
        source: Arc<dyn TileSource>,
        level_count: u8,
        seed: u32,
    ) -> Result<Self, DetailError> {
        let mut manifest = source.manifest().clone();
        let layer = manifest.colours.as_mut().ok_or(DetailError::NoImagery)?;
        let real_layout = layer.layout;
        let real = real_layout.level_count;
        if level_count <= real || level_count > Self::MOST_LEVELS {
            return Err(DetailError::Levels { asked: level_count, real });
        }
        layer.layout.level_count = level_count;
        let colours = layer.clone();
        let side = i64::from(real_layout.tile_size_texels) << real_layout.finest_level();
        let grid = TexelGrid { shape: manifest.shape, side };
        manifest.notes.push(format!("imagery is made up from level {real} on"));
        Ok(Self {
            present: continued(source.colours_present(), real_layout, level_count),
            real: RealTexels::new(real_layout, grid),
            layouts: [real_layout, colours.layout],
            source,
            manifest,
            colours,
            seed,
        })
    }

    /// A tile's colours and coverage with its gutter, before they are encoded.
    fn rgba(&self, tile: TileId) -> Result<Vec<u8>, LoadError> {
        let depth = tile.level - self.layouts[0].finest_level();
        let window = self.window(tile);
        let (patch, coverage) = self.patch(window, depth)?;
        let code = |light: f32| CODE_FROM_LINEAR[((light * 65535.0 + 0.5) as usize).min(65535)];
        let mut rgba = Vec::with_capacity(4 * window.len());
        for (row, line) in (window.row..).zip(patch.texels.chunks_exact(window.width)) {
            for (column, &[r, g, b, _]) in (window.column..).zip(line) {
                let coverage = coverage.at(column >> depth, row >> depth);
                rgba.extend_from_slice(&[code(r), code(g), code(b), coverage]);
            }
        }
        Ok(rgba)
    }

    /// A window of the level so many below the real imagery, and the coverage of the real texels under it.
    fn patch(&self, window: TexelWindow, depth: u8) -> Result<(DetailPatch, Coverage), LoadError> {
        let mut windows = vec![window];
        let mut real = window;
        for _ in 0..depth {
            real = real.coarser(MARGIN);
            windows.push(real);
        }
        let (mut patch, coverage) = self.real.patch(real, &*self.source)?;
        for (depth, window) in (1..=depth).zip(windows.into_iter().rev().skip(1)) {
            let grid = self.real.grid().finer(depth);
            patch = patch.finer(window, &DetailLevel { grid, depth, seed: self.seed });
        }
        Ok((patch, coverage))
    }

    /// The texels of a tile with its gutter.
    fn window(&self, tile: TileId) -> TexelWindow {
        let [_, layout] = self.layouts;
        let (size, gutter) = (i64::from(layout.tile_size_texels), i64::from(layout.gutter_texels));
        let stored = layout.stored_size_texels() as usize;
        TexelWindow {
            column: i64::from(tile.column) * size - gutter,
            row: i64::from(tile.row) * size - gutter,
            width: stored,
            height: stored,
        }
    }

    fn made(&self, tile: TileId) -> Result<Loaded<ColourTile>, LoadError> {
        let path = PathBuf::from("imagery made up");
        if !self.present.contains(tile) {
            return Err(LoadError::Absent { path, tile });
        }
        let rgba = self.rgba(tile)?;
        let size = self.layouts[1].stored_size_texels();
        let (encoding, format) = (self.colours.encoding, self.colours.format);
        let loaded = encode_colours(&rgba, size, encoding).and_then(|payload| {
            let tile = decode_colours(&payload, tile, size, format)?;
            Ok(Loaded { tile, disk_bytes: payload.len() as u64 })
        });
        loaded.map_err(|error| LoadError::Damaged { path, tile, reason: error.to_string() })
    }
}

/// The tiles there are and all below those of the finest level.
fn continued(real: &TileSet, layout: LayerLayout, level_count: u8) -> TileSet {
    let mut present = real.clone();
    let finest = layout.finest_level();
    for (_, row, (first, last)) in real.runs().filter(|(level, ..)| *level == finest) {
        for level in layout.level_count..level_count {
            let down = level - finest;
            for row in row << down..(row + 1) << down {
                present.insert_run(level, row, (first << down, ((last + 1) << down) - 1));
            }
        }
    }
    present
}

impl TileSource for DetailedSource {
    fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    fn heights_present(&self) -> &TileSet {
        self.source.heights_present()
    }

    fn colours_present(&self) -> &TileSet {
        &self.present
    }

    fn load_heights(&self, tile: TileId) -> Result<Loaded<HeightTile>, LoadError> {
        self.source.load_heights(tile)
    }

    fn load_colours(&self, tile: TileId) -> Result<Loaded<ColourTile>, LoadError> {
        match tile.level < self.layouts[0].level_count {
            true => self.source.load_colours(tile),
            false => self.made(tile),
        }
    }

    fn delay_frames(&self) -> u32 {
        self.source.delay_frames()
    }
}

#[cfg(test)]
mod tests;
