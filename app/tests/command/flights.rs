//! Flights by name, and the files they are written to.

use std::path::Path;
use std::process::Output;

use crate::harness::{assert_fails_naming, assert_success, dataset, has_gpu, terrain};

/// Flies a frame of the flight in this folder, and writes the flight down.
fn fly(folder: &Path, flight: &str, record: &str) -> Output {
    let mut command = terrain(["fly"]);
    command.arg(dataset().canonicalize().unwrap()).current_dir(folder);
    command.args(["--headless", "--size", "32x18", "--frames-at", "1", "--flight", flight]);
    command.args(["--record", record]).output().unwrap()
}

#[test]
fn a_flight_has_a_name_but_a_file_of_that_name_goes_first() {
    if !has_gpu() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let written = |record: &str| std::fs::read_to_string(folder.join(record)).unwrap();
    for (flight, record) in [("valley", "planned.json"), ("hover", "hover.json")] {
        assert_success(&fly(folder, flight, record));
    }
    assert_ne!(written("planned.json"), written("hover.json"));
    assert_success(&fly(folder, "planned.json", "again.json"));
    assert_eq!(written("again.json"), written("planned.json"), "read as it was written");
    std::fs::copy(folder.join("hover.json"), folder.join("valley")).unwrap();
    assert_success(&fly(folder, "valley", "file.json"));
    assert_eq!(written("file.json"), written("hover.json"));
    assert_fails_naming(&fly(folder, "loop", "none.json"), &["loop", "forward-low", "teleport"]);
}

#[test]
fn a_picture_can_be_taken_from_a_flight() {
    if !has_gpu() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let picture = |at: &str| {
        let out = folder.path().join(format!("{at}.png"));
        let mut command = terrain(["render"]);
        command.arg(dataset()).args(["--flight", "spin", "--size", "32x18", "--at", at]);
        assert_success(&command.arg("--out").arg(&out).output().unwrap());
        std::fs::read(out).unwrap()
    };
    let [start, turned, past] = ["0", "3", "12"].map(picture);
    assert_ne!(start, turned);
    assert_eq!(start, past, "once round");
}
