//! Synthetic rasters from outside: what is written is what is read, and nothing half-made stays.

#![expect(clippy::unwrap_used, reason = "a case fails by panicking")]

use std::path::Path;
use std::sync::LazyLock;
use std::sync::atomic::{AtomicBool, Ordering};

use tempfile::TempDir;
use terrain_core::dataset::{Dataset, TileSource};
use terrain_core::prepare::source::{Window, open_raster};
use terrain_core::prepare::{NoProgress, PrepareRequest, Progress, prepare};
use terrain_core::synth::{Preset, SynthError, SynthRequest, SynthSummary, synthesise};
use tiff::decoder::Decoder;
use tiff::tags::Tag;

const SIDE: usize = 250;

/// The smallest preset, made once for all cases.
static TINY: LazyLock<(TempDir, SynthSummary)> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("tiny");
    let summary = synthesise(&request(&out), &NoProgress, &AtomicBool::new(false)).unwrap();
    (folder, summary)
});

fn request(out: &Path) -> SynthRequest {
    let preset = Preset::by_name("sichuan-tiny").unwrap();
    SynthRequest { preset, seed: 1, out: out.to_owned() }
}

fn heights_m() -> Vec<f32> {
    let source = open_raster(&TINY.1.heights_path).unwrap();
    let side = SIDE as u32;
    source.read_heights(Window { column: 0, row: 0, width: side, height: side }).unwrap()
}

/// Asks to stop once a phase has come this far.
struct StopIn<'a> {
    phase: &'a str,
    cancel: AtomicBool,
}

impl Progress for StopIn<'_> {
    fn advanced(&self, phase: &str, done: u64, _total: u64) {
        if phase == self.phase && done > 0 {
            self.cancel.store(true, Ordering::Relaxed);
        }
    }
}

#[test]
fn files_say_that_they_are_synthetic_and_where_they_lie() {
    for (path, what) in [(&TINY.1.heights_path, "heights"), (&TINY.1.colours_path, "picture")] {
        let mut decoder = Decoder::new(std::fs::File::open(path).unwrap()).unwrap();
        let text = decoder.get_tag_ascii_string(Tag::ImageDescription).unwrap();
        assert!(text.starts_with("SYNTHETIC, not a real place") && text.contains(what), "{text}");
        assert!(text.contains("sichuan-tiny") && text.contains("seed 1"), "{text}");
        let source = open_raster(path).unwrap();
        assert_eq!(source.info().epsg, Some(32648));
        let grid = source.info().grid.unwrap();
        let [x, y] = request(path).preset.corner_m();
        assert_eq!([grid.origin.x, grid.origin.y], [x, y]);
        let extent_m = grid.cell * f64::from(source.info().size[0]);
        assert_eq!(extent_m.to_array(), [7_500.0, 7_500.0]);
    }
}

#[test]
fn the_ground_is_as_rugged_as_mountains_are() {
    let heights_m = heights_m();
    let [lowest_m, highest_m] = TINY.1.height_range_m.map(f32::from);
    assert_eq!(heights_m.iter().copied().fold(f32::INFINITY, f32::min), lowest_m);
    assert_eq!(heights_m.iter().copied().fold(0.0, f32::max), highest_m);
    assert!(highest_m - lowest_m > 1_200.0, "{lowest_m} .. {highest_m}");
    let mut slopes: Vec<f32> = (1..SIDE - 1)
        .flat_map(|row| (1..SIDE - 1).map(move |column| row * SIDE + column))
        .map(|cell| {
            let east = heights_m[cell + 1] - heights_m[cell - 1];
            let south = heights_m[cell + SIDE] - heights_m[cell - SIDE];
            east.hypot(south) / 60.0
        })
        .collect();
    slopes.sort_by(f32::total_cmp);
    let [median, steep] = [0.5, 0.999].map(|share| slopes[(share * slopes.len() as f64) as usize]);
    // 22 to 45 degrees, and hardly a cell beyond 66.
    assert!((0.4..1.0).contains(&median) && steep < 2.25, "median {median}, 99.9 % {steep}");
}

#[test]
fn fine_ground_has_few_hollows() {
    let heights_m = heights_m();
    let is_hollow = |cell: usize| {
        let around = [cell - SIDE - 1, cell - SIDE, cell - SIDE + 1, cell - 1];
        let around = around.into_iter().chain([cell + 1, cell + SIDE - 1]);
        let mut around = around.chain([cell + SIDE, cell + SIDE + 1]);
        around.all(|near| heights_m[near] > heights_m[cell])
    };
    let inner = (1..SIDE - 1).flat_map(|row| (1..SIDE - 1).map(move |column| row * SIDE + column));
    let hollows = inner.filter(|&cell| is_hollow(cell)).count();
    // White noise has one in nine cells.
    assert!(hollows < SIDE * SIDE / 200, "{hollows} of {} cells", SIDE * SIDE);
}

#[test]
fn preparing_reads_what_was_written() {
    let folder = tempfile::tempdir().unwrap();
    let sources = [&TINY.1.heights_path, &TINY.1.colours_path].map(|path| vec![path.clone()]);
    let [dem, dom] = sources;
    let request = PrepareRequest::new(dem, dom, folder.path().join("dataset"));
    let summary = prepare(&request, &NoProgress, &AtomicBool::new(false)).unwrap();
    assert_eq!(summary.heights.size_texels, [SIDE, SIDE]);
    assert_eq!(summary.colours.unwrap().size_texels, [3 * SIDE, 3 * SIDE]);
    let dataset = Dataset::open(&request.out).unwrap();
    let manifest = dataset.manifest();
    assert_eq!(manifest.crs.epsg, Some(32648));
    assert_eq!(manifest.data_extent.size_m().to_array(), [7_500.0, 7_500.0]);
    let range = manifest.heights.range;
    assert_eq!([range.min_m, range.max_m], TINY.1.height_range_m.map(f32::from));
}

#[test]
fn bytes_do_not_depend_on_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let again = request(&folder.path().join("again"));
    let again = synthesise(&again, &NoProgress, &AtomicBool::new(false)).unwrap();
    for (first, second) in
        [(&TINY.1.heights_path, &again.heights_path), (&TINY.1.colours_path, &again.colours_path)]
    {
        assert!(std::fs::read(first).unwrap() == std::fs::read(second).unwrap());
    }
}

#[test]
fn stopped_work_leaves_nothing() {
    for phase in ["raising mountains", "drawing"] {
        let folder = tempfile::tempdir().unwrap();
        let stop = StopIn { phase, cancel: AtomicBool::new(false) };
        let stopped = synthesise(&request(&folder.path().join("new")), &stop, &stop.cancel);
        assert!(matches!(stopped, Err(SynthError::Cancelled)));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "in {phase}");
    }
}

#[test]
fn files_that_are_there_are_never_replaced() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("dom.tif"), "mine").unwrap();
    let request = request(folder.path());
    let refused = synthesise(&request, &NoProgress, &AtomicBool::new(false));
    let text = refused.unwrap_err().to_string();
    assert!(text.contains("dom.tif") && text.contains("--out"), "{text}");
    assert_eq!(std::fs::read(folder.path().join("dom.tif")).unwrap(), b"mine");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}
