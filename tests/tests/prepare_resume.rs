//! An interrupted preparation goes on with the layers it has finished, and gives the same bytes.

#![expect(clippy::unwrap_used, reason = "a case fails by panicking")]

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use terrain_core::dataset::Shape;
use terrain_core::prepare::{NoProgress, PrepareRequest, Progress, prepare};
use terrain_tests::RasterFixture;

const SIDE: u32 = 300;

fn write_sources(folder: &Path, seed: u32) {
    let noise = |index: u32| (index ^ seed).wrapping_mul(2_654_435_761) >> 23;
    let heights: Vec<i16> = (0..SIDE * SIDE).map(|index| noise(index) as i16).collect();
    let picture: Vec<u8> = (0..3 * SIDE * SIDE).map(|index| noise(index) as u8).collect();
    let fixture = RasterFixture::utm([SIDE, SIDE], [432_000.0, 6_850_000.0], 30.0);
    fixture.write_i16(&folder.join("dem.tif"), &heights).unwrap();
    fixture.write_rgb(&folder.join("dom.tif"), &picture).unwrap();
}

fn request(folder: &Path, out: &str) -> PrepareRequest {
    let [dem, dom] = ["dem.tif", "dom.tif"].map(|name| vec![folder.join(name)]);
    PrepareRequest { is_resumable: true, ..PrepareRequest::new(dem, dom, folder.join(out)) }
}

/// Asks to stop when the heights are through, and remembers the phases there were.
#[derive(Default)]
struct StopAfterHeights {
    cancel: AtomicBool,
    phases: Mutex<Vec<String>>,
}

impl Progress for StopAfterHeights {
    fn advanced(&self, phase: &str, done: u64, total: u64) {
        self.phases.lock().unwrap().push(phase.to_owned());
        self.cancel.fetch_or(phase == "heights" && done == total, Ordering::Relaxed);
    }
}

/// Runs the request until its heights are written; returns the phases it went through.
fn run_until_heights(request: &PrepareRequest) -> Vec<String> {
    let stop = StopAfterHeights::default();
    let stopped = prepare(request, &stop, &stop.cancel);
    assert_eq!(stopped.is_err(), stop.cancel.load(Ordering::Relaxed));
    stop.phases.into_inner().unwrap()
}

/// Every file of a folder.
fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries
        .map(|path| {
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            (name, std::fs::read(&path).unwrap())
        })
        .collect()
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<_> =
        entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn finished_heights_are_not_made_again_and_the_bytes_are_the_same() {
    let folder = tempfile::tempdir().unwrap();
    write_sources(folder.path(), 1);
    let resumed = request(folder.path(), "resumed");
    let first = run_until_heights(&resumed);
    assert!(first.iter().any(|phase| phase == "heights"), "{first:?}");
    let kept = names(&folder.path().join(".resumed.resume"));
    assert_eq!(kept, ["heights.finished", "heights.pmtiles", "lock"]);
    assert!(!resumed.out.exists());

    let second = run_until_heights(&resumed);
    assert!(second.iter().all(|phase| phase == "colours"), "{second:?}");
    let whole = PrepareRequest { is_resumable: false, ..request(folder.path(), "whole") };
    prepare(&whole, &NoProgress, &AtomicBool::new(false)).unwrap();
    assert!(contents(&resumed.out) == contents(&whole.out));
    assert_eq!(names(folder.path()), ["dem.tif", "dom.tif", "resumed", "whole"]);
}

#[test]
fn changed_files_and_settings_start_afresh() {
    let folder = tempfile::tempdir().unwrap();
    write_sources(folder.path(), 1);
    let mut resumed = request(folder.path(), "resumed");
    run_until_heights(&resumed);
    write_sources(folder.path(), 2);
    let phases = run_until_heights(&resumed);
    assert!(phases.iter().any(|phase| phase == "heights"), "changed heights were not read");
    resumed.height_tile_texels = 64;
    let phases = run_until_heights(&resumed);
    assert!(phases.iter().any(|phase| phase == "heights"), "a changed setting was not seen");

    prepare(&resumed, &NoProgress, &AtomicBool::new(false)).unwrap();
    let whole = PrepareRequest { out: folder.path().join("whole"), ..resumed.clone() };
    prepare(&whole, &NoProgress, &AtomicBool::new(false)).unwrap();
    assert!(contents(&resumed.out) == contents(&whole.out));
}

#[test]
fn one_output_is_made_by_one_at_a_time() {
    struct TryAgain<'a>(&'a PrepareRequest, Mutex<Vec<String>>);
    impl Progress for TryAgain<'_> {
        fn advanced(&self, _phase: &str, _done: u64, _total: u64) {
            let second = prepare(self.0, &NoProgress, &AtomicBool::new(false));
            self.1.lock().unwrap().extend(second.err().map(|error| error.to_string()));
        }
    }
    let folder = tempfile::tempdir().unwrap();
    write_sources(folder.path(), 1);
    let request = request(folder.path(), "out");
    let again = TryAgain(&request, Mutex::default());
    prepare(&request, &again, &AtomicBool::new(false)).unwrap();
    let refusals = again.1.into_inner().unwrap();
    assert!(refusals.len() > 2 && refusals.iter().all(|line| line.contains("already")));
}

#[test]
fn a_globe_is_gone_on_with_too() {
    let folder = tempfile::tempdir().unwrap();
    let around = RasterFixture {
        tie: [-180.0, 90.0],
        cell: [5.0, 5.0],
        epsg: 4326,
        ..RasterFixture::utm([72, 36], [0.0, 0.0], 5.0)
    };
    let heights: Vec<i16> = (0..72 * 36).map(|index| (index * 7919 % 613) as i16).collect();
    around.write_i16(&folder.path().join("dem.tif"), &heights).unwrap();
    around.write_rgb(&folder.path().join("dom.tif"), &[90; 3 * 72 * 36]).unwrap();
    let globe = |out| PrepareRequest {
        shape: Shape::Globe,
        height_tile_texels: 32,
        colour_tile_texels: 32,
        ..request(folder.path(), out)
    };
    run_until_heights(&globe("resumed"));
    assert!(folder.path().join(".resumed.resume/heights.finished").exists());
    let phases = run_until_heights(&globe("resumed"));
    assert!(!phases.iter().any(|phase| phase == "heights"), "{phases:?}");
    let whole = PrepareRequest { is_resumable: false, ..globe("whole") };
    prepare(&whole, &NoProgress, &AtomicBool::new(false)).unwrap();
    assert_eq!(contents(&globe("resumed").out), contents(&whole.out));
}
