use std::path::PathBuf;

use super::source::SourceError;
use crate::dataset::ArchiveWriteError;
use crate::geodesy::CrsError;

/// Why a dataset could not be prepared. Nothing half-made is left behind.
#[derive(Debug, thiserror::Error)]
pub enum PrepareError {
    /// A raster cannot be read.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// A coordinate reference system cannot be used.
    #[error(transparent)]
    Crs(#[from] CrsError),
    /// A raster and its CRS do not go together, or do not go with the other rasters.
    #[error("{}: {reason}", path.display())]
    Misplaced {
        /// The raster.
        path: PathBuf,
        /// What does not fit, and the way out.
        reason: String,
    },
    /// The request asks for what cannot be.
    #[error("{0}")]
    Request(String),
    /// The output folder is in the way or cannot be written.
    #[error("{}: {reason}", path.display())]
    Output {
        /// The folder or file.
        path: PathBuf,
        /// What is wrong, and the way out.
        reason: String,
    },
    /// A tile archive cannot be written.
    #[error(transparent)]
    Archive(#[from] ArchiveWriteError),
    /// The caller asked to stop.
    #[error("stopped before the dataset was whole")]
    Cancelled,
}
