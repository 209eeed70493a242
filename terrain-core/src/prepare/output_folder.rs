use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use super::PrepareError;
use super::finished_layers::{forget_unfinished, records_in};
use crate::dataset::MANIFEST_FILE;

/// A folder that is written under another name beside its own and takes its name when whole.
/// Dropped before that, it leaves nothing behind; one that can be resumed leaves its finished layers.
pub struct OutputFolder {
    target: PathBuf,
    partial: Partial,
}

/// Where files are written meanwhile.
enum Partial {
    /// Removed when dropped.
    Temporary(TempDir),
    /// Found again by its name.
    Resumable(ResumableFolder),
}

/// A folder that only one process uses at a time, the one that holds the lock.
struct ResumableFolder {
    path: PathBuf,
    _lock: File,
}

/// Name of the file whose lock says that a resumable folder is in use.
const LOCK_FILE: &str = "lock";

impl OutputFolder {
    /// Starts the folder, or where it can be resumed, goes on with the one there is. A dataset at
    /// `target` will be replaced; anything else there is an error.
    pub fn create(target: &Path, is_resumable: bool) -> Result<Self, PrepareError> {
        let failed = |path: &Path, reason: String| {
            Err(PrepareError::Output { path: path.to_owned(), reason })
        };
        if target.exists() && !is_replaceable(target) {
            return failed(
                target,
                "is there already and is no dataset; choose another --out".into(),
            );
        }
        let Some(name) = target.file_name() else {
            return failed(target, "is no name for a folder".into());
        };
        let parent = match target.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        if let Err(error) = std::fs::create_dir_all(parent) {
            return failed(parent, error.to_string());
        }
        let name = name.to_string_lossy();
        let partial = if is_resumable {
            ResumableFolder::open(parent.join(format!(".{name}.resume"))).map(Partial::Resumable)
        } else {
            let prefix = format!(".{name}.partial-");
            let created = tempfile::Builder::new().prefix(&prefix).tempdir_in(parent);
            created.map(Partial::Temporary).map_err(|error| error.to_string())
        };
        match partial {
            Ok(partial) => Ok(Self { target: target.to_owned(), partial }),
            Err(reason) => failed(parent, format!("cannot write there: {reason}")),
        }
    }

    /// Where files are written meanwhile.
    pub fn path(&self) -> &Path {
        match &self.partial {
            Partial::Temporary(folder) => folder.path(),
            Partial::Resumable(folder) => &folder.path,
        }
    }

    /// Gives the folder its name; a dataset that had it is removed.
    pub fn finish(self) -> Result<(), PrepareError> {
        self.take_name().map_err(|error| PrepareError::Output {
            path: self.target.clone(),
            reason: error.to_string(),
        })?;
        // What was renamed is no longer there to be removed.
        if let Partial::Temporary(folder) = self.partial {
            let _ = folder.keep();
        }
        Ok(())
    }

    fn take_name(&self) -> std::io::Result<()> {
        let partial = self.path();
        if let Partial::Resumable(_) = &self.partial {
            for record in records_in(partial) {
                std::fs::remove_file(record)?;
            }
            std::fs::remove_file(partial.join(LOCK_FILE))?;
        }
        share(partial)?;
        if !self.target.exists() {
            return std::fs::rename(partial, &self.target);
        }
        // The old dataset steps aside first, so that one of the two is always whole.
        let aside = partial.with_extension("old");
        std::fs::rename(&self.target, &aside)?;
        if let Err(error) = std::fs::rename(partial, &self.target) {
            std::fs::rename(&aside, &self.target)?;
            return Err(error);
        }
        std::fs::remove_dir_all(&aside)
    }
}

impl ResumableFolder {
    /// Opens or makes the folder. The error is one line without the path.
    fn open(path: PathBuf) -> Result<Self, String> {
        let lock = std::fs::create_dir_all(&path)
            .and_then(|()| File::create(path.join(LOCK_FILE)))
            .map_err(|error| error.to_string())?;
        match lock.try_lock() {
            Ok(()) => Ok(Self { path, _lock: lock }),
            Err(TryLockError::WouldBlock) => Err("it is being prepared already".to_owned()),
            Err(TryLockError::Error(error)) => Err(error.to_string()),
        }
    }
}

impl Drop for ResumableFolder {
    /// Keeps what can be gone on with. A folder that took its dataset's name is no longer there.
    fn drop(&mut self) {
        if records_in(&self.path).is_empty() {
            let _ = std::fs::remove_dir_all(&self.path);
        } else {
            forget_unfinished(&self.path);
        }
    }
}

/// A dataset or an empty folder.
fn is_replaceable(target: &Path) -> bool {
    let is_empty = || std::fs::read_dir(target).is_ok_and(|mut entries| entries.next().is_none());
    target.join(MANIFEST_FILE).is_file() || is_empty()
}

/// Temporary folders are private; a finished dataset is as readable as any new folder.
#[cfg(unix)]
fn share(folder: &Path) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    std::fs::set_permissions(folder, std::fs::Permissions::from_mode(0o755))
}

#[cfg(not(unix))]
fn share(_folder: &Path) -> std::io::Result<()> {
    Ok(())
}
