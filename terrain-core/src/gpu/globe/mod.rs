//! The globe on the GPU: patches in slots of one buffer, what the shaders know of the eye, and the passes.

mod globe_group;
mod globe_uniforms;
mod passes;
mod patch_buffers;

pub(crate) use globe_group::GlobeGroup;
pub(crate) use globe_uniforms::GlobeUniforms;
pub(crate) use passes::{
    GlobeBindings, GlobePass, GlobePassSettings, GlobeRequestPass, draw_globe_coordinates,
};
pub(crate) use patch_buffers::{DrawnPatch, PatchBuffers};
