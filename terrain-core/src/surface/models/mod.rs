//! Models that stand on the ground: read from glTF 2.0 files (Khronos Group, "glTF 2.0 Specification", 2021),
//! placed by a scene file, their textures packed into one virtual texture. Plans only, no GPU.
//!
//! - [`Model::load`] reads a file into one list of vertices and triangles, with materials and images.
//! - [`ModelScene::load`] reads a scene file: which models stand where.
//! - [`TexturePack`] gives every image a place in one virtual texture and makes its pages.

mod accessors;
mod error;
mod image_pyramid;
mod load;
mod materials;
mod model;
mod placement;
mod primitives;
mod resources;
mod scene_file;
mod texture_pack;

pub use error::{ModelError, SceneFileError};
pub use model::{Model, ModelImage, ModelMaterial, ModelTexture, ModelVertex, WrapMode};
pub use placement::{ModelInstance, ModelPose, RelativePose, Standing};
pub use scene_file::ModelScene;
pub use texture_pack::{PackedImage, TexturePack};

#[cfg(test)]
mod tests;
