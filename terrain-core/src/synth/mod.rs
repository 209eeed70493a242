//! Rasters of synthetic mountains, as large as wanted.
//!
//! The ground is made in three parts. A grid of the whole ground is eroded by rivers, from coarse to
//! fine ([`ErodedGround`]): it has valleys that drain, at all scales down to some hundred metres.
//! Stream beds and floors follow that drainage as lines, and gullies finer than the grid run down its
//! slopes ([`Ground`]); both are functions of the point alone. Colours follow height, slope, aspect,
//! moisture and water. So rasters of any size are written row by row ([`synthesise`]), and every
//! preset is a part of one ground.
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
mod noise;
mod preset;
mod raster_rows;
mod uplift;
mod write;

pub use drainage::Drainage;
pub use erosion::ErodedGround;
pub use grid::{GROUND_SIZE_M, HeightGrid};
pub use ground::{Ground, GroundPoint};
pub use preset::Preset;
pub use raster_rows::RasterRows;
pub use write::{COLOURS_FILE, HEIGHTS_FILE, SynthError, SynthRequest, SynthSummary, synthesise};
