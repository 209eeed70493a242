//! Which tiles a view needs: a [`Strategy`] chooses them, and all strategies' [`Selection`]s go the
//! same way from there.
//!
//! `rtt-quadtree` is the tile-scheduling paper's own, each stage a pure function:
//! `CoordinateImage -> visible_region -> subdivide -> regularize -> merge_farthest -> Selection`,
//! after Liu Hao et al., "Dynamic Scheduling and Real-time Rendering Method for Large-Scale
//! Terrain", section 3.1. [`select`] runs the stages in order.
//!
//! `cpu-frustum` is the traditional way, without a look at what the GPU drew: [`select_by_frustum`].

mod cpu_frustum;
mod eye_units;
mod ground_units;
mod merge_farthest;
mod merge_least_error;
mod regularize;
mod rtt_quadtree;
mod seen_tiles;
mod selection_params;
mod shortening;
mod sort_keys;
mod strategy;
mod subdivide;
mod tile_list;
mod tile_selection;
mod tile_tree;
mod view_pyramid;
mod visibility;
mod visible_region;

pub use cpu_frustum::select_by_frustum;
pub use merge_farthest::merge_farthest;
pub use regularize::regularize;
pub(crate) use rtt_quadtree::RttQuadtree;
pub use rtt_quadtree::select;
#[cfg(test)]
pub(crate) use seen_tiles::SeenTiles;
pub(crate) use selection_params::{SelectionParams, height_units};
pub use shortening::{Shortening, UnknownShortening};
pub use strategy::{SelectionStrategy, Strategy, UnknownStrategy};
pub(crate) use subdivide::LISTED_AT_MOST;
pub use subdivide::{SelectionConfig, subdivide};
pub use tile_list::TileList;
pub use tile_selection::{Selection, SelectionStatistics};
pub use tile_tree::{LayerTree, TileTree};
pub use visibility::{UnknownVisibility, Visibility};
pub use visible_region::{CoordinateImage, SeenGround, VisibleRegion, visible_region};

#[cfg(test)]
pub(crate) mod tests;
