//! The texture map on the GPU: which pages of a virtual texture a scene shows, found by laying its triangles into
//! the texture instead of looking at its pixels. After the paper on texture maps ("rendering of virtual textures
//! with back faces dropped before rasterisation"); `common/texture_map.wgsl` says how.

mod depth_pyramid;
mod ground_triangles;
mod map_pass;
mod object_triangles;
mod scene_map;

pub(crate) use depth_pyramid::DepthPyramid;
#[cfg(test)]
pub(crate) use depth_pyramid::MipRange;
pub(crate) use ground_triangles::{GroundDepthPass, ground_triangles};
#[cfg(test)]
pub(crate) use map_pass::TextureMapUniforms;
pub(crate) use object_triangles::ObjectRanges;
pub(crate) use scene_map::{MapScene, SceneMap};
