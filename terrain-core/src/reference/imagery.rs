//! The imagery under a piece of ground.

use std::sync::Arc;

use glam::{DVec2, Vec3, Vec4, dvec2};

use super::footprint::Footprint;
use super::lazy_tiles::LazyTiles;
use crate::dataset::{ColourTile, LoadError, Shape, TileSource};
use crate::srgb::LINEAR_FROM_CODE;
use crate::surface::globe::GlobeGround;
use crate::tiling::{Extent, LayerLayout, TilingScheme};

/// Most taps along a footprint's longer axis. Longer ones are filtered from coarser texels.
const MOST_TAPS: f64 = 16.0;

/// The colour layer of a source.
pub(super) struct Imagery {
    scheme: TilingScheme,
    layout: LayerLayout,
    data_extent: Extent,
    /// Whether what ends in the east goes on in the west.
    is_round: bool,
    tiles: LazyTiles<ColourGrid>,
}

/// One decoded tile.
struct ColourGrid {
    origin: DVec2,
    texel_m: f64,
    stored: usize,
    gutter: f64,
    /// sRGB and coverage, row by row.
    texels: Vec<[u8; 4]>,
}

impl Imagery {
    /// The source's imagery, where it has any.
    pub fn open(source: &Arc<dyn TileSource>) -> Option<Self> {
        let manifest = source.manifest();
        let layout = manifest.colours.as_ref()?.layout;
        if source.colours_present().is_empty() {
            return None;
        }
        let scheme = manifest.scheme;
        let is_round = manifest.shape == Shape::Globe;
        let loading = Arc::clone(source);
        let tiles = LazyTiles::new(scheme, source.colours_present().clone(), move |tile| {
            let loaded = loading.load_colours(tile)?;
            let grid = ColourGrid::new(&scheme, &layout, loaded.tile);
            let bytes = size_of_val(grid.texels.as_slice()) as u64;
            Ok((grid, bytes))
        });
        Some(Self { scheme, layout, data_extent: manifest.data_extent, is_round, tiles })
    }

    /// The mean colour under a footprint around a point: linear light, and how much of it is covered
    /// by imagery. The colour is weighted by that.
    ///
    /// From the coarsest level whose texels are no larger than the footprint is wide, or with
    /// `finest` from the finest one; bilinear taps stand no farther apart than texels.
    pub fn mean_under(&self, point: DVec2, footprint: &Footprint, finest: bool) -> (Vec3, f32) {
        let level = if finest { self.layout.finest_level() } else { self.level_for(footprint) };
        let texel_m = self.layout.texel_size_m(&self.scheme, level);
        let most = if finest { f64::INFINITY } else { MOST_TAPS };
        let taps = (footprint.length_m() / texel_m).ceil().clamp(1.0, most) as u32;
        let mut sum = Vec4::ZERO;
        for tap in 0..taps {
            let part = (f64::from(tap) + 0.5) / f64::from(taps) - 0.5;
            sum += self.bilinear(point + footprint.long_axis_m * part, level);
        }
        let mean = sum / taps as f32;
        (mean.truncate(), mean.w)
    }

    /// The mean colour under a footprint on a globe's ground around a point of the map, as [`Self::mean_under`] has
    /// it. Rows of texels at high latitudes are shorter than those of the equator: `cos_latitude` times as long.
    pub fn mean_on_globe(
        &self,
        point: DVec2,
        footprint: &Footprint,
        cos_latitude: f64,
        finest: bool,
    ) -> (Vec3, f32) {
        let level = if finest { self.layout.finest_level() } else { self.level_for(footprint) };
        let texel_m = self.layout.texel_size_m(&self.scheme, level);
        let most = if finest { f64::INFINITY } else { MOST_TAPS };
        let taps = (footprint.length_m() / texel_m).ceil().clamp(1.0, most) as u32;
        let half_row_m = 0.5 * self.data_extent.size_m().x;
        let along = footprint.long_axis_m.x / cos_latitude.max(1.0e-9);
        let axis = dvec2(along.clamp(-half_row_m, half_row_m), footprint.long_axis_m.y);
        let mut sum = Vec4::ZERO;
        for tap in 0..taps {
            let part = (f64::from(tap) + 0.5) / f64::from(taps) - 0.5;
            sum += self.bilinear(GlobeGround::within(point + axis * part), level);
        }
        let mean = sum / taps as f32;
        (mean.truncate(), mean.w)
    }

    fn level_for(&self, footprint: &Footprint) -> u8 {
        let finest = self.layout.finest_level();
        let wanted_m = footprint.width_m.max(footprint.length_m() / MOST_TAPS);
        let texel_m = self.layout.texel_size_m(&self.scheme, finest);
        let up = (wanted_m / texel_m).log2().floor().clamp(0.0, f64::from(finest));
        finest - up as u8
    }

    /// Premultiplied linear colour and coverage at a point, bilinear; nothing where no tile holds it.
    fn bilinear(&self, point: DVec2, level: u8) -> Vec4 {
        let extent = &self.data_extent;
        let inside = point.max(extent.min).min(extent.max);
        let tile = self.scheme.tile_at(level, inside).and_then(|tile| self.tiles.nearest(tile));
        let Some(grid) = tile.and_then(|tile| self.tiles.content(tile)) else { return Vec4::ZERO };
        // Imagery ends with the data; its outermost texels go on to the very edge.
        let mut margin = DVec2::splat(0.5 * grid.texel_m);
        if self.is_round {
            margin.x = 0.0;
        }
        grid.bilinear(inside.max(extent.min + margin).min(extent.max - margin))
    }

    /// Bytes that the tiles read so far take in memory.
    pub fn loaded_bytes(&self) -> u64 {
        self.tiles.loaded_bytes()
    }

    /// The first tile that could not be read.
    pub fn failure(&self) -> Option<&LoadError> {
        self.tiles.failure()
    }
}

impl ColourGrid {
    fn new(scheme: &TilingScheme, layout: &LayerLayout, tile: ColourTile) -> Self {
        let origin = scheme.tile_origin(tile.id);
        let texel_m = layout.texel_size_m(scheme, tile.id.level);
        let tile = tile.into_rgba8();
        let texels = tile.data.chunks_exact(4).map(|t| [t[0], t[1], t[2], t[3]]).collect();
        let gutter = f64::from(layout.gutter_texels);
        Self { origin, texel_m, stored: tile.stored_size_texels as usize, gutter, texels }
    }

    /// As a texture unit filters it: colour and coverage each bilinear, the colour in linear light.
    fn bilinear(&self, point: DVec2) -> Vec4 {
        let from_corner = dvec2(point.x - self.origin.x, self.origin.y - point.y) / self.texel_m;
        let place = from_corner + self.gutter - 0.5;
        let most = (self.stored - 2) as f64;
        let low = place.floor().clamp(DVec2::ZERO, DVec2::splat(most));
        let part = (place - low).clamp(DVec2::ZERO, DVec2::ONE).as_vec2();
        let nw = low.y as usize * self.stored + low.x as usize;
        let texel = |index: usize| linear(self.texels[index]);
        let north = texel(nw).lerp(texel(nw + 1), part.x);
        let south = texel(nw + self.stored).lerp(texel(nw + self.stored + 1), part.x);
        let straight = north.lerp(south, part.y);
        (straight.truncate() * straight.w).extend(straight.w)
    }
}

fn linear([r, g, b, coverage]: [u8; 4]) -> Vec4 {
    let table = &*LINEAR_FROM_CODE;
    let of = |code: u8| table[usize::from(code)];
    Vec4::new(of(r), of(g), of(b), f32::from(coverage) / 255.0)
}
