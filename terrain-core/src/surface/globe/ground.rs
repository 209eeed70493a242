use std::collections::HashMap;
use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DVec2, dvec2};

use crate::dataset::HeightTile;
use crate::geodesy::PlateCarree;
use crate::tiling::{Extent, LayerLayout, TileId, TilingScheme};

/// The heights that the globe's mesh is made of: of every point those of the finest tile shown there. So a vertex
/// has one height, whichever patch it belongs to.
pub struct GlobeGround {
    scheme: TilingScheme,
    layout: LayerLayout,
    exaggeration: f64,
    /// Lowest and highest ground anywhere, without exaggeration.
    range_m: [f64; 2],
    shown: HashMap<TileId, Arc<HeightTile>>,
}

impl GlobeGround {
    /// Ground without any tile yet: the ellipsoid. `range_m` is that of all heights there are.
    pub fn new(scheme: TilingScheme, layout: LayerLayout, range_m: [f64; 2]) -> Self {
        Self { scheme, layout, exaggeration: 1.0, range_m, shown: HashMap::new() }
    }

    /// Whether all ground is the ellipsoid itself, whatever tiles are shown.
    pub fn is_level(&self) -> bool {
        self.range_m == [0.0; 2]
    }

    /// Factor on all heights.
    pub fn exaggeration(&self) -> f64 {
        self.exaggeration
    }

    /// Sets the factor on all heights; returns whether that changes anything.
    pub fn exaggerate(&mut self, factor: f64) -> bool {
        let changes = factor != self.exaggeration && !self.is_level();
        self.exaggeration = factor;
        changes
    }

    /// The lowest ground there can be in metres, exaggerated: at most 0.
    pub fn lowest_m(&self) -> f64 {
        (self.range_m[0].min(self.range_m[1]) * self.exaggeration).min(0.0)
    }

    /// The finest samples' distance, metres.
    pub fn finest_texel_m(&self) -> f64 {
        self.layout.texel_size_m(&self.scheme, self.layout.finest_level())
    }

    /// Shows a tile.
    pub fn show(&mut self, tile: Arc<HeightTile>) {
        self.shown.insert(tile.id, tile);
    }

    /// No longer shows a tile; returns whether it did.
    pub fn hide(&mut self, tile: TileId) -> bool {
        self.shown.remove(&tile).is_some()
    }

    /// Whether the tile is shown.
    pub fn shows(&self, tile: TileId) -> bool {
        self.shown.contains_key(&tile)
    }

    /// The tiles shown.
    pub fn tiles(&self) -> impl Iterator<Item = TileId> {
        self.shown.keys().copied()
    }

    /// Bytes that the tiles' samples take.
    pub fn bytes(&self) -> u64 {
        self.shown.values().map(|tile| tile.samples.byte_len()).sum()
    }

    /// The ground that a tile's heights are those of, on the plate carrée.
    pub fn extent(&self, tile: TileId) -> Extent {
        self.scheme.tile_extent(tile)
    }

    /// Height in metres above the ellipsoid, without exaggeration, at metres on the plate carrée, longitudes
    /// within half a turn; `None` where there is no data.
    pub fn height_m(&self, point: DVec2) -> Option<f64> {
        (0..=self.layout.finest_level()).rev().find_map(|level| {
            let tile = self.scheme.tile_at(level, point)?;
            self.shown.get(&tile)?.height_at_m(&self.scheme, &self.layout, point)
        })
    }

    /// Height as it is drawn: exaggerated, and 0 where there is no data.
    pub fn drawn_height_m(&self, point: DVec2) -> f64 {
        if self.is_level() {
            return 0.0;
        }
        self.height_m(point).unwrap_or(0.0) * self.exaggeration
    }

    /// The point with its longitude within half a turn, and its latitude within the poles.
    pub fn within(point: DVec2) -> DVec2 {
        let half_m = PI * PlateCarree::RADIUS_M;
        let longitude_m = (point.x + half_m).rem_euclid(2.0 * half_m) - half_m;
        dvec2(longitude_m, point.y.clamp(-0.5 * half_m, 0.5 * half_m))
    }
}
