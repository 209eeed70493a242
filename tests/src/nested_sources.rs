use std::sync::Arc;

use glam::{DVec2, dvec2};
use terrain_core::tiling::TileId;

use crate::{AnalyticSource, Ridges};

/// A source of [`Ridges`] of 2^13 texels a side, and ones larger by powers of two of which it is a tile:
/// the same ground under the same tiles, with more round it.
pub struct NestedSources {
    /// Texels along a side of the tiles of heights and colours.
    pub tile_sizes_texels: [u32; 2],
}

impl NestedSources {
    /// Side of the smallest source, metres: 2^13 texels of 8 m. Its middle is the world's origin.
    pub const SMALLEST_M: f64 = 65_536.0;
    /// Its levels.
    pub const SMALLEST_LEVELS: u8 = 7;

    /// The source larger by `extra_levels` powers of two. The height ranges of all levels but the last are
    /// known: what selection knows of a place is the same in all sources.
    pub fn source(&self, extra_levels: u8) -> Arc<AnalyticSource> {
        let source = self.source_without_ranges(extra_levels);
        Arc::new(source.with_height_ranges(Self::SMALLEST_LEVELS + extra_levels - 1))
    }

    /// The same with no range known but the root's.
    pub fn source_without_ranges(&self, extra_levels: u8) -> AnalyticSource {
        let factor = f64::from(1_u32 << extra_levels);
        let tile = smallest_in(extra_levels).as_dvec2();
        let north_west = (dvec2(-0.5, 0.5) - dvec2(tile.x, -tile.y)) * Self::SMALLEST_M;
        let centre = north_west + dvec2(0.5, -0.5) * factor * Self::SMALLEST_M;
        let levels = [Self::SMALLEST_LEVELS + extra_levels; 2];
        AnalyticSource::new(Ridges::surface(), centre, factor * Self::SMALLEST_M, levels)
            .with_surface_about(DVec2::ZERO)
            .with_tile_sizes(self.tile_sizes_texels)
    }

    /// A tile of the source larger by `extra_levels` as the smallest source has it; `None` for one that
    /// holds the smallest source or more, or nothing of it.
    pub fn in_smallest(tile: TileId, extra_levels: u8) -> Option<TileId> {
        let level = tile.level.checked_sub(extra_levels).filter(|level| *level > 0)?;
        let corner = smallest_in(extra_levels) << u32::from(level);
        let row = tile.row.checked_sub(corner.y)?;
        let column = tile.column.checked_sub(corner.x)?;
        (row.max(column) < 1 << level).then(|| TileId::new(level, row, column))
    }
}

/// Column and row of the smallest source among the tiles of its size: somewhere, neither in the middle
/// of the larger one nor at its edge.
fn smallest_in(extra_levels: u8) -> glam::UVec2 {
    (dvec2(0.58, 0.42) * f64::from(1_u32 << extra_levels)).floor().as_uvec2()
}
