//! From rasters and points to a dataset.
//!
//! [`prepare`] opens the sources ([`source`]), plans the tile scheme and both layers' grids, then
//! streams each layer once from north to south: rows are resampled where they have to be, gaps in
//! heights filled, and a pyramid built that hands on rows of tiles as they are complete. Memory
//! depends on the width of the rasters, not on their size.

mod colour_layer;
mod error;
mod finished_layers;
mod globe_plan;
mod height_layer;
mod make_tin;
mod mosaic;
mod output_folder;
mod placed_points;
mod placement;
mod plan;
mod request;
mod resample;
mod row_pyramid;
mod run;
pub mod source;
mod summary;
mod texel;
mod void_fill;
mod void_surface;

use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

pub use error::PrepareError;
pub use make_tin::{MadeTin, TinRequest, make_tin};
pub use request::{PointOptions, PrepareRequest};
pub use summary::{LayerSummary, PrepareSummary};
pub(crate) use texel::{LinearColour, Texel};
pub use void_fill::{MAX_LARGE_VOID_CELLS, MAX_VOID_CELLS, VoidReport};

use self::colour_layer::write_colours;
use self::finished_layers::FinishedLayers;
use self::height_layer::write_heights;
use self::output_folder::OutputFolder;
use self::placement::name_of;
use self::plan::Plan;
use self::run::Run;
use crate::dataset::{COLOURS_FILE, Crs, HEIGHTS_FILE, MANIFEST_FILE, Manifest};
pub use crate::progress::{NoProgress, Progress};

/// Makes a dataset of rasters.
///
/// The dataset appears at `request.out` when it is whole; on an error, or once `cancel` is set,
/// nothing is left there, or beside it what [`PrepareRequest::is_resumable`] says.
pub fn prepare(
    request: &PrepareRequest,
    progress: &dyn Progress,
    cancel: &AtomicBool,
) -> Result<PrepareSummary, PrepareError> {
    let started = Instant::now();
    let run = Run { progress, cancel };
    let plan = Plan::new(request, &run)?;
    let output = OutputFolder::create(&request.out, request.is_resumable)?;
    let layers = FinishedLayers::new(output.path(), request, &plan);
    let heights = layers.find_or_write(HEIGHTS_FILE, |archive| {
        write_heights(&plan.heights, plan.height_step_m, request, archive, &run)
    })?;
    let colours = match &plan.colours {
        Some(colours) => Some(layers.find_or_write(COLOURS_FILE, |archive| {
            write_colours(colours, request, archive, &run)
        })?),
        None => None,
    };

    let mut notes = plan.notes.clone();
    notes.extend(summary::void_notes(&heights.voids, request));
    notes.extend(summary::zero_note(heights.cells_at_zero, request));
    let sources = request.heights.iter().chain(&request.colours);
    let manifest = Manifest {
        shape: request.shape,
        version: Manifest::VERSION,
        crs: Crs { epsg: Some(plan.crs.epsg()), name: plan.crs.name() },
        scheme: plan.scheme,
        data_extent: plan.data_extent,
        heights: heights.layer.clone(),
        colours: colours.as_ref().map(|colours| colours.layer.clone()),
        sources: sources.map(|path| name_of(path)).collect(),
        notes,
    };
    write_manifest(&manifest, output.path())?;
    output.finish()?;
    Ok(PrepareSummary::new(manifest, &plan, &heights, colours.as_ref(), started.elapsed()))
}

fn write_manifest(manifest: &Manifest, folder: &Path) -> Result<(), PrepareError> {
    let path = folder.join(MANIFEST_FILE);
    let failed = |reason: String| PrepareError::Output { path: path.clone(), reason };
    let text = serde_json::to_string_pretty(manifest).map_err(|error| failed(error.to_string()))?;
    std::fs::write(&path, text + "\n").map_err(|error| failed(error.to_string()))
}
