//! Models on the ground, and other ground.

use std::path::Path;

use crate::harness::{
    assert_fails_naming, assert_success, dataset, has_gpu, root, run, stderr, stdout, terrain,
};

/// Over northern India, looking north.
const CAMERA: &str = "x=9000000,y=2500000,height=60000,heading=0,pitch=-20,fov=50";

/// A scene of the village's tower, 60 km high, 100 km before the camera.
fn write_scene(folder: &Path, more: &str) -> std::path::PathBuf {
    let tower = root().join("data/village/tower.gltf").canonicalize().unwrap();
    let tower = serde_json::json!(tower);
    let path = folder.join("scene.json");
    let entry = format!(r#""file": {tower}, "x": 9000000, "y": 2600000, "scale": 2000, {more}"#);
    std::fs::write(&path, format!(r#"{{"crs": "EPSG:3395", "models": [{{{entry}}}]}}"#)).unwrap();
    path
}

/// Draws the camera's view; returns the picture and the record of what it took.
fn render(folder: &Path, options: &[&std::ffi::OsStr]) -> (image::RgbaImage, serde_json::Value) {
    let picture = folder.join("view.png");
    let mut command = terrain(["render"]);
    command.arg(dataset()).args(["--camera", CAMERA, "--size", "160x90", "--json", "--out"]);
    let output = command.arg(&picture).args(options).output().unwrap();
    assert_success(&output);
    assert_eq!(stderr(&output), "");
    let record = serde_json::from_str(&stdout(&output)).unwrap();
    (image::open(&picture).unwrap().into_rgba8(), record)
}

#[test]
fn a_scene_is_drawn_on_the_ground() {
    if !has_gpu() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let scene = write_scene(folder.path(), r#""snap": true"#);
    let (bare, before) = render(folder.path(), &[]);
    let (built, after) = render(folder.path(), &["--models".as_ref(), scene.as_os_str()]);
    let triangles = |record: &serde_json::Value| record["triangles_drawn"].as_u64().unwrap();
    // Four walls and four sides of a roof.
    assert_eq!(triangles(&after), triangles(&before) + 12);
    let differing = bare.enumerate_pixels().zip(built.pixels());
    let differing = differing.filter(|((_, _, before), after)| before != after);
    let columns = differing.map(|((column, _, _), _)| column).collect::<Vec<_>>();
    let (first, last) = (columns.iter().min().unwrap(), columns.iter().max().unwrap());
    assert!(*first > 60 && *last < 100, "{first} to {last}: a tower in the middle");
    assert!(columns.len() > 300, "{}", columns.len());
}

#[test]
fn mistakes_are_named_with_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let with = |option: &str, path: &Path| {
        let out = folder.path().join("never.png");
        let mut command = terrain(["render"]);
        command.arg(dataset()).args(["--camera", CAMERA, option]).arg(path).arg("--out").arg(out);
        command.output().unwrap()
    };
    let scene = write_scene(folder.path(), r#""snap": true, "height": 1"#);
    assert_fails_naming(&with("--models", &scene), &["scene.json", "model 1", "not both"]);
    let elsewhere = folder.path().join("elsewhere.json");
    std::fs::write(&elsewhere, r#"{"crs": "EPSG:32632", "models": []}"#).unwrap();
    assert_fails_naming(&with("--models", &elsewhere), &["elsewhere.json", "EPSG:3395"]);
    let tower = root().join("data/village/tower.gltf");
    assert_fails_naming(&with("--tin", &tower), &["tower.gltf", "where it lies"]);
    // Triangles of the demo's own heights are in degrees.
    let tin = folder.path().join("degrees.glb");
    let dem = root().join("data/demo/dem.tif");
    let made = ["tin".as_ref(), dem.as_os_str(), "--max-error".as_ref(), "2000".as_ref()];
    assert_success(&terrain(made).arg("--out").arg(&tin).output().unwrap());
    assert_fails_naming(&with("--tin", &tin), &["degrees.glb", "not in metres"]);
    let usage = run(["render", "somewhere", "--reference", "--models", "a.json", "--out", "b.png"]);
    assert_eq!(usage.status.code(), Some(2), "the exact picture knows no models");
}
