//! The exact picture that drawn ones are measured against: a ray caster in f64 over the
//! full-resolution data, without a GPU.

pub mod limit_surface;
mod picture;

pub use picture::ReferencePicture;
