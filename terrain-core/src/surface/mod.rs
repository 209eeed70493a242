//! The meshes terrain is drawn with: vertices and indices, no GPU. Pure.

mod block_culling;
mod circular_mesh;
mod ring_layout;
pub mod view_mesh;

pub use circular_mesh::{CircularMesh, CircularMeshSettings, MeshBlock, MeshVertex};

#[cfg(test)]
mod tests;
