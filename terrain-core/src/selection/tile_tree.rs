use super::eye_units::EyeUnits;
use crate::dataset::{HeightRanges, Shape, TileSource};
use crate::tiling::{Extent, LayerLayout, TileId, TileSet, TilingScheme};

/// What selection knows of a dataset: where its tiles lie and which exist. No payloads.
#[derive(Clone, Debug)]
pub struct TileTree {
    /// Where the root lies.
    pub scheme: TilingScheme,
    /// The ground that holds data.
    pub data_extent: Extent,
    /// What the ground lies on.
    pub shape: Shape,
    /// The height layer.
    pub heights: LayerTree,
    /// The colour layer, where there is imagery.
    pub colours: Option<LayerTree>,
    /// Height ranges of the coarse tiles.
    pub height_ranges: HeightRanges,
}

/// One layer of a [`TileTree`].
#[derive(Clone, Debug)]
pub struct LayerTree {
    /// Tile and pyramid sizes.
    pub layout: LayerLayout,
    /// The tiles that exist.
    pub present: TileSet,
}

impl TileTree {
    /// The tree of a source.
    pub fn of_source(source: &dyn TileSource) -> Self {
        let manifest = source.manifest();
        Self {
            scheme: manifest.scheme,
            data_extent: manifest.data_extent,
            shape: manifest.shape,
            heights: LayerTree {
                layout: manifest.heights.layout,
                present: source.heights_present().clone(),
            },
            colours: manifest.colours.as_ref().map(|layer| LayerTree {
                layout: layer.layout,
                present: source.colours_present().clone(),
            }),
            height_ranges: manifest.heights.ranges.clone(),
        }
    }

    /// Whether the tile exists in either layer.
    pub fn contains(&self, tile: TileId) -> bool {
        self.heights.present.contains(tile)
            || self.colours.as_ref().is_some_and(|layer| layer.present.contains(tile))
    }

    /// Whether the tile's ground holds no data in either layer, at any level.
    ///
    /// Not the same as a tile that does not exist: a layer that ends at a coarser level still has
    /// data there.
    pub fn is_empty_ground(&self, tile: TileId) -> bool {
        let is_empty_in = |layer: &LayerTree| {
            !layer.present.contains(tile.ancestor_at(layer.layout.finest_level()))
        };
        is_empty_in(&self.heights) && self.colours.as_ref().is_none_or(is_empty_in)
    }

    /// The finest level of either layer.
    pub fn finest_level(&self) -> u8 {
        let colours = self.colours.as_ref().map_or(0, |layer| layer.layout.finest_level());
        self.heights.layout.finest_level().max(colours)
    }

    /// Side in metres of the finest texel a tile of the level offers: the colour layer's where there
    /// is one, else the height layer's. This is what a tile's projected size is judged by.
    pub fn texel_size_m(&self, level: u8) -> f64 {
        let layout = self.colours.as_ref().map_or(self.heights.layout, |layer| layer.layout);
        layout.texel_size_m(&self.scheme, level)
    }

    /// Squared distance in units from the eye to the nearest point the tile's ground may have: the box
    /// of its extent and its (exaggerated) height range.
    pub(super) fn squared_distance(&self, tile: TileId, eye: &EyeUnits) -> u64 {
        eye.squared_distance(tile, eye.heights(self.height_ranges.range(tile)))
    }
}
