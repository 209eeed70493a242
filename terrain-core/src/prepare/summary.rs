use std::time::Duration;

use super::PrepareRequest;
use super::colour_layer::WrittenColours;
use super::height_layer::WrittenHeights;
use super::plan::{LayerPlan, Plan};
use super::void_fill::{MAX_LARGE_VOID_CELLS, MAX_VOID_CELLS, VoidReport};
use crate::dataset::Manifest;

/// What was made, and at what cost.
#[derive(Clone, Debug)]
pub struct PrepareSummary {
    /// The dataset's manifest, its notes included.
    pub manifest: Manifest,
    /// The height layer.
    pub heights: LayerSummary,
    /// The colour layer, where there is one.
    pub colours: Option<LayerSummary>,
    /// What became of gaps in the heights.
    pub voids: VoidReport,
    /// Time from start to end.
    pub elapsed: Duration,
}

/// What was made of one layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LayerSummary {
    /// Texels of the finest level's raster, along x and y.
    pub size_texels: [usize; 2],
    /// Tiles written, all levels.
    pub tiles: u64,
    /// Bytes of their payloads.
    pub payload_bytes: u64,
}

impl LayerSummary {
    fn new(plan: &LayerPlan, tiles: u64, payload_bytes: u64) -> Self {
        let target = plan.rows.target();
        let size_texels = [target.width, target.height];
        Self { size_texels, tiles, payload_bytes }
    }
}

impl PrepareSummary {
    pub(super) fn new(
        manifest: Manifest,
        plan: &Plan,
        heights: &WrittenHeights,
        colours: Option<&WrittenColours>,
        elapsed: Duration,
    ) -> Self {
        let colours =
            plan.colours.as_ref().zip(colours).map(|(plan, written)| {
                LayerSummary::new(plan, written.tiles, written.payload_bytes)
            });
        Self {
            manifest,
            heights: LayerSummary::new(&plan.heights, heights.tiles, heights.payload_bytes),
            colours,
            voids: heights.voids,
            elapsed,
        }
    }
}

/// What the manifest says of a globe's ground that no source has heights of.
pub(super) fn zero_note(cells: u64, request: &PrepareRequest) -> Option<String> {
    if cells == 0 {
        return None;
    }
    Some(match request.heights.is_empty() {
        true => "no heights are given: the ground is the ellipsoid".to_owned(),
        false => format!("heights are 0 where the sources hold none ({cells} cells)"),
    })
}

/// What the manifest says of gaps.
pub(super) fn void_notes(voids: &VoidReport, request: &PrepareRequest) -> Vec<String> {
    let mut notes = Vec::new();
    if request.keep_voids {
        notes.push("gaps in the heights are left as they are".to_owned());
    }
    if voids.voids_filled > 0 {
        notes.push(format!(
            "{} gaps in the heights ({} cells) filled from their rims{}",
            voids.voids_filled,
            voids.cells_filled,
            if request.fill_voids_km2.is_some() { " by natural neighbours" } else { "" }
        ));
    }
    if voids.voids_left > 0 {
        let limit = match request.fill_voids_km2 {
            Some(km2) => format!("larger than {km2} km2 or {MAX_LARGE_VOID_CELLS} cells across"),
            None => format!("wider than {MAX_VOID_CELLS} cells"),
        };
        notes.push(format!("{} gaps {limit} left as they are", voids.voids_left));
    }
    notes
}
