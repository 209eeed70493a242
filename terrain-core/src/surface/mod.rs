//! The meshes terrain is drawn with: vertices and indices, no GPU. Pure.

mod block_culling;
mod circular_mesh;
mod clip_mesh;
pub mod globe;
pub mod models;
mod ring_layout;
pub mod tin;
pub mod view_mesh;

pub use circular_mesh::{CircularMesh, CircularMeshSettings, MeshBlock, MeshVertex};
pub use clip_mesh::{CLIP_BLOCKS_A_SIDE, ClipBlock, ClipMesh, ClipMeshView};

#[cfg(test)]
mod tests;
