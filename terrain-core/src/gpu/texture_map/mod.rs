//! The texture map on the GPU: which pages of a virtual texture a scene shows, found by laying its triangles into
//! the texture instead of looking at its pixels. After the paper on texture maps ("rendering of virtual textures
//! with back faces dropped before rasterisation"); `common/texture_map.wgsl` says how.

mod depth_pyramid;
mod ground_triangles;
mod map_pass;

pub(crate) use depth_pyramid::DepthPyramid;
#[cfg(test)]
pub(crate) use depth_pyramid::MipRange;
pub(crate) use ground_triangles::{GroundDepthPass, GroundTriangles};
pub(crate) use map_pass::{MapBindings, TextureMapPass, TextureMapUniforms};
