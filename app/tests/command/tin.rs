//! `terrain tin`, and points in `terrain prepare`.

use std::path::Path;

use serde_json::Value;
use tempfile::TempDir;

use crate::harness::{assert_fails_naming, assert_success, root, run, stderr, stdout};

fn text(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}

#[test]
fn a_raster_becomes_a_file_of_triangles() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("demo.glb");
    let dem = root().join("data/demo/dem.tif");
    let arguments = ["tin", &text(&dem), "--max-error", "400", "--out", &text(&out), "--json"];
    let output = run(arguments);
    assert_success(&output);
    assert_eq!(stderr(&output), "");
    let told: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert!(told["triangles"].as_u64().unwrap() > 100, "{told}");
    assert!(told["largest_error_m"].as_f64().unwrap() <= 400.001, "{told}");
    let file = std::fs::read(&out).unwrap();
    assert_eq!((&file[..4], told["bytes"].as_u64()), (&b"glTF"[..], Some(file.len() as u64)));
    let printed = run(["tin", &text(&dem), "--max-error", "400", "--out", &text(&out)]);
    assert!(stdout(&printed).contains(&format!("triangles  {}\n", told["triangles"])));
}

#[test]
fn what_makes_no_tin_is_one_line() {
    let folder = TempDir::new().unwrap();
    let out = text(&folder.path().join("out.glb"));
    let dem = text(&root().join("data/demo/dem.tif"));
    let points = folder.path().join("line.xyz");
    std::fs::write(&points, "0 0 1\n1 1 2\n2 2 3\n").unwrap();
    let lines = folder.path().join("lines.geojson");
    let line = r#"{"type": "LineString", "coordinates": [[8.0, -61.0], [8.1, -61.0]]}"#;
    std::fs::write(&lines, line).unwrap();
    let points = text(&points);
    assert_fails_naming(&run(["tin", &dem, "--out", &out]), &["--max-error"]);
    assert_fails_naming(&run(["tin", &dem, "--max-error", "-3", "--out", &out]), &["-3 m"]);
    assert_fails_naming(&run(["tin", &points, "--out", &out]), &["line.xyz", "one line"]);
    let lines = text(&lines);
    let with_lines = ["tin", &dem, "--max-error", "400", "--breaklines", &lines, "--out", &out];
    assert_fails_naming(&run(with_lines), &["lines.geojson", "meets the ground"]);
    assert!(!Path::new(&out).exists());
}

#[test]
fn points_become_a_dataset() {
    let folder = TempDir::new().unwrap();
    let points = folder.path().join("points.csv");
    let lines = (0..400_u32).map(|index| format!("{},{},{}\n", index % 20, index / 20, index % 7));
    std::fs::write(&points, format!("x,y,z\n{}", lines.collect::<String>())).unwrap();
    let out = text(&folder.path().join("dataset"));
    let points = text(&points);
    let output = run([
        "prepare",
        "--dem",
        &points,
        "--crs",
        "EPSG:32632",
        "--point-spacing",
        "0.5",
        "--out",
        &out,
    ]);
    assert_success(&output);
    assert!(stdout(&output).contains("400 points' natural neighbours in cells of 0.5 m"));
}
