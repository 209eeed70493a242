//! How exact the renderer's numbers are: a study of what its arithmetic can hold, by derivation, by
//! trying every case on the CPU, and on the GPU itself.
//!
//! - [`span`]: bits that the dot products behind a texture coordinate need against distance.
//! - [`encodings`]: ways to hold a place on Earth in f32s, and the contract that the renderer's keeps.
//! - [`depth`]: gaps between surfaces that the depth test tells apart.
//! - [`study`]: all of it in one run, as tables, plots and a page.
//!
//! `docs/precision.md` holds the derivations and the main curves.

pub mod depth;
pub mod encodings;
pub mod span;
pub mod study;
