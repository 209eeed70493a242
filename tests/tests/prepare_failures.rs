//! What preparing refuses: one line that names the file and the cause, and nothing left behind.

#![expect(clippy::unwrap_used, reason = "a case fails by panicking")]

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use terrain_core::dataset::{Dataset, OpenError, TileSource};
use terrain_core::prepare::{NoProgress, PrepareRequest, Progress, prepare};
use terrain_tests::{RasterFixture, Storage};

const ORIGIN: [f64; 2] = [432_000.0, 6_850_000.0];

fn fixture() -> RasterFixture {
    RasterFixture::utm([70, 70], ORIGIN, 30.0)
}

fn heights() -> Vec<i16> {
    (0..70 * 70).map(|index| (index * 37 % 900) as i16).collect()
}

fn request(folder: &Path, dem: &str) -> PrepareRequest {
    PrepareRequest::new(vec![folder.join(dem)], Vec::new(), folder.join("out"))
}

/// Runs a request that must fail, and returns its one line.
fn refusal(request: &PrepareRequest) -> String {
    let error = prepare(request, &NoProgress, &AtomicBool::new(false)).unwrap_err();
    let line = error.to_string();
    assert!(!line.contains('\n'), "{line}");
    let folder = request.out.parent().unwrap();
    let left: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .filter(|name| name.contains("out"))
        .collect();
    assert!(left.is_empty(), "left behind: {left:?}");
    line
}

#[test]
fn files_that_are_no_rasters_are_named_with_their_cause() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    fixture().write_i16(&path("whole.tif"), &heights()).unwrap();
    let whole = std::fs::read(path("whole.tif")).unwrap();
    std::fs::write(path("text.tif"), "heights of the Alps").unwrap();
    std::fs::write(path("empty.tif"), "").unwrap();
    std::fs::write(path("head.tif"), &whole[..6]).unwrap();
    let cases = [
        ("text.tif", "not a raster"),
        ("empty.tif", "empty"),
        ("missing.tif", "No such file"),
        ("head.tif", "truncated or damaged"),
    ];
    for (name, cause) in cases {
        let line = refusal(&request(folder.path(), name));
        assert!(line.contains(name) && line.contains(cause), "{line}");
    }
    // Cut anywhere, a raster is an error, never a panic or a silent half.
    for length in (8..whole.len() - 1).step_by(97) {
        std::fs::write(path("cut.tif"), &whole[..length]).unwrap();
        let line = refusal(&request(folder.path(), "cut.tif"));
        assert!(line.contains("cut.tif"), "{length}: {line}");
    }
}

#[test]
fn absurd_places_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let cases = [
        RasterFixture { tie: [f64::NAN, 0.0], ..fixture() },
        RasterFixture { cell: [0.0, 30.0], ..fixture() },
        RasterFixture { cell: [30.0, -30.0], ..fixture() },
        RasterFixture { tie: [1e30, 0.0], ..fixture() },
        RasterFixture { tie: [700.0, 40.0], cell: [0.1, 0.1], epsg: 4326, ..fixture() },
        RasterFixture { tie: [10.0, 95.0], cell: [0.1, 0.1], epsg: 4326, ..fixture() },
    ];
    for case in cases {
        case.write_i16(&folder.path().join("dem.tif"), &heights()).unwrap();
        let line = refusal(&request(folder.path(), "dem.tif"));
        assert!(line.contains("dem.tif") && line.contains("georeference"), "{case:?}: {line}");
    }
}

#[test]
fn unknown_or_missing_systems_are_refused_with_the_way_out() {
    let folder = tempfile::tempdir().unwrap();
    let dem = folder.path().join("dem.tif");
    RasterFixture { epsg: 32767, ..fixture() }.write_i16(&dem, &heights()).unwrap();
    let mut request = request(folder.path(), "dem.tif");
    assert!(refusal(&request).contains("--crs EPSG:n"));
    request.epsg = Some(999_999);
    assert!(refusal(&request).contains("EPSG:999999"));
    request.epsg = Some(4326);
    assert!(refusal(&request).contains("in metres"));
    request.epsg = Some(32632);
    assert!(prepare(&request, &NoProgress, &AtomicBool::new(false)).is_ok());
}

#[test]
fn pictures_that_do_not_meet_the_heights_or_have_no_place_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    fixture().write_i16(&folder.path().join("dem.tif"), &heights()).unwrap();
    let mut request = request(folder.path(), "dem.tif");
    request.colours = vec![folder.path().join("dom.tif")];
    RasterFixture { tie: [600_000.0, 6_850_000.0], ..fixture() }
        .write_rgb(&request.colours[0], &[5; 70 * 70 * 3])
        .unwrap();
    assert!(refusal(&request).contains("does not meet"));
    request.colours = vec![folder.path().join("dom.png")];
    image::RgbImage::new(8, 8).save(&request.colours[0]).unwrap();
    assert!(refusal(&request).contains("--dom-extent"));
}

