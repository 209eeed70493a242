//! The exact picture that drawn ones are measured against: a ray caster in f64 over the
//! full-resolution data, without a GPU.

mod picture;

pub use picture::ReferencePicture;
