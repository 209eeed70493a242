use std::path::PathBuf;

use super::{ColourTile, HeightTile, Manifest};
use crate::tiling::{TileId, TileSet};

/// Something tiles can be loaded from: a dataset on disk, or one computed as it is asked for.
///
/// Loading happens on worker threads, so a source is shared and its loads take `&self`.
pub trait TileSource: Send + Sync {
    /// What the dataset is.
    fn manifest(&self) -> &Manifest;

    /// The height tiles that exist. Absent tiles hold no data; their ground is nodata.
    fn heights_present(&self) -> &TileSet;

    /// The colour tiles that exist; empty without a colour layer.
    fn colours_present(&self) -> &TileSet;

    /// Reads and decodes one height tile. Asking for a tile that is not present is an error.
    fn load_heights(&self, tile: TileId) -> Result<Loaded<HeightTile>, LoadError>;

    /// Reads and decodes one colour tile. Asking for a tile that is not present is an error.
    fn load_colours(&self, tile: TileId) -> Result<Loaded<ColourTile>, LoadError>;

    /// Frames that a tile takes at least from when it is asked for until it can be used, however fast it
    /// is loaded: 0 but for a [`DelayedSource`](super::DelayedSource).
    fn delay_frames(&self) -> u32 {
        0
    }
}

/// A decoded tile and what it cost to read.
#[derive(Clone, Debug, PartialEq)]
pub struct Loaded<T> {
    /// The decoded tile.
    pub tile: T,
    /// Bytes read from the archive for it (compressed, as stored).
    pub disk_bytes: u64,
}

/// Why a tile could not be loaded. The file and the tile are always named.
#[derive(Clone, Debug, thiserror::Error)]
pub enum LoadError {
    /// The tile is not in the archive.
    #[error("{}: no tile {tile}", path.display())]
    Absent {
        /// The archive.
        path: PathBuf,
        /// The tile asked for.
        tile: TileId,
    },
    /// The tile is there but its checksum or its form is wrong.
    #[error("{}: tile {tile} is damaged: {reason}", path.display())]
    Damaged {
        /// The archive.
        path: PathBuf,
        /// The tile asked for.
        tile: TileId,
        /// What does not fit.
        reason: String,
    },
    /// The archive could not be read.
    #[error("{}: cannot read tile {tile}: {reason}", path.display())]
    Unreadable {
        /// The archive.
        path: PathBuf,
        /// The tile asked for.
        tile: TileId,
        /// What the system said.
        reason: String,
    },
}
