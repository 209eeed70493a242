//! Scene files, and the files that models name.

use std::path::{Path, PathBuf};

use glam::dvec2;
use serde_json::json;

use super::{Square, glb};
use crate::dataset::{
    Crs, HeightEncoding, HeightLayer, HeightRange, HeightRanges, Manifest, Shape,
};
use crate::geodesy::PlateCarree;
use crate::surface::models::{Model, ModelScene, Standing};
use crate::tiling::{LayerLayout, TilingScheme};

/// A folder with a model in it.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let square = Square::new();
    std::fs::write(folder.path().join("square.glb"), glb(&square.document, &square.bin)).unwrap();
    folder
}

fn scene(folder: &Path, text: &str) -> Result<ModelScene, String> {
    let path = folder.join("scene.json");
    std::fs::write(&path, text).unwrap();
    ModelScene::load(&path).map_err(|error| error.to_string())
}

#[test]
fn a_scene_names_models_beside_it_and_reads_each_once() {
    let folder = folder();
    let text = r#"{"crs": "EPSG:32632", "models": [
        {"file": "square.glb", "x": 1.5, "y": 2, "height": 30, "heading": 90, "scale": 2},
        {"file": "square.glb", "x": 5, "y": 6, "snap": true}
    ]}"#;
    let scene = scene(folder.path(), text).unwrap();
    assert_eq!((scene.epsg, scene.models.len(), scene.triangle_count()), (Some(32_632), 1, 4));
    let [first, second] = scene.instances[..] else { panic!("{:?}", scene.instances) };
    assert_eq!((first.place, first.standing), (dvec2(1.5, 2.0), Standing::Height(30.0)));
    assert_eq!((first.heading_deg, first.scale), (90.0, 2.0));
    assert_eq!((second.standing, second.heading_deg, second.scale), (Standing::OnGround, 0.0, 1.0));
    let manifest =
        |epsg, shape| Manifest { crs: Crs { epsg, name: String::new() }, shape, ..made_manifest() };
    for epsg in [Some(32_632), None] {
        let placed = scene.clone().placed_on(&manifest(epsg, Shape::Plane)).unwrap();
        assert_eq!(placed, scene);
    }
    let told = scene.clone().placed_on(&manifest(Some(3_395), Shape::Plane)).unwrap_err();
    assert!(told.contains("EPSG:32632"), "{told}");
    let globe = manifest(Some(PlateCarree::EPSG), Shape::Globe);
    assert!(scene.clone().placed_on(&globe).is_err(), "a globe's places are degrees");
    let in_degrees = ModelScene { epsg: None, ..scene }.placed_on(&globe).unwrap();
    assert_eq!(in_degrees.instances[0].place, PlateCarree::metres_from_degrees(dvec2(1.5, 2.0)));
}

fn made_manifest() -> Manifest {
    let range = HeightRange { min_m: 0.0, max_m: 1.0 };
    let scheme = TilingScheme { origin: dvec2(0.0, 1.0), root_size_m: 1.0 };
    Manifest {
        version: Manifest::VERSION,
        crs: Crs { epsg: None, name: String::new() },
        shape: Shape::Plane,
        scheme,
        data_extent: scheme.root_extent(),
        heights: HeightLayer {
            layout: LayerLayout { tile_size_texels: 128, gutter_texels: 4, level_count: 1 },
            encoding: HeightEncoding::Float,
            step_m: 1.0,
            has_voids: false,
            range,
            ranges: HeightRanges { levels: vec![vec![Some(range)]] },
        },
        colours: None,
        sources: Vec::new(),
        notes: Vec::new(),
    }
}

#[test]
fn mistakes_are_named_with_file_and_entry() {
    let folder = folder();
    let entry = |entry: &str| {
        format!(r#"{{"models": [{{"file": "square.glb", "x": 0, "y": 0, {entry}}}]}}"#)
    };
    for (text, told) in [
        (entry(r#""snap": true, "height": 3"#), "model 1: give either"),
        (entry(r#""heading": 3"#), "model 1: give its \"height\""),
        (entry(r#""snap": true, "scale": 0"#), "model 1: \"scale\" is 0"),
        (entry(r#""snap": true, "scael": 1"#), "unknown field"),
        (
            r#"{"models": [{"file": "none.glb", "x": 0, "y": 0, "snap": true}]}"#.to_owned(),
            "none.glb",
        ),
        (r#"{"crs": "UTM 32", "models": []}"#.to_owned(), "no CRS such as"),
        ("{".to_owned(), "EOF"),
    ] {
        let error = scene(folder.path(), &text).unwrap_err();
        assert!(error.contains("scene.json") && error.contains(told), "{error}");
    }
    assert!(
        ModelScene::load(Path::new("no/such.json"))
            .unwrap_err()
            .to_string()
            .contains("no/such.json")
    );
}

#[test]
fn buffers_and_images_may_lie_in_files_beside_the_model() {
    let folder = folder();
    let square = Square::new().with_texture([1, 1], &[10, 20, 30, 255]);
    let mut document = square.document.clone();
    let png = &square.bin[92..];
    std::fs::write(folder.path().join("a part.bin"), &square.bin[..92]).unwrap();
    std::fs::write(folder.path().join("a part.png"), png).unwrap();
    document["buffers"] = json!([{"byteLength": 92, "uri": "a%20part.bin"}]);
    document["bufferViews"].as_array_mut().unwrap().pop();
    document["images"] = json!([{"uri": "a%20part.png"}]);
    let path = folder.path().join("apart.gltf");
    std::fs::write(&path, document.to_string()).unwrap();
    let model = Model::load(&path).unwrap();
    assert_eq!((model.triangle_count(), &model.images[0].rgba[..]), (2, &[10, 20, 30, 255][..]));
    assert_eq!(model.notes, [""; 0]);
}

/// Models as they are found, where they are there.
#[test]
fn real_models_are_read_whole() {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data/models"));
    for (file, triangles, images) in [
        ("building_H_1k9.glb", 1_885, 1),
        ("block_8bldg_10k.glb", 9_622, 1),
        ("kenney/building-small-a.glb", 400, 1),
    ] {
        let path = folder.join(file);
        if !path.is_file() {
            eprintln!("skipped: {file} is not there");
            continue;
        }
        let model = Model::load(&path).unwrap();
        assert_eq!(model.images.len(), images, "{file}: {:?}", model.notes);
        let found = model.triangle_count();
        assert!(found > triangles * 9 / 10 && found <= triangles + 60, "{file}: {found}");
    }
}
