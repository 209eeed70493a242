use serde::{Deserialize, Serialize};

use super::{Extent, TileId, TilingScheme};

/// How the tiles of one layer (heights or colours) are cut into texels.
///
/// Texels are *areas*: texel (r, c) of a tile without its gutter has its centre at
/// `((c + 0.5), (r + 0.5)) * texel_size_m` from the tile's north-west corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LayerLayout {
    /// Texels along one side of a tile, gutter not counted. A multiple of 8.
    pub tile_size_texels: u32,
    /// Texels each stored tile repeats from its neighbours on every side. A multiple of 4.
    pub gutter_texels: u32,
    /// Number of levels of the layer; its finest is `level_count - 1`. At least 1.
    pub level_count: u8,
}

impl LayerLayout {
    /// The gutter of every tile the project writes. Two halvings leave a gutter of one texel, so a
    /// tile can be filtered bilinearly right up to its border at its own and two coarser scales; a
    /// multiple of 4 keeps compressed blocks whole.
    pub const GUTTER_TEXELS: u32 = 4;

    /// Texels along one side of a stored tile, gutter counted.
    pub fn stored_size_texels(&self) -> u32 {
        self.tile_size_texels + 2 * self.gutter_texels
    }

    /// Texels of so many stored tiles, gutters counted.
    pub fn stored_texels(&self, tiles: usize) -> u64 {
        tiles as u64 * u64::from(self.stored_size_texels()).pow(2)
    }

    /// The finest level of the layer.
    pub fn finest_level(&self) -> u8 {
        self.level_count.saturating_sub(1)
    }

    /// Side of a texel in metres at the level.
    pub fn texel_size_m(&self, scheme: &TilingScheme, level: u8) -> f64 {
        scheme.tile_size_m(level) / f64::from(self.tile_size_texels)
    }

    /// The ground a stored tile covers, gutter counted.
    pub fn stored_extent(&self, scheme: &TilingScheme, tile: TileId) -> Extent {
        let margin_m = self.texel_size_m(scheme, tile.level) * f64::from(self.gutter_texels);
        scheme.tile_extent(tile).grown(margin_m)
    }
}
