//! The globe as a mesh: patches of a fixed grid on the faces of a cube blown up to the ellipsoid of WGS 84, split
//! where they are seen large. Pure.
//!
//! A patch is a square of a cube's face with [`CELLS_A_SIDE`] cells a side. Neighbouring patches in a cover differ
//! by one level at the most, and a patch leaves out every second vertex along an edge behind which the mesh is
//! coarser ([`PatchTriangles`]): so the cover is one surface without a crack. That it stays one on the GPU takes
//! vertices that come out the same bit for bit whichever patch they belong to. Hence places are absolute whole
//! numbers ([`GlobeVertex`]), from which the eye's is subtracted exactly.
//!
//! Sources: a cube's faces as quadtrees, P. Cozzi and K. Ring, "3D Engine Design for Virtual Globes" (2011); levels
//! that differ by one at most, B. Von Herzen and A. Barr, "Accurate Triangulations of Deformed, Intersecting
//! Surfaces" (1987); splitting the largest error first within a budget, M. Duchaineau et al., "ROAMing Terrain"
//! (1997).

mod air;
mod cover;
mod ground;
mod patch;
mod patch_id;
mod patch_store;
mod sight;
#[cfg(test)]
mod tests;
mod triangles;
mod vertex;

pub use air::GlobeAir;
pub use cover::{CoverSettings, CoveredPatch, GlobeCover, cover};
pub use ground::GlobeGround;
pub use patch::{CELLS_A_SIDE, GlobePatch, VERTICES_A_PATCH};
pub use patch_id::{PatchEdge, PatchId};
pub use patch_store::PatchStore;
pub use sight::GlobeSight;
pub use triangles::PatchTriangles;
pub use vertex::{GlobeVertex, SplitPlace};
