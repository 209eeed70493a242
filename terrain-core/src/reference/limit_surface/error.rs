use std::path::PathBuf;

use crate::dataset::LoadError;

/// Why a limit-triangulated surface cannot be made, written or read.
#[derive(Debug, thiserror::Error)]
pub enum LimitSurfaceError {
    /// A setting is out of its range.
    #[error("{0}")]
    Setting(String),
    /// A tile the surface is made of cannot be loaded.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// The file cannot be written or read.
    #[error("{}: {reason}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What the system said.
        reason: String,
    },
    /// The file is there, but it is not whole or not what it says.
    #[error("{}: damaged: {reason}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What does not fit.
        reason: String,
    },
    /// Another version of this program wrote the file.
    #[error("{}: version {found} of the format, this program reads {expected}; prepare it anew", path.display())]
    OtherVersion {
        /// The file.
        path: PathBuf,
        /// The version found.
        found: u32,
        /// The version read.
        expected: u32,
    },
    /// The caller asked to stop.
    #[error("stopped; nothing was written")]
    Cancelled,
}
