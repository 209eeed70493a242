//! A prepared dataset on disk: its manifest, its tile archives and how a tile is decoded.
//!
//! A dataset is a folder: `manifest.json`, `heights.pmtiles` and, where there is imagery,
//! `colours.pmtiles`. Both layers share one [`TilingScheme`](crate::tiling::TilingScheme): a tile
//! covers the same ground in both. Each layer has its own number of levels.

mod archive_reader;
mod archive_writer;
mod block_decode;
pub mod codec;
mod dataset_folder;
mod delayed_source;
mod detailed_source;
mod height_lookup;
mod inspection;
mod manifest;
mod tile_payload;
mod tile_source;

pub use archive_writer::{ArchiveWriteError, ArchiveWriter};
pub use dataset_folder::{COLOURS_FILE, Dataset, HEIGHTS_FILE, MANIFEST_FILE, OpenError};
pub use delayed_source::DelayedSource;
pub use detailed_source::{DetailError, DetailedSource};
pub use inspection::{Inspection, LevelInspection};
pub use manifest::{
    ColourEncoding, ColourLayer, Crs, HeightEncoding, HeightLayer, HeightRanges, Manifest, Shape,
};
pub use tile_payload::{ColourFormat, ColourTile, HeightRange, HeightSamples, HeightTile};
pub use tile_source::{LoadError, Loaded, TileSource};
