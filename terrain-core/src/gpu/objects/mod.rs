//! Models on the GPU: their triangles, materials and places, and the passes that draw them with a virtual texture.

mod object_buffers;
mod object_pass;

pub(crate) use object_buffers::{ModelRun, ObjectBuffers, ObjectMaterial, ObjectRange};
pub(crate) use object_pass::{
    ObjectBindings, ObjectDepthPass, ObjectPass, ObjectPassSettings, ObjectRequestPass,
};
