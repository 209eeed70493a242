//! The reference against closed forms, against itself with other filters, and against the GPU.

#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a step that fails fails the test")]
#![allow(clippy::print_stdout, reason = "measured values are to be seen")]

mod drawn;
mod filters;
mod known_ground;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::dvec3;
use terrain_core::CameraView;
use terrain_core::dataset::Dataset;
use terrain_core::prepare::{NoProgress, PrepareRequest, prepare};
use terrain_core::reference::{
    ReferencePicture, ReferenceScene, ReferenceSettings, render_reference,
};

/// Side of the root of the surfaces given by formulas.
const ROOT_M: f64 = 20_480.0;

fn take(
    scene: &ReferenceScene,
    view: &CameraView,
    settings: &ReferenceSettings,
) -> ReferencePicture {
    render_reference(scene, view, settings, &NoProgress, &AtomicBool::new(false)).unwrap()
}

/// Prepares rasters into a folder that lives as long as the answer.
fn prepared(dem: PathBuf, dom: PathBuf, epsg: Option<u32>) -> (tempfile::TempDir, Arc<Dataset>) {
    let folder = tempfile::tempdir().unwrap();
    let mut request = PrepareRequest::new(vec![dem], vec![dom], folder.path().join("dataset"));
    request.epsg = epsg;
    prepare(&request, &NoProgress, &AtomicBool::new(false)).unwrap();
    let dataset = Arc::new(Dataset::open(&request.out).unwrap());
    (folder, dataset)
}

fn demo() -> (tempfile::TempDir, Arc<Dataset>) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/demo");
    prepared(folder.join("dem.tif"), folder.join("dom.tif"), Some(3395))
}

fn himalaya() -> CameraView {
    CameraView {
        eye: dvec3(9.0e6, 2.75e6, 390_000.0),
        heading_deg: 20.0,
        pitch_deg: -16.0,
        fov_y_deg: 50.0,
        viewport_px: [160, 90],
    }
}

/// Differences of two pictures' colours in 8-bit steps, sorted.
fn differences(a: &[[u8; 4]], b: &[[u8; 4]]) -> Vec<u8> {
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    let mut steps: Vec<u8> = pairs.map(|(a, b)| a.abs_diff(*b)).collect();
    steps.sort_unstable();
    steps
}

fn mean(steps: &[u8]) -> f64 {
    // Of three channels: alpha is the same everywhere.
    let sum: f64 = steps.iter().copied().map(f64::from).sum();
    sum / steps.len() as f64 * 4.0 / 3.0
}
