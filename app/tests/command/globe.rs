//! Datasets of the whole globe: made, told of and drawn, with places in degrees.

use std::path::{Path, PathBuf};

use tempfile::TempDir;

use crate::harness::{assert_fails_naming, assert_success, has_gpu, run, stderr, stdout, terrain};

/// A globe of a picture that is green in the west and red in the east, in tiles of 32 texels.
fn globe(folder: &TempDir) -> PathBuf {
    let picture = folder.path().join("earth.png");
    let colour = |x: u32, _| image::Rgb(if x < 64 { [20, 160, 20] } else { [180, 20, 20] });
    image::RgbImage::from_fn(128, 64, colour).save(&picture).unwrap();
    let dataset = folder.path().join("earth");
    let mut command =
        terrain(["prepare", "--globe", "--dom-tile", "32", "--dom-encoding", "rgba8"]);
    let output = command.arg("--dom").arg(&picture).arg("--out").arg(&dataset).output().unwrap();
    assert_success(&output);
    assert!(stdout(&output).contains("ground   the globe"), "{}", stdout(&output));
    dataset
}

/// The mean colour of a picture that looks straight down at a place, drawn with these options.
fn seen_from_above(dataset: &Path, place: &str, options: &[&str]) -> [f64; 3] {
    let picture = dataset.with_file_name("view.png");
    let mut command = terrain(["render"]);
    command.arg(dataset).args(["--size", "48x48", "--strategy", "rtt-quadtree", "--camera"]);
    command.arg(format!("{place},height=300000,pitch=-90")).args(options).arg("--out");
    assert_success(&command.arg(&picture).output().unwrap());
    let pixels = image::open(picture).unwrap().into_rgb8();
    let mean = |part: usize| pixels.pixels().map(|p| f64::from(p.0[part])).sum::<f64>() / 2304.0;
    [mean(0), mean(1), mean(2)]
}

#[test]
fn a_globe_drawn_flat_is_the_map_with_places_in_degrees() {
    if !has_gpu() {
        return;
    }
    let folder = TempDir::new().unwrap();
    let dataset = globe(&folder);
    for options in [&[][..], &["--detail", "6"]] {
        let west = seen_from_above(&dataset, "x=-60,y=40", options);
        let east = seen_from_above(&dataset, "x=120,y=-40", options);
        assert!(west[1] > west[0] + 40.0, "{west:?} is not green");
        assert!(east[0] > east[1] + 40.0, "{east:?} is not red");
    }
    let output = run(["render".as_ref(), dataset.as_os_str(), "--json".as_ref()]
        .iter()
        .chain(["--detail".as_ref(), "2".as_ref(), "--flight".as_ref(), "hover".as_ref()].iter()));
    assert_fails_naming(&output, &["2 levels of imagery", "has 3"]);
}

#[test]
fn what_is_said_of_a_globe_is_in_degrees() {
    let folder = TempDir::new().unwrap();
    let dataset = globe(&folder);
    let told = run(["info".as_ref(), dataset.as_os_str()]);
    assert_success(&told);
    let words = "the globe: longitude -180 .. 180, latitude -90 .. 90 degrees";
    assert!(stdout(&told).contains(words), "{}", stdout(&told));

    let mut command = terrain(["render"]);
    command.arg(&dataset).args(["--json", "--camera", "x=0,y=91,height=1000"]);
    assert_fails_naming(&command.output().unwrap(), &["y=91", "latitude"]);

    let flight = folder.path().join("flight.json");
    let metres = r#"{"crs": "EPSG:32662", "fps": 30, "keyframes": [
        {"t": 0, "x": 0, "y": 0, "height": 1e6, "heading": 0, "pitch": -30, "fov": 50}]}"#;
    std::fs::write(&flight, metres).unwrap();
    let mut command = terrain(["fly"]);
    command.arg(&dataset).args(["--headless", "--flight"]).arg(&flight);
    let output = command.output().unwrap();
    assert_fails_naming(&output, &["the flight is in EPSG:32662", "the dataset in EPSG:4326"]);
}

#[test]
fn flights_made_for_a_globe_are_in_degrees_too() {
    if !has_gpu() {
        return;
    }
    let folder = TempDir::new().unwrap();
    let dataset = globe(&folder);
    let recorded = folder.path().join("hover.json");
    let mut command = terrain(["fly"]);
    command.arg(&dataset).args(["--headless", "--flight", "hover", "--frames-at", "1"]);
    command.args(["--size", "32x32", "--record"]).arg(&recorded);
    assert_success(&command.output().unwrap());
    let text = std::fs::read_to_string(recorded).unwrap();
    let flight: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(flight["crs"], "EPSG:4326");
    let latitude_deg = flight["keyframes"][0]["y"].as_f64().unwrap();
    assert!((30.0..50.0).contains(&latitude_deg), "{latitude_deg}");
}

#[test]
fn a_globe_has_a_crs_of_its_own() {
    for arguments in [
        ["prepare", "--globe", "--dem", "x.tif", "--crs", "EPSG:4087", "--out", "y"].as_slice(),
        &["prepare", "--globe", "--dem", "x.tif", "--keep-voids", "--out", "y"],
        &["prepare", "--globe", "--out", "y"],
        &["prepare", "--dom", "x.png", "--out", "y"],
    ] {
        let output = run(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", stderr(&output));
    }
}
