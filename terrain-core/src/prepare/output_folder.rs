use std::path::{Path, PathBuf};

use tempfile::TempDir;

use super::PrepareError;
use crate::dataset::MANIFEST_FILE;

/// A folder that is written under a temporary name beside its own and takes its name when whole.
/// Dropped before that, it leaves nothing behind.
pub struct OutputFolder {
    target: PathBuf,
    partial: TempDir,
}

impl OutputFolder {
    /// Starts the folder. A dataset at `target` will be replaced; anything else there is an error.
    pub fn create(target: &Path) -> Result<Self, PrepareError> {
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
        let prefix = format!(".{}.partial-", name.to_string_lossy());
        match tempfile::Builder::new().prefix(&prefix).tempdir_in(parent) {
            Ok(partial) => Ok(Self { target: target.to_owned(), partial }),
            Err(error) => failed(parent, format!("cannot write there: {error}")),
        }
    }

    /// Where files are written meanwhile.
    pub fn path(&self) -> &Path {
        self.partial.path()
    }

    /// Gives the folder its name; a dataset that had it is removed.
    pub fn finish(self) -> Result<(), PrepareError> {
        let failed = |error: std::io::Error| PrepareError::Output {
            path: self.target.clone(),
            reason: error.to_string(),
        };
        share(self.partial.path()).map_err(failed)?;
        if self.target.exists() {
            // The old dataset steps aside first, so that one of the two is always whole.
            let aside = self.partial.path().with_extension("old");
            std::fs::rename(&self.target, &aside).map_err(failed)?;
            if let Err(error) = std::fs::rename(self.partial.path(), &self.target) {
                std::fs::rename(&aside, &self.target).map_err(failed)?;
                return Err(failed(error));
            }
            std::fs::remove_dir_all(&aside).map_err(failed)?;
        } else {
            std::fs::rename(self.partial.path(), &self.target).map_err(failed)?;
        }
        // What was renamed is no longer there to be removed.
        let _ = self.partial.keep();
        Ok(())
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
