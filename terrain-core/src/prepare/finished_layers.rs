//! What an interrupted preparation leaves to go on with: archives of whole layers, each with a record
//! of what it was made of.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::plan::Plan;
use super::{PrepareError, PrepareRequest};
use crate::dataset::{COLOURS_FILE, HEIGHTS_FILE};

/// The finished layers of one request in a folder.
pub struct FinishedLayers<'a> {
    folder: &'a Path,
    /// Everything the archives' bytes depend on, as text; `None` where nothing is to be resumed.
    made_of: Option<String>,
}

/// Stands beside a finished archive.
#[derive(Serialize, Deserialize)]
struct Record<L> {
    made_of: String,
    written: L,
}

impl<'a> FinishedLayers<'a> {
    /// Those in the folder that the request, its files as they are and this program's version
    /// would give again.
    pub fn new(folder: &'a Path, request: &PrepareRequest, plan: &Plan) -> Self {
        let made_of = request.is_resumable.then(|| {
            let version = env!("CARGO_PKG_VERSION");
            let settings = PrepareRequest { out: PathBuf::new(), ..request.clone() };
            let paths = request.heights.iter().chain(&request.colours);
            let files: Vec<_> = paths.map(|path| state_of(path)).collect();
            format!("{version}; {settings:?}; {files:?}; {:?}", plan.grids())
        });
        Self { folder, made_of }
    }

    /// The layer of an archive, where it was finished before; else writes it and, where it may be
    /// gone on with later, notes that it is finished.
    pub fn find_or_write<L: Serialize + DeserializeOwned>(
        &self,
        archive: &str,
        write: impl FnOnce(&Path) -> Result<L, PrepareError>,
    ) -> Result<L, PrepareError> {
        let path = self.folder.join(archive);
        let Some(made_of) = &self.made_of else { return write(&path) };
        if let Some(written) = find(&path, made_of) {
            return Ok(written);
        }
        let record = record_of(&path);
        let failed = |reason: String| PrepareError::Output { path: record.clone(), reason };
        // An outdated record must not be taken for one of the archive that is written now.
        if record.exists() {
            std::fs::remove_file(&record).map_err(|error| failed(error.to_string()))?;
        }
        let written = write(&path)?;
        note(&path, &Record { made_of: made_of.clone(), written: &written }).map_err(failed)?;
        Ok(written)
    }
}

fn find<L: DeserializeOwned>(archive: &Path, made_of: &str) -> Option<L> {
    let text = std::fs::read_to_string(record_of(archive)).ok()?;
    let record: Record<L> = serde_json::from_str(&text).ok()?;
    (record.made_of == made_of && archive.is_file()).then_some(record.written)
}

/// The record comes after the archive, on the disk too, and is there whole or not at all.
fn note<L: Serialize>(archive: &Path, record: &Record<L>) -> Result<(), String> {
    let text = serde_json::to_string(record).map_err(|error| error.to_string())?;
    let path = record_of(archive);
    let unfinished = path.with_extension("new");
    File::open(archive)
        .and_then(|archive| archive.sync_all())
        .and_then(|()| std::fs::write(&unfinished, text))
        .and_then(|()| std::fs::rename(&unfinished, path))
        .map_err(|error| error.to_string())
}

/// Size and time of change: enough to see that a file is another.
fn state_of(path: &Path) -> Option<(u64, u128)> {
    let metadata = path.metadata().ok()?;
    let changed = metadata.modified().ok()?.duration_since(UNIX_EPOCH).ok()?;
    Some((metadata.len(), changed.as_nanos()))
}

fn record_of(archive: &Path) -> PathBuf {
    archive.with_extension("finished")
}

/// The records in a folder.
pub fn records_in(folder: &Path) -> Vec<PathBuf> {
    let records = [HEIGHTS_FILE, COLOURS_FILE].map(|name| record_of(&folder.join(name)));
    records.into_iter().filter(|record| record.exists()).collect()
}

/// Removes the archives that no record says to be finished.
pub fn forget_unfinished(folder: &Path) {
    for archive in [HEIGHTS_FILE, COLOURS_FILE].map(|name| folder.join(name)) {
        if !record_of(&archive).exists() {
            // Where it was not begun there is nothing to remove.
            let _ = std::fs::remove_file(archive);
        }
    }
}
