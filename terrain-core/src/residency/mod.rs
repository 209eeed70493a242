//! Which tiles are in memory and where: the slots of an atlas, the table that finds a point's tile,
//! the queue of tiles to load. Plans only, no GPU.

pub mod clipmap;
mod layer_stream;
mod offset_table;
mod tile_cache;
mod tile_loader;

pub use layer_stream::{LayerStream, LayerUpdate};
pub use offset_table::{OffsetEntry, OffsetTable, slot_origin_texels};
pub use tile_cache::{CachePlan, Placement, TileCache};
pub use tile_loader::{LoadPanic, TileLoader};

#[cfg(test)]
mod tests;
