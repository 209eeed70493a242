use super::eye_units::EyeUnits;
use super::ground_units::FixedBox;
use super::seen_tiles::SeenTiles;
use super::tile_list::{Child, Node};
use super::{SeenGround, Shortening, TileList, TileTree};
use crate::CameraView;

/// What the selection is to reach and to keep within.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SelectionConfig {
    /// The paper's MaxofTiles: tiles on the list at the most, level 0 counted. 0 is taken as 1.
    pub max_tiles: usize,
    /// A tile is split while its texel, at its point nearest to the eye, appears larger than this
    /// many pixels.
    pub texel_px: f64,
    /// Factor the terrain's heights are drawn with.
    pub vertical_exaggeration: f64,
    /// How the paper's selection makes its list short.
    pub shortening: Shortening,
}

impl Default for SelectionConfig {
    /// As many tiles as the paper's cache of 6 x 6, a texel a pixel, heights as they are.
    fn default() -> Self {
        Self {
            max_tiles: 36,
            texel_px: 1.0,
            vertical_exaggeration: 1.0,
            shortening: Shortening::Farthest,
        }
    }
}

/// Tiles beyond which nothing more is split, whatever the threshold: a bound on time and memory for
/// settings that ask for the absurd.
pub(crate) const LISTED_AT_MOST: usize = 1 << 16;

/// Step 2 of the paper's tile selection: quadtree subdivision by distance.
///
/// Liu Hao et al., "Dynamic Scheduling and Real-time Rendering Method for Large-Scale Terrain",
/// section 3.1:
/// 1. Begin with the coarsest level, whose one tile is always on the list.
/// 2. Of the tiles of the level that are on the list, split those that satisfy the threshold.
/// 3. Put those of their children that meet the visible region on the list; children of a tile
///    that is not on the list are never considered.
/// 4. Go on with the next level, to the finest.
///
/// Departures: the paper leaves the threshold open; here a tile is split while its texel, seen from
/// the distance of the tile's nearest point (to the box of its extent and height range, in whole
/// units), appears larger than
/// [`SelectionConfig::texel_px`]. Children that hold no data are not stored and never chosen. Once
/// 65,536 tiles are found, nothing more is split. With an image, tiles within the box that none of its
/// pixels saw do not come on the list; they are counted, [`TileList::hidden`], unless the tiles that were
/// seen are too many to keep: then all of the box counts.
///
/// Where nothing was seen (an empty view) the list holds level 0 alone.
pub fn subdivide(
    tree: &TileTree,
    seen: Option<SeenGround<'_>>,
    view: &CameraView,
    config: &SelectionConfig,
) -> TileList {
    let eye = EyeUnits::new(tree, view.eye, config.vertical_exaggeration);
    let mut list = TileList::new(tree, &eye, config.shortening);
    let Some(seen) = seen else { return list };
    let split_below = eye.split_below(tree, config.texel_px * view.pixel_angle_rad());
    let exact = seen.image.and_then(|image| SeenTiles::of_image(image, tree, &eye, &split_below));
    let ground = VisibleGround { bounds: seen.region.fixed_box(&tree.scheme), exact };
    let mut next = TileList::ROOT;
    // Nodes are appended level by level, so going through them in order is going level by level.
    while (next as usize) < list.nodes().len() && list.nodes().len() < LISTED_AT_MOST {
        let node = list.node(next);
        if node.distance < split_below[usize::from(node.tile.level)] {
            add_children(&mut list, next, tree, &eye, &ground);
        }
        next += 1;
    }
    list
}

/// What counts as visible.
struct VisibleGround {
    bounds: FixedBox,
    /// Within the box; `None` where all of it does.
    exact: Option<SeenTiles>,
}

/// Adds the children of a node that exist and lie in the box, to the list those that were seen.
fn add_children(
    list: &mut TileList,
    parent: u32,
    tree: &TileTree,
    eye: &EyeUnits,
    ground: &VisibleGround,
) {
    let Node { tile, is_hidden, .. } = *list.node(parent);
    // Where heights are not known any finer, they are computed once for all four.
    let shared = (tile.level + 1 >= tree.height_ranges.levels.len() as u8)
        .then(|| eye.heights(tree.height_ranges.range(tile)));
    for (quadrant, child) in tile.children().into_iter().enumerate() {
        if !tree.contains(child) {
            if tree.is_empty_ground(child) {
                list.set_child(parent, quadrant, Child::EMPTY);
            }
            continue;
        }
        if !ground.bounds.touches(child) {
            list.set_child(parent, quadrant, Child::OUT_OF_VIEW);
            continue;
        }
        let heights = shared.unwrap_or_else(|| eye.heights(tree.height_ranges.range(child)));
        let index = list.add_child(parent, child, eye.squared_distance(child, heights));
        if is_hidden || ground.exact.as_ref().is_some_and(|exact| !exact.contains(child)) {
            list.hide(index);
        } else {
            list.set_listed(index, true);
        }
    }
}
