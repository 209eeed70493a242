//! Which tiles a view needs: the stages of the tile-scheduling paper, each a pure function.
//!
//! `CoordinateImage -> visible_region -> subdivide -> regularize -> merge_farthest -> Selection`,
//! after Liu Hao et al., "Dynamic Scheduling and Real-time Rendering Method for Large-Scale
//! Terrain", section 3.1. [`select`] runs the stages in order.

mod merge_farthest;
mod regularize;
mod rtt_quadtree;
mod sort_keys;
mod subdivide;
mod tile_list;
mod tile_tree;
mod visible_region;

pub use merge_farthest::merge_farthest;
pub use regularize::regularize;
pub use rtt_quadtree::{Selection, SelectionStatistics, select};
pub use subdivide::{SelectionConfig, subdivide};
pub use tile_list::TileList;
pub use tile_tree::{LayerTree, TileTree};
pub use visible_region::{CoordinateImage, VisibleRegion, visible_region};

#[cfg(test)]
mod tests;
