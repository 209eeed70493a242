use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::grid_walk::{Ray, Search};
use super::height_grid::HeightGrid;
use super::imagery::Imagery;
use super::lazy_tiles::LazyTiles;
use super::ray_box::part_within_box;
use super::tile_walk::{Ground, TileWalk};
use crate::dataset::{LoadError, Shape, TileSource};
use crate::selection::TileTree;
use crate::tiling::TileId;

/// The full-resolution data of a source, read tile by tile as it is needed and kept in memory.
///
/// May be used from many threads at once. Ground whose tiles cannot be read counts as ground
/// without data; [`ReferenceScene::check`] tells. Points and rays are those of the dataset's map, of a globe as well.
pub struct ReferenceScene {
    shape: Shape,
    pub(super) tree: TileTree,
    pub(super) imagery: Option<Imagery>,
    heights: LazyTiles<HeightGrid>,
    /// Heights of all ground, metres.
    pub(super) range_m: [f64; 2],
}

/// Why there is no reference.
#[derive(Debug, thiserror::Error)]
pub enum ReferenceError {
    /// A tile could not be read.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// The source has no level 0.
    #[error("the dataset holds no heights: its coarsest tile is missing; prepare it again")]
    NoHeights,
    /// The picture has no pixels, or the camera's numbers make no view.
    #[error("no picture can be taken: {0}")]
    View(&'static str),
    /// It was called off.
    #[error("called off")]
    Cancelled,
}

/// Where a ray meets the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceHit {
    /// The point: x, y in metres of the CRS, z with the exaggeration.
    pub point: DVec3,
    /// Metres from the ray's origin.
    pub distance_m: f64,
    /// Gradient of the bilinear surface there, without exaggeration: dz/dx and dz/dy, metres up per
    /// metre east and north.
    pub slope: DVec2,
}

impl ReferenceScene {
    /// The scene of a source. Reads no tile yet.
    ///
    /// # Errors
    /// [`ReferenceError::NoHeights`] where level 0 is missing.
    pub fn open(source: Arc<dyn TileSource>) -> Result<Self, ReferenceError> {
        let tree = TileTree::of_source(&*source);
        if !tree.heights.present.contains(TileId::ROOT) {
            return Err(ReferenceError::NoHeights);
        }
        let shape = source.manifest().shape;
        let layer = &source.manifest().heights;
        // The outermost point of the data has half of its weights; a little less for rounding.
        let least_share = if layer.has_voids { 0.5 - 1e-9 } else { 1e-9 };
        let range_m = [layer.range.min_m, layer.range.max_m].map(f64::from);
        let imagery = Imagery::open(&source);
        let (scheme, layout) = (tree.scheme, tree.heights.layout);
        let heights = LazyTiles::new(scheme, tree.heights.present.clone(), move |tile| {
            let loaded = source.load_heights(tile)?;
            let grid = HeightGrid::new(&scheme, &layout, &loaded.tile, least_share);
            let bytes = grid.byte_len();
            Ok((grid, bytes))
        });
        Ok(Self { shape, tree, imagery, heights, range_m })
    }

    /// Whether all that was touched so far could be read.
    ///
    /// # Errors
    /// [`ReferenceError::Load`] with the first tile that could not.
    pub fn check(&self) -> Result<(), ReferenceError> {
        let of_imagery = self.imagery.as_ref().and_then(Imagery::failure);
        match self.heights.failure().or(of_imagery) {
            Some(failure) => Err(failure.clone().into()),
            None => Ok(()),
        }
    }

    /// What the ground lies on.
    pub fn shape(&self) -> Shape {
        self.shape
    }

    /// Bytes of memory that the tiles read so far take.
    pub fn loaded_bytes(&self) -> u64 {
        self.heights.loaded_bytes() + self.imagery.as_ref().map_or(0, Imagery::loaded_bytes)
    }

    /// Height in metres above the datum, without exaggeration, of the exact surface at a world point;
    /// `None` outside or where there is no data.
    pub fn height_m(&self, point: DVec2) -> Option<f64> {
        let grid = self.grid_at(point)?;
        grid.height_m(grid.place_of(point))
    }

    /// The slope that is lit at a world point, without exaggeration: dz/dx and dz/dy, bilinear
    /// between the central differences of the samples; zero where there is no data.
    pub fn lit_slope(&self, point: DVec2) -> DVec2 {
        self.grid_at(point).map_or(DVec2::ZERO, |grid| grid.lit_slope(grid.place_of(point)))
    }

    /// Where the ray first goes from above to below the surface, whose heights are multiplied by
    /// `exaggeration` (not negative). The surface is seen from above only, as it is drawn: a ray from
    /// below passes it. An origin on the surface counts as above it.
    ///
    /// `direction` may have any length but 0. Rays of which a number is not finite meet nothing.
    pub fn first_hit(
        &self,
        origin: DVec3,
        direction: DVec3,
        exaggeration: f64,
    ) -> Option<SurfaceHit> {
        self.search(origin, direction, exaggeration, Search::Bounded)
    }

    /// The same without bounds: every patch along the ray is looked at. Slow; it exists so that
    /// [`Self::first_hit`], which gives the same bit for bit, can be held against it.
    pub fn first_hit_exhaustive(
        &self,
        origin: DVec3,
        direction: DVec3,
        exaggeration: f64,
    ) -> Option<SurfaceHit> {
        self.search(origin, direction, exaggeration, Search::Exhaustive)
    }

    fn search(
        &self,
        origin: DVec3,
        direction: DVec3,
        exaggeration: f64,
        search: Search,
    ) -> Option<SurfaceHit> {
        let direction = direction.try_normalize()?;
        if !(origin.is_finite() && exaggeration.is_finite() && exaggeration >= 0.0) {
            return None;
        }
        let slack_m = 1e-6 + 1e-12 * origin.abs().max_element();
        let ray = Ray { origin, direction, exaggeration, slack_m };
        let heights_m = [
            self.range_m[0] * exaggeration - 2.0 * slack_m,
            self.range_m[1] * exaggeration + 2.0 * slack_m,
        ];
        let extent = &self.tree.data_extent;
        let corners = [extent.min.extend(heights_m[0]), extent.max.extend(heights_m[1])];
        let [from, to] = part_within_box(origin, direction, corners)?;
        let ground = Ground { tiles: &self.heights, ranges: &self.tree.height_ranges };
        let (grid, hit) = TileWalk::new(ground, ray, search).first_hit(from, to)?;
        Some(SurfaceHit {
            point: origin + hit.distance_m * direction,
            distance_m: hit.distance_m,
            slope: grid.gradient(hit.cell, hit.within),
        })
    }

    /// The grid that shows a point of the data.
    fn grid_at(&self, point: DVec2) -> Option<&HeightGrid> {
        if !self.tree.data_extent.contains(point) {
            return None;
        }
        let finest = self.tree.heights.layout.finest_level();
        let tile = self.tree.scheme.tile_at(finest, point)?;
        self.heights.content(self.heights.nearest(tile)?)
    }
}
