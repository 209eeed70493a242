use std::path::{Path, PathBuf};

/// Why a raster cannot be read: one line that names the file, the cause and, where there is one, the
/// way out.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SourceError {
    /// The system refused.
    #[error("{}: {reason}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        reason: String,
    },
    /// The file is no raster of a format that can be read.
    #[error("{}: not a raster this program reads: {reason}", path.display())]
    NotARaster {
        /// The file.
        path: PathBuf,
        /// What it is or is not.
        reason: String,
    },
    /// The file is cut short or damaged.
    #[error("{}: truncated or damaged: {reason}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What does not fit.
        reason: String,
    },
    /// A form of a known format that is not supported.
    #[error("{}: {reason}", path.display())]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// What is not supported, and the way out.
        reason: String,
    },
    /// A file of points that make no surface.
    #[error("{}: {reason}", path.display())]
    NoPoints {
        /// The file.
        path: PathBuf,
        /// What is missing, and the way out.
        reason: String,
    },
    /// Breaklines that cannot be used.
    #[error("{}: breaklines cannot be used: {reason}", path.display())]
    BadBreaklines {
        /// The file.
        path: PathBuf,
        /// What is wrong, and the way out.
        reason: String,
    },
    /// The georeference cannot be true.
    #[error("{}: georeference cannot be used: {reason}", path.display())]
    BadGeoreference {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
}

impl SourceError {
    pub(super) fn io(path: &Path, error: &std::io::Error) -> Self {
        Self::Io { path: path.to_owned(), reason: error.to_string() }
    }

    pub(super) fn not_a_raster(path: &Path, reason: impl Into<String>) -> Self {
        Self::NotARaster { path: path.to_owned(), reason: reason.into() }
    }

    pub(super) fn damaged(path: &Path, reason: impl Into<String>) -> Self {
        Self::Damaged { path: path.to_owned(), reason: reason.into() }
    }

    pub(super) fn unsupported(path: &Path, reason: impl Into<String>) -> Self {
        Self::Unsupported { path: path.to_owned(), reason: reason.into() }
    }

    pub(super) fn no_points(path: &Path, reason: &str) -> Self {
        Self::NoPoints { path: path.to_owned(), reason: reason.to_owned() }
    }

    pub(super) fn bad_breaklines(path: &Path, reason: impl Into<String>) -> Self {
        Self::BadBreaklines { path: path.to_owned(), reason: reason.into() }
    }

    pub(super) fn bad_georeference(path: &Path, reason: impl Into<String>) -> Self {
        Self::BadGeoreference { path: path.to_owned(), reason: reason.into() }
    }
}
