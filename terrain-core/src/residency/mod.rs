//! Which tiles are in memory and where: the slots of an atlas, the table that finds a point's tile,
//! the queue of tiles to load. Plans only, no GPU.

pub mod clipmap;
mod layer_stream;
mod load_delay;
#[cfg(test)]
pub(crate) mod managed_slots;
mod offset_table;
pub mod page_table;
mod slot_stream;
mod tile_cache;
mod tile_in_slot;
mod tile_intake;
mod tile_loader;

pub(crate) use layer_stream::LayerStream;
pub use offset_table::{OffsetEntry, OffsetTable, slot_origin_texels};
pub(crate) use slot_stream::{SlotStream, SlotUpdate};
pub use tile_cache::{CachePlan, Placement, TileCache};
pub(crate) use tile_in_slot::TileInSlot;
pub(crate) use tile_intake::{Taken, TileIntake};
pub use tile_loader::{LoadPanic, Loading, TileLoader};

#[cfg(test)]
mod tests;
