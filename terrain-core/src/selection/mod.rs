//! Which tiles a view needs: the stages of the tile-scheduling paper, each a pure function.

mod tile_tree;

pub use tile_tree::{LayerTree, TileTree};
