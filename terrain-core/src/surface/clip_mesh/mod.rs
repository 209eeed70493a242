//! The nested grids a clipmap's ground is drawn with. Pure.

mod block;
mod rings;
#[cfg(test)]
mod tests;

pub use block::ClipBlock;
pub use rings::{CLIP_BLOCKS_A_SIDE, ClipMesh, ClipMeshView};
