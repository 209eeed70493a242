//! The exact picture that drawn ones are measured against: a ray caster in f64 over the
//! full-resolution data, without a GPU.
//!
//! **The surface.** Heights are samples at the centres of the texels of the finest level present (of
//! the nearest ancestor where a region is less deep), bilinear in between, in f64. Where some of the
//! four samples around a point hold no data, the height is the mean of the others by their bilinear
//! weights, and there is ground as long as these make up half of the whole; so the outermost texels
//! go on to the very edge of the data. The surface ends at the manifest's extent. It is seen from
//! above only, as the renderer draws it. Where regions of different depth meet, the step between
//! them counts as ground.
//!
//! **The picture.** Sun, air and sky are those of the uniforms of the renderer's frame, the slope that
//! is lit is bilinear between the central differences of the samples, and the colour of a
//! pixel is the mean over its square of what rays through it see, taken until an error estimate is
//! below the tolerance; see [`ReferenceSettings`].
//!
//! **A globe** has its heights on the ellipsoid of WGS 84, along its normals; see `globe_tracer.rs`.
//!
//! **Memory.** A height tile is decoded when a ray first comes near it: 4 bytes a sample and about
//! 2.5 for the bounds that let rays pass it quickly. Imagery takes 4 bytes a texel, and only the levels that
//! the picture needs are read. [`ReferenceScene::loaded_bytes`] tells the sum.

mod camera_rays;
mod footprint;
mod globe_tracer;
mod grid_walk;
mod height_grid;
mod imagery;
mod lazy_tiles;
pub mod limit_surface;
mod partial_patch;
mod patch;
mod picture;
mod pixel_integral;
mod plane_tracer;
mod range_pyramid;
mod ray_box;
mod render;
mod scene;
mod shading;
mod silhouette;
#[cfg(test)]
mod tests;
mod tile_walk;
mod tracer;

pub use picture::ReferencePicture;
pub use render::{ReferenceSettings, render_reference};
pub use scene::{ReferenceError, ReferenceScene, SurfaceHit};
