//! The bundled demo: real data that comes with the repository, made ready at its first use.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use anyhow::{Context, bail};
use terrain_core::dataset::{Dataset, TileSource};
use terrain_core::measure::Flight;
use terrain_core::prepare::{PrepareRequest, prepare};

use crate::progress::PhaseProgress;
use crate::{flights, output};

/// Where the sources lie in the repository, and where the dataset made of them goes.
const SOURCES: &str = "data/demo";
const DATASET: &str = ".dataset/demo";
const HEIGHTS: &str = "dem.tif";
const COLOURS: &str = "dom.tif";
const FLIGHT: &str = "flight.json";
/// World Mercator, which keeps the shapes of mountains true.
const EPSG: u32 = 3395;
/// Thousands of kilometres with cells of nine: mountains need some help to be seen.
const EXAGGERATION: f64 = 15.0;

/// The demo, ready to be drawn.
pub struct Demo {
    /// Its terrain.
    pub source: Arc<dyn TileSource>,
    /// Its name for people.
    pub title: String,
    /// The exaggeration it looks best with.
    pub exaggeration: f64,
    /// A flight over it: from the Bay of Biscay along the Alps and the Caucasus to the Himalaya.
    pub flight: Flight,
}

impl Demo {
    /// Opens the demo; prepares it where that has not been done yet.
    ///
    /// # Errors
    /// Where its sources are not there, or cannot be prepared.
    pub fn open() -> anyhow::Result<Self> {
        let root = find_root()?;
        let folder = root.join(DATASET);
        let dataset = match Dataset::open(&folder) {
            Ok(dataset) => dataset,
            Err(_) => prepare_at(&root, &folder)?,
        };
        let flight = flights::read(&root.join(SOURCES).join(FLIGHT), dataset.manifest())?;
        Ok(Self {
            source: Arc::new(dataset),
            title: "Eurasia".to_owned(),
            exaggeration: EXAGGERATION,
            flight,
        })
    }
}

/// The nearest folder above the current one, or above the program, that holds the demo's sources.
fn find_root() -> anyhow::Result<PathBuf> {
    let starts = [std::env::current_dir().ok(), std::env::current_exe().ok()];
    let holds_demo = |folder: &&Path| folder.join(SOURCES).join(HEIGHTS).is_file();
    let root = starts.iter().flatten().find_map(|start| start.ancestors().find(holds_demo));
    match root {
        Some(root) => Ok(root.to_owned()),
        None => bail!(
            "{SOURCES}: the demo's data are not here (run it inside the repository, or name a \
             dataset: terrain fly DATASET)"
        ),
    }
}

fn prepare_at(root: &Path, folder: &Path) -> anyhow::Result<Dataset> {
    output::say("terrain: preparing the demo, once ...");
    if let Some(parent) = folder.parent() {
        let failed = || format!("{}: cannot make the folder", parent.display());
        std::fs::create_dir_all(parent).with_context(failed)?;
    }
    let sources = root.join(SOURCES);
    let request = PrepareRequest {
        epsg: Some(EPSG),
        ..PrepareRequest::new(
            vec![sources.join(HEIGHTS)],
            vec![sources.join(COLOURS)],
            folder.to_owned(),
        )
    };
    let bar = PhaseProgress::new();
    let prepared = prepare(&request, &bar, &AtomicBool::new(false));
    bar.clear();
    prepared?;
    Ok(Dataset::open(folder)?)
}
