use super::{
    SeenGround, Selection, SelectionConfig, SelectionStatistics, SelectionStrategy, Shortening,
    TileTree, merge_farthest, merge_least_error::merge_least_error, regularize, subdivide,
};
use crate::CameraView;

/// The paper's tile scheduling, [`select`], as a strategy.
pub(crate) struct RttQuadtree;

impl SelectionStrategy for RttQuadtree {
    fn needs_region(&self) -> bool {
        true
    }

    fn select(
        &self,
        tree: &TileTree,
        seen: Option<SeenGround<'_>>,
        view: &CameraView,
        config: &SelectionConfig,
    ) -> Selection {
        select(tree, seen, view, config)
    }
}

/// Steps 2 to 4 of the paper's tile selection, in its order: subdivision, regularisation, merging.
///
/// What was seen comes from [`visible_region()`](super::visible_region()), and may be of a view some
/// frames old; without any (an empty view) the selection is level 0. See [`subdivide()`],
/// [`regularize()`] and [`merge_farthest()`] for what each does and where it departs from the paper, and
/// [`Shortening`] for another way to do the last two.
pub fn select(
    tree: &TileTree,
    seen: Option<SeenGround<'_>>,
    view: &CameraView,
    config: &SelectionConfig,
) -> Selection {
    let mut list = subdivide(tree, seen, view, config);
    let subdivided = list.len();
    let regularized_away = regularize(&mut list);
    let merges = match config.shortening {
        Shortening::Farthest => merge_farthest(&mut list, config.max_tiles),
        Shortening::LeastError => merge_least_error(&mut list, config.max_tiles),
    };
    let statistics = SelectionStatistics {
        subdivided,
        regularized_away,
        merges,
        hidden: list.hidden(),
        finest_level: 0,
    };
    Selection::in_order(list.priorities(), statistics)
}
