use std::path::{Path, PathBuf};

use pmtiles::{AsyncPmTilesReader, HashMapCache, MmapBackend, TileCoord};

use super::LoadError;
use super::archive_writer::ArchiveMetadata;
use crate::tiling::{MAX_LEVEL, TileId, TileSet};

/// Reads one layer's tiles from a PMTiles archive on disk, mapped into memory.
///
/// The archive's reader is asynchronous for the sake of remote archives; on a mapped file every step
/// is ready at once, so blocking on it costs nothing and needs no runtime.
pub(super) struct ArchiveReader {
    path: PathBuf,
    reader: AsyncPmTilesReader<MmapBackend, HashMapCache>,
    present: TileSet,
}

impl ArchiveReader {
    /// Opens the archive and reads which tiles it holds. The error is one line without the path.
    pub fn open(path: &Path) -> Result<Self, String> {
        // The name is looked up on a runtime's blocking thread, hence the runtime, for this only.
        let runtime = tokio::runtime::Builder::new_current_thread()
            .build()
            .map_err(|error| error.to_string())?;
        let opened = runtime.block_on(async {
            let cache = HashMapCache::default();
            let reader = AsyncPmTilesReader::new_with_cached_path(cache, path).await?;
            let metadata = reader.get_metadata().await?;
            Ok((reader, metadata))
        });
        let (reader, metadata) =
            opened.map_err(|error: pmtiles::PmtError| format!("no whole tile archive: {error}"))?;
        let metadata: ArchiveMetadata = serde_json::from_str(&metadata)
            .map_err(|error| format!("not an archive of this program: {error}"))?;
        if metadata.format != ArchiveMetadata::FORMAT {
            return Err(format!("tile format {:?} is unknown", metadata.format));
        }
        Ok(Self { path: path.to_owned(), reader, present: present_of(&metadata)? })
    }

    /// The tiles the archive holds.
    pub fn present(&self) -> &TileSet {
        &self.present
    }

    /// Where the archive lies.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The stored bytes of a tile.
    pub fn payload(
        &self,
        tile: TileId,
    ) -> Result<impl std::ops::Deref<Target = [u8]> + use<>, LoadError> {
        let path = || self.path.clone();
        let absent = || LoadError::Absent { path: path(), tile };
        let unreadable = |reason: pmtiles::PmtError| LoadError::Unreadable {
            path: path(),
            tile,
            reason: reason.to_string(),
        };
        let coord = TileCoord::new(tile.level, tile.column, tile.row).map_err(unreadable)?;
        let found = pollster::block_on(self.reader.get_tile(coord)).map_err(unreadable)?;
        found.ok_or_else(absent)
    }
}

fn present_of(metadata: &ArchiveMetadata) -> Result<TileSet, String> {
    let mut present = TileSet::new();
    for (level, row, runs) in &metadata.present {
        for &(first, last) in runs {
            if *level > MAX_LEVEL || *row >= 1 << level || last >= 1 << level || first > last {
                return Err(format!("tile row {level}/{row}/{first}..{last} is out of range"));
            }
            for column in first..=last {
                present.insert(TileId::new(*level, *row, column));
            }
        }
    }
    Ok(present)
}
