//! The clipmap method's resources and passes.

mod bindings;
mod coordinates;
mod decode_colours_pass;
mod heights_pass;
mod levels;
mod mesh;
mod pipeline;
mod textures;

pub(crate) use bindings::ClipBindings;
pub(crate) use coordinates::draw_clip_coordinates;
pub(crate) use decode_colours_pass::{ClipDecodePass, WrittenTexels};
#[cfg(test)]
pub(super) use heights_pass::{ClipHeightJob, ClipSlopeJob};
pub(crate) use heights_pass::{ClipHeightUpload, ClipHeightsPass};
pub(crate) use levels::{ClipFrame, ClipLevel};
pub(crate) use mesh::ClipMeshBuffers;
pub(crate) use pipeline::{ClipPass, ClipPassSettings};
pub(crate) use textures::{ClipTextureSizes, ClipTextures};
