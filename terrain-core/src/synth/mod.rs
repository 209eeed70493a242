//! Rasters of synthetic mountains, as large as wanted.
//!
//! The ground is made in three parts. A grid of the whole ground is eroded by rivers, from coarse
//! cells to fine ones (`erosion`): it has valleys that drain, at all scales down to some hundred
//! metres. Beds and floors of streams follow that drainage as lines (`channels`), and gullies finer
//! than the grid run down its slopes (`gullies`); both are functions of the point alone (`ground`).
//! Colours follow height, slope, aspect, moisture and water (`land_cover`). So rasters of any size are
//! written row by row ([`synthesise`]), and every [`Preset`] is a part of one ground.
//!
//! All values come from seeded whole-number hashes and operations that IEEE 754 rounds exactly: one
//! seed is one ground, whatever the machine and the number of threads.

mod channels;
mod drainage;
mod erosion;
mod geotiff_strips;
mod grid;
mod ground;
mod gullies;
mod land_cover;
pub(crate) mod noise;
mod preset;
mod raster_rows;
mod uplift;
mod write;

pub use preset::Preset;
pub use write::{COLOURS_FILE, HEIGHTS_FILE, SynthError, SynthRequest, SynthSummary, synthesise};
