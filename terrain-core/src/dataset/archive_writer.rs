use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};

use pmtiles::{Compression, PmTilesStreamWriter, PmTilesWriter, TileCoord, TileType};
use serde::{Deserialize, Serialize};

use crate::tiling::{TileId, TileSet};

/// Runs of columns, first and last of each.
type ColumnRuns = Vec<(u32, u32)>;

/// What a tile archive says of itself: which tiles it holds, so that one read answers for all.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct ArchiveMetadata {
    /// Format of the payloads.
    pub format: String,
    /// A row of tiles each: its level, its row, and the columns there are.
    pub present: Vec<(u8, u32, ColumnRuns)>,
}

impl ArchiveMetadata {
    pub const FORMAT: &str = "terrain-tiles-1";

    fn of(present: &TileSet) -> Self {
        let mut rows: BTreeMap<(u8, u32), ColumnRuns> = BTreeMap::new();
        for tile in present.iter() {
            let runs = rows.entry((tile.level, tile.row)).or_default();
            match runs.last_mut() {
                Some(run) if run.1 + 1 == tile.column => run.1 = tile.column,
                _ => runs.push((tile.column, tile.column)),
            }
        }
        let present = rows.into_iter().map(|((level, row), runs)| (level, row, runs)).collect();
        Self { format: Self::FORMAT.to_owned(), present }
    }
}

/// Writes one layer's tiles to a PMTiles archive (zoom = level, x = column, y = row).
///
/// Identical payloads are stored once. Tiles may come in any order. The archive is readable only
/// after [`Self::finish`].
pub struct ArchiveWriter {
    path: PathBuf,
    writer: PmTilesStreamWriter<File>,
    present: TileSet,
    payload_bytes: u64,
}

/// The archive could not be written.
#[derive(Debug, thiserror::Error)]
#[error("{}: cannot write: {reason}", path.display())]
pub struct ArchiveWriteError {
    /// The archive.
    pub path: PathBuf,
    /// What the system said.
    pub reason: String,
}

impl ArchiveWriter {
    /// Starts an archive at the path.
    pub fn create(path: &Path) -> Result<Self, ArchiveWriteError> {
        let failed = |reason: String| ArchiveWriteError { path: path.to_owned(), reason };
        let file = File::create(path).map_err(|error| failed(error.to_string()))?;
        let writer = PmTilesWriter::new(TileType::Unknown)
            .precompressed(Compression::None)
            .create(file)
            .map_err(|error| failed(error.to_string()))?;
        Ok(Self { path: path.to_owned(), writer, present: TileSet::new(), payload_bytes: 0 })
    }

    /// Adds a tile.
    pub fn add(&mut self, tile: TileId, payload: &[u8]) -> Result<(), ArchiveWriteError> {
        let written = TileCoord::new(tile.level, tile.column, tile.row)
            .and_then(|coord| self.writer.add_tile(coord, payload));
        written.map_err(|error| self.failed(error.to_string()))?;
        self.present.insert(tile);
        self.payload_bytes += payload.len() as u64;
        Ok(())
    }

    /// The tiles added so far.
    pub fn present(&self) -> &TileSet {
        &self.present
    }

    /// Bytes of all payloads, identical ones counted each time.
    pub fn payload_bytes(&self) -> u64 {
        self.payload_bytes
    }

    /// Writes the directory and closes the archive.
    pub fn finish(mut self) -> Result<(), ArchiveWriteError> {
        let levels = || self.present.iter().map(|tile| tile.level);
        let range = (levels().min().unwrap_or(0), levels().max().unwrap_or(0));
        let metadata = serde_json::to_string(&ArchiveMetadata::of(&self.present))
            .map_err(|error| self.failed(error.to_string()))?;
        self.writer.set_zoom_range(range.0, range.1);
        self.writer.set_metadata(metadata);
        let path = self.path;
        self.writer
            .finalize()
            .map_err(|error| ArchiveWriteError { path, reason: error.to_string() })
    }

    fn failed(&self, reason: String) -> ArchiveWriteError {
        ArchiveWriteError { path: self.path.clone(), reason }
    }
}
