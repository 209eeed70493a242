use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::eye_units::{EyeUnits, SplitDistances};
use super::sort_keys::{FarthestOrder, PriorityOrder};
use super::subdivide::LISTED_AT_MOST;
use super::view_pyramid::{ViewPyramid, WorldBox};
use super::{
    SeenGround, Selection, SelectionConfig, SelectionStatistics, SelectionStrategy, TileTree,
};
use crate::CameraView;
use crate::tiling::TileId;

/// The traditional way, [`select_by_frustum`], as a strategy.
pub(super) struct CpuFrustum;

impl SelectionStrategy for CpuFrustum {
    fn needs_region(&self) -> bool {
        false
    }

    fn select(
        &self,
        tree: &TileTree,
        _seen: Option<SeenGround<'_>>,
        view: &CameraView,
        config: &SelectionConfig,
    ) -> Selection {
        select_by_frustum(tree, view, config)
    }
}

/// Tiles by the view frustum and their screen-space error, without a look at what the GPU drew: what
/// most terrain engines do.
///
/// From level 0 on, the tile with the largest error is split until every tile's error is at most
/// [`SelectionConfig::texel_px`] or the next split would go beyond [`SelectionConfig::max_tiles`]
/// (never beyond 65,536 tiles).
/// - A tile's error is the one [`subdivide()`](super::subdivide()) goes by: the size in pixels of its
///   texel at its nearest point. The settings of both strategies mean the same.
/// - Splitting a tile adds those of its children that exist and whose boxes (their extent within the
///   data's, and their exaggerated height range) meet the view frustum.
/// - Split tiles stay: with a tile all its ancestors are selected. As the coarsest are loaded first,
///   the picture refines step by step, and where a tile is late, or ground comes into view at the
///   border of the picture, one little coarser stands in.
/// - A limit on the number of tiles acts as a larger bound on the error, the same for all: the nearest
///   get the most. Of equal errors the coarsest tile is split first, then by row and column.
///
/// Sources. A quadtree of chunks refined to a bound on the error: T. Ulrich, "Rendering Massive
/// Terrains using Chunked Level of Detail Control", 2002. A budget held by a queue that splits the
/// largest error first: M. Duchaineau et al., "ROAMing Terrain: Real-time Optimally Adapting Meshes",
/// 1997. Boxes by height ranges: F. Strugar, "Continuous Distance-Dependent Level of Detail for
/// Rendering Heightmaps", 2009. Ancestors kept and the coarsest loaded first: P. Cozzi and K. Ring,
/// "3D Engine Design for Virtual Globes", 2011.
///
/// Departures. The mesh is the renderer's, so a tile stands for its texels and its error is theirs.
/// Splitting does not wait for children to be loaded: what stands in for a late tile is decided when
/// the tables are made. Boxes are tested against the frustum itself, not each of its planes. There is
/// no guard band, since the ancestors serve as one; no hysteresis, since the cache keeps what was
/// wanted last; and no horizon, since the ground of a projected CRS is not curved. What mountains hide
/// is selected like what they do not: a frustum does not know of it.
pub fn select_by_frustum(
    tree: &TileTree,
    view: &CameraView,
    config: &SelectionConfig,
) -> Selection {
    let most = config.max_tiles.clamp(1, LISTED_AT_MOST);
    let sight = Sight::new(tree, view, config);
    let mut listed = vec![sight.seen(TileId::ROOT)];
    let mut too_coarse: BinaryHeap<_> = listed.iter().filter_map(|&s| sight.to_split(s)).collect();
    while let Some(Reverse(key)) = too_coarse.pop() {
        let first = listed.len();
        listed.extend(sight.visible_children(key.tile()));
        if listed.len() > most {
            listed.truncate(first);
            break;
        }
        too_coarse.extend(listed[first..].iter().filter_map(|&seen| sight.to_split(seen)));
    }
    let keys = listed.into_iter().map(|seen| PriorityOrder::new(seen.distance, seen.tile));
    let statistics = SelectionStatistics { subdivided: keys.len(), ..Default::default() };
    Selection::in_order(keys.collect(), statistics)
}

/// A tile and the squared distance of its nearest point.
#[derive(Clone, Copy)]
struct SeenTile {
    tile: TileId,
    distance: u64,
}

/// What the view can see of the tree, and how large.
struct Sight<'a> {
    tree: &'a TileTree,
    vertical_exaggeration: f64,
    eye: EyeUnits,
    split_below: SplitDistances,
    pyramid: ViewPyramid,
}

impl<'a> Sight<'a> {
    fn new(tree: &'a TileTree, view: &CameraView, config: &SelectionConfig) -> Self {
        let eye = EyeUnits::new(tree, view.eye, config.vertical_exaggeration);
        Self {
            tree,
            vertical_exaggeration: config.vertical_exaggeration,
            split_below: eye.split_below(tree, config.texel_px * view.pixel_angle_rad()),
            eye,
            pyramid: ViewPyramid::new(view),
        }
    }

    fn seen(&self, tile: TileId) -> SeenTile {
        SeenTile { tile, distance: self.tree.squared_distance(tile, &self.eye) }
    }

    /// Where the tile is too coarse and there are finer ones, its place in the order of splitting: by
    /// distance counted in its own texels, which is the error's reciprocal.
    fn to_split(&self, seen: SeenTile) -> Option<Reverse<FarthestOrder>> {
        let SeenTile { tile, distance } = seen;
        // Squares of distances in texels, but for a factor all share. Floats, since an integer would
        // not hold them: of numbers that are not negative, the bits are in the numbers' order.
        let in_texels = distance as f64 * f64::from(1_u32 << tile.level).powi(2);
        (distance < self.split_below[usize::from(tile.level)])
            .then(|| Reverse(FarthestOrder::new(in_texels.to_bits(), tile)))
    }

    /// The tile's children that hold data in view.
    fn visible_children(&self, tile: TileId) -> impl Iterator<Item = SeenTile> {
        let exist = tile.children().into_iter().filter(|&child| self.tree.contains(child));
        exist.filter(|&child| self.is_visible(child)).map(|child| self.seen(child))
    }

    fn is_visible(&self, tile: TileId) -> bool {
        self.ground_box(tile).is_some_and(|bounds| self.pyramid.meets(&bounds))
    }

    /// The box of the tile's ground as it is drawn; `None` where there is none.
    fn ground_box(&self, tile: TileId) -> Option<WorldBox> {
        let drawn = self.tree.scheme.tile_extent(tile).intersection(&self.tree.data_extent)?;
        let range = self.tree.height_ranges.range(tile)?;
        let ends_m = [range.min_m, range.max_m].map(|h| f64::from(h) * self.vertical_exaggeration);
        let (low_m, high_m) = (ends_m[0].min(ends_m[1]), ends_m[0].max(ends_m[1]));
        Some(WorldBox { min: drawn.min.extend(low_m), max: drawn.max.extend(high_m) })
    }
}
