//! Files that lie or are cut short: an error that names the file, never a panic and never memory for what is not there.

use serde_json::{Value, json};

use super::{Square, glb, read};

fn changed(change: impl FnOnce(&mut Value)) -> String {
    let mut square = Square::new();
    change(&mut square.document);
    square.model().unwrap_err().to_string()
}

#[test]
fn lies_about_sizes_are_errors() {
    let error = changed(|document| document["accessors"][0]["count"] = 4_000_000_000_u64.into());
    assert!(error.contains("made/model.glb") && error.contains("beyond their view"), "{error}");
    let error = changed(|document| {
        document["accessors"][0]["count"] = 4_000_000_000_u64.into();
        document["accessors"][0].as_object_mut().unwrap().remove("bufferView");
        document["accessors"][0]["sparse"] = json!({
            "count": 1,
            "indices": {"bufferView": 2, "componentType": 5123},
            "values": {"bufferView": 0},
        });
    });
    assert!(error.contains("without bytes"), "{error}");
    let error = changed(|document| document["bufferViews"][0]["byteLength"] = u64::MAX.into());
    assert!(error.contains("beyond its buffer"), "{error}");
    let error = changed(|document| document["accessors"][0]["byteOffset"] = u64::MAX.into());
    assert!(error.contains("beyond their view"), "{error}");
    let error = changed(|document| document["buffers"][0]["byteLength"] = 1_000_000.into());
    assert!(error.contains("cut short"), "{error}");
    let mut square = Square::new().with_texture([1, 1], &[9, 9, 9, 255]);
    square.document["accessors"][1]["count"] = 3.into();
    let error = square.model().unwrap_err().to_string();
    assert!(error.contains("3 texture coordinates for 4 positions"), "{error}");
}

#[test]
fn what_does_not_fit_together_is_an_error() {
    let error = changed(|document| document["accessors"][0]["type"] = "VEC2".into());
    assert!(error.contains("vectors of 3"), "{error}");
    let error = changed(|document| document["accessors"][2]["componentType"] = 5126.into());
    assert!(error.contains("indices are due"), "{error}");
    let error = changed(|document| document["meshes"][0]["primitives"][0]["indices"] = 9.into());
    assert!(error.contains("made/model.glb"), "{error}");
    let error = changed(|document| document["accessors"] = json!([]));
    assert!(error.contains("positions is missing"), "{error}");
    let error = changed(|document| document["buffers"][0]["uri"] = "no such.bin".into());
    assert!(error.contains("no such.bin"), "{error}");
    let error = changed(|document| document["scenes"] = json!([{"nodes": []}]));
    assert!(error.contains("no triangles"), "{error}");
    let error = changed(|document| {
        document.as_object_mut().unwrap().remove("scenes");
    });
    assert!(error.contains("no scene"), "{error}");
}

#[test]
fn nodes_that_are_their_own_ancestors_are_met_once() {
    let mut square = Square::new();
    square.document["nodes"] = json!([{"mesh": 0, "children": [1]}, {"children": [0, 1]}]);
    let model = square.model().unwrap();
    assert_eq!(model.triangle_count(), 2);
    assert!(model.notes[0].contains("drawn once"), "{:?}", model.notes);
    let chain = (1..2_000).map(|child| json!({"children": [child]})).chain([json!({"mesh": 0})]);
    square.document["nodes"] = chain.collect();
    assert!(square.model().unwrap_err().reason.contains("one below the other"));
}

/// Cut at any byte and with any byte changed, a file is read or refused.
#[test]
fn damage_anywhere_never_panics() {
    let square = Square::new().with_texture([2, 1], &[255, 0, 0, 255, 0, 0, 255, 128]);
    let file = glb(&square.document, &square.bin);
    assert!(read(&file).is_ok());
    for length in 0..file.len() {
        assert!(read(&file[..length]).is_err(), "cut at {length}");
    }
    let mut read_all_the_same = 0;
    for place in 0..file.len() {
        for change in [0x01, 0x80, 0xff] {
            let mut damaged = file.clone();
            damaged[place] ^= change;
            read_all_the_same += usize::from(read(&damaged).is_ok());
        }
    }
    assert!(read_all_the_same > file.len() / 4, "{read_all_the_same}");
}