#[test]
fn what_is_no_dataset_is_not_overwritten_and_a_dataset_is() {
    let folder = tempfile::tempdir().unwrap();
    fixture().write_i16(&folder.path().join("dem.tif"), &heights()).unwrap();
    let request = request(folder.path(), "dem.tif");
    std::fs::create_dir(&request.out).unwrap();
    std::fs::write(request.out.join("letter.txt"), "dear").unwrap();
    let error = prepare(&request, &NoProgress, &AtomicBool::new(false)).unwrap_err();
    assert!(error.to_string().contains("no dataset"), "{error}");
    assert_eq!(std::fs::read(request.out.join("letter.txt")).unwrap(), b"dear");
    std::fs::remove_file(request.out.join("letter.txt")).unwrap();
    for _ in 0..2 {
        prepare(&request, &NoProgress, &AtomicBool::new(false)).unwrap();
        assert!(Dataset::open(&request.out).unwrap().inspect(true, &NoProgress).faults.is_empty());
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2, "dem.tif and out");
}

#[test]
fn a_stopped_run_leaves_nothing() {
    struct StopAtOnce<'a>(&'a AtomicBool);
    impl Progress for StopAtOnce<'_> {
        fn advanced(&self, _phase: &str, _done: u64, _total: u64) {
            self.0.store(true, Ordering::Relaxed);
        }
    }
    let folder = tempfile::tempdir().unwrap();
    fixture().write_i16(&folder.path().join("dem.tif"), &heights()).unwrap();
    let cancel = AtomicBool::new(false);
    let request = request(folder.path(), "dem.tif");
    let error = prepare(&request, &StopAtOnce(&cancel), &cancel).unwrap_err();
    assert!(error.to_string().contains("stopped"), "{error}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn a_damaged_dataset_says_what_is_wrong() {
    let folder = tempfile::tempdir().unwrap();
    let storage = Storage::Plain;
    RasterFixture { storage, ..fixture() }
        .write_i16(&folder.path().join("dem.tif"), &heights())
        .unwrap();
    let request = request(folder.path(), "dem.tif");
    prepare(&request, &NoProgress, &AtomicBool::new(false)).unwrap();
    let archive: PathBuf = request.out.join("heights.pmtiles");
    let whole = std::fs::read(&archive).unwrap();
    // The tile's bytes follow the 16 KiB of header and directory.
    let mut damaged = whole.clone();
    damaged[16 * 1024 + 500] ^= 1;
    std::fs::write(&archive, &damaged).unwrap();
    let dataset = Dataset::open(&request.out).unwrap();
    let faults = dataset.inspect(true, &NoProgress).faults;
    assert!(faults.len() == 1 && faults[0].contains("checksum"), "{faults:?}");
    assert_eq!(dataset.heights_present().len(), 1);
    drop(dataset);
    for length in (0..whole.len()).step_by(1009) {
        std::fs::write(&archive, &whole[..length]).unwrap();
        if let Ok(dataset) = Dataset::open(&request.out) {
            assert!(!dataset.inspect(true, &NoProgress).faults.is_empty(), "cut to {length}");
        }
    }
    std::fs::write(request.out.join("manifest.json"), "{\"version\": 77}").unwrap();
    let opened = Dataset::open(&request.out);
    assert!(matches!(opened, Err(OpenError::OtherVersion { found: 77, .. })));
    assert!(matches!(Dataset::open(folder.path()), Err(OpenError::NotADataset { .. })));
}

#[test]
fn a_cut_jpeg_and_heights_given_as_a_picture_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    fixture().write_i16(&path("dem.tif"), &heights()).unwrap();
    let picture = image::RgbImage::from_fn(300, 300, |x, y| image::Rgb([x as u8, y as u8, 7]));
    picture.save(path("dom.jpg")).unwrap();
    std::fs::write(path("dom.jgw"), "7\n0\n0\n-7\n432003.5\n6849996.5\n").unwrap();
    let whole = std::fs::read(path("dom.jpg")).unwrap();
    let mut request = request(folder.path(), "dem.tif");
    request.colours = vec![path("dom.jpg")];
    for length in [whole.len() / 3, whole.len() - 200, whole.len() - 1] {
        std::fs::write(path("dom.jpg"), &whole[..length]).unwrap();
        let line = refusal(&request);
        assert!(line.contains("dom.jpg") && line.contains("truncated"), "{length}: {line}");
    }
    // Some programs write a little after the end.
    std::fs::write(path("dom.jpg"), [&whole[..], b"written by a camera"].concat()).unwrap();
    assert!(prepare(&request, &NoProgress, &AtomicBool::new(false)).is_ok());
    std::fs::remove_dir_all(&request.out).unwrap();
    request.colours = vec![path("dem.tif")];
    let line = refusal(&request);
    assert!(line.contains("heights, not a picture"), "{line}");
}
