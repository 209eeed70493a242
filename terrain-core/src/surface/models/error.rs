use std::path::{Path, PathBuf};

/// Why a model could not be read. The file is always named.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}: {reason}", path.display())]
pub struct ModelError {
    /// The model's file.
    pub path: PathBuf,
    /// What does not fit.
    pub reason: String,
}

impl ModelError {
    pub(super) fn new(path: &Path, reason: impl Into<String>) -> Self {
        Self { path: path.to_owned(), reason: reason.into() }
    }
}

/// Why a scene file could not be read. The file is always named, and the entry where it is one's fault.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SceneFileError {
    /// The file itself.
    #[error("{}: {reason}", path.display())]
    File {
        /// The scene file.
        path: PathBuf,
        /// What does not fit.
        reason: String,
    },
    /// One of its models.
    #[error("{}: model {entry}: {reason}", path.display())]
    Entry {
        /// The scene file.
        path: PathBuf,
        /// Which of the models, counted from 1.
        entry: usize,
        /// What does not fit.
        reason: String,
    },
}
