//! Pictures, coordinates and tables of flights.

use std::path::Path;

use crate::harness::{
    assert_fails_naming, assert_success, dataset, has_gpu, root, run, stdout, terrain,
};

/// Over northern India, looking at the Himalaya.
const CAMERA: &str = "x=9000000,y=2500000,height=900000,heading=15,pitch=-22,fov=50";

#[test]
fn a_picture_and_its_coordinates_agree_on_where_the_sky_is() {
    if !has_gpu() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let (picture, array) = (folder.path().join("view.png"), folder.path().join("c.npy"));
    let mut command = terrain(["render"]);
    command.arg(dataset()).args(["--camera", CAMERA, "--size", "160x90", "--json", "--out"]);
    let output = command.arg(&picture).arg("--coordinates").arg(&array).output().unwrap();
    assert_success(&output);

    let record: serde_json::Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(record["tiles_missing"], 0, "the picture is settled");
    assert!(record["upload_dem_bytes"].as_u64().unwrap() > 0);
    let size = image::image_dimensions(&picture).unwrap();
    assert_eq!(size, (160, 90));

    let points = read_npy(&array);
    assert_eq!(points.len(), 160 * 90);
    let is_sky = |row: usize| points[row * 160..(row + 1) * 160].iter().all(|p| p[0].is_nan());
    assert!(is_sky(0), "the top row is sky");
    let ground = points[89 * 160 + 80];
    assert!((8.0e6..10.0e6).contains(&ground[0]), "{ground:?}");
    assert!((2.5e6..5.0e6).contains(&ground[1]), "{ground:?}");
    assert!((-500.0..9_000.0).contains(&ground[2]), "{ground:?}");
}

#[test]
fn the_exact_picture_needs_no_gpu_and_looks_where_it_is_told_to() {
    let folder = tempfile::tempdir().unwrap();
    let (picture, array) = (folder.path().join("view.png"), folder.path().join("c.npy"));
    let mut command = terrain(["render", "--adapter", "none of this name"]);
    command.arg(dataset()).args(["--camera", CAMERA, "--size", "64x36", "--exaggeration", "15"]);
    command.args(["--reference", "--out"]).arg(&picture).arg("--coordinates").arg(&array);
    assert_success(&command.output().unwrap());
    assert_eq!(image::image_dimensions(&picture).unwrap(), (64, 36));
    let points = read_npy(&array);
    assert!(points[..64].iter().all(|point| point[0].is_nan()), "the top row is sky");
    let ground = points[35 * 64 + 32];
    assert!((8.0e6..10.0e6).contains(&ground[0]), "{ground:?}");
    assert!((-500.0..9_000.0).contains(&ground[2]), "true heights: {ground:?}");
}

/// The triples of a float64 array of shape (height, width, 3).
fn read_npy(path: &Path) -> Vec<[f64; 3]> {
    let bytes = std::fs::read(path).unwrap();
    let header = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let numbers: Vec<f64> = bytes[10 + header..]
        .chunks_exact(8)
        .map(|chunk| f64::from_le_bytes(chunk.try_into().unwrap()))
        .collect();
    numbers.chunks_exact(3).map(|triple| [triple[0], triple[1], triple[2]]).collect()
}

#[test]
fn a_height_above_ground_needs_ground() {
    let mut command = terrain(["render"]);
    command.arg(dataset()).args(["--camera", "x=-9e6,y=0,agl=100", "--out", "x.png"]);
    assert_fails_naming(&command.output().unwrap(), &["x=-9000000", "height="]);
}

#[test]
fn a_flight_makes_a_row_and_a_picture_a_frame() {
    if !has_gpu() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let (table, pictures) = (folder.path().join("frames.csv"), folder.path().join("pictures"));
    let mut command = terrain(["fly"]);
    command.arg(dataset()).arg("--flight").arg(root().join("data/demo/flight.json"));
    command.args(["--headless", "--settle", "--frames-at", "3", "--size", "96x54", "--csv"]);
    let output = command.arg(&table).args(["--json", "--out"]).arg(&pictures).output().unwrap();
    assert_success(&output);
    let summary: serde_json::Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!((&summary["frames"], &summary["frames_with_missing_tiles"]), (&3.into(), &0.into()));

    let text = std::fs::read_to_string(&table).unwrap();
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    for column in [
        "strategy",
        "frame",
        "time_s",
        "frame_ms",
        "cpu_ms",
        "gpu_ms",
        "select_ms",
        "tiles_selected",
        "tiles_new",
        "tiles_missing",
        "disk_bytes",
        "upload_bytes",
        "readback_bytes",
        "region_age_frames",
        "finest_level",
    ] {
        assert!(header.contains(&column), "{header:?} lacks {column}");
    }
    let column = |name: &str| header.iter().position(|found| *found == name).unwrap();
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 3);
    let bytes = rows.iter().map(|row| row[column("upload_dem_bytes")].parse::<u64>().unwrap());
    assert_eq!(summary["upload_dem_bytes"], bytes.sum::<u64>());
    for row in &rows {
        assert_eq!(row.len(), header.len());
        assert_eq!((row[0], row[column("tiles_missing")]), ("rtt-quadtree", "0"));
    }
    let gpu_times = rows.iter().filter(|row| !row[column("gpu_ms")].is_empty()).count();
    assert!(gpu_times == 0 || gpu_times == 3, "every frame has its own time or the GPU tells none");
    let frames: Vec<&str> = rows.iter().map(|row| row[column("frame")]).collect();
    assert_eq!(frames, ["0", "900", "1800"], "60 s at 30 frames a second");
    assert_eq!(std::fs::read_dir(&pictures).unwrap().count(), 3);
}

#[test]
fn a_flight_of_another_place_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let flight = folder.path().join("elsewhere.json");
    let text = std::fs::read_to_string(root().join("data/demo/flight.json")).unwrap();
    std::fs::write(&flight, text.replace("EPSG:3395", "EPSG:32632")).unwrap();
    let mut command = terrain(["fly"]);
    command.arg(dataset()).arg("--flight").arg(&flight).args(["--headless", "--csv", "x.csv"]);
    let words = ["elsewhere.json", "EPSG:32632", "EPSG:3395"];
    assert_fails_naming(&command.output().unwrap(), &words);
}

#[test]
fn what_cannot_be_written_is_named() {
    if !has_gpu() {
        return;
    }
    let output = run([
        "render".as_ref(),
        dataset().as_os_str(),
        "--camera".as_ref(),
        CAMERA.as_ref(),
        "--size".as_ref(),
        "32x18".as_ref(),
        "--out".as_ref(),
        "/nowhere/at/all.png".as_ref(),
    ]);
    assert_fails_naming(&output, &["/nowhere/at/all.png"]);
}
