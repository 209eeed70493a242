//! Materials and images.

use glam::vec2;
use serde_json::json;

use super::{Square, glb, read};
use crate::surface::models::{ModelTexture, WrapMode};

const TWO_TEXELS: [u8; 8] = [255, 0, 0, 255, 0, 0, 255, 128];

#[test]
fn a_texture_is_decoded_and_its_wrap_modes_are_kept() {
    let mut square = Square::new().with_texture([2, 1], &TWO_TEXELS);
    square.document["samplers"] = json!([{"wrapS": 33648, "wrapT": 33071}]);
    square.document["textures"][0]["sampler"] = 0.into();
    square.document["materials"][0]["doubleSided"] = true.into();
    square.document["materials"][0]["alphaMode"] = "MASK".into();
    square.document["materials"][0]["alphaCutoff"] = 0.3.into();
    let model = square.model().unwrap();
    assert_eq!((model.single_sided, model.indices.len()), (0, 6));
    let material = &model.materials[0];
    let wrap = [WrapMode::Mirror, WrapMode::Clamp];
    assert_eq!(material.texture, Some(ModelTexture { image: 0, wrap }));
    assert_eq!(material.alpha_cutoff, Some(0.3));
    assert_eq!((model.images[0].size_texels, &model.images[0].rgba[..]), ([2, 1], &TWO_TEXELS[..]));
}

#[test]
fn texture_coordinates_are_moved_turned_and_scaled() {
    let mut square = Square::new().with_texture([2, 1], &TWO_TEXELS);
    let transform = json!({"offset": [0.25, 0.5], "rotation": std::f32::consts::FRAC_PI_2, "scale": [2.0, 3.0]});
    let looks = &mut square.document["materials"][0]["pbrMetallicRoughness"];
    looks["baseColorTexture"]["extensions"] = json!({"KHR_texture_transform": transform});
    let model = square.model().unwrap();
    // (1, 0) is scaled to (2, 0), turned to (0, -2) and moved; (0, 1) to (0, 3), (3, 0).
    for (uv, expected) in [([1.0, 0.0], vec2(0.25, -1.5)), ([0.0, 1.0], vec2(3.25, 0.5))] {
        let corner = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0]].iter().position(|known| *known == uv);
        let found = model.vertices[corner.unwrap()].uv;
        assert!((found - expected).length() < 1e-6, "{uv:?} became {found}");
    }
}

#[test]
fn what_cannot_be_textured_shows_its_colour_and_is_told() {
    let mut without_coordinates = Square::new().with_texture([2, 1], &TWO_TEXELS);
    without_coordinates.primitive()["attributes"].as_object_mut().unwrap().remove("TEXCOORD_0");
    let model = without_coordinates.model().unwrap();
    assert_eq!((model.materials[0].texture, model.images.len()), (None, 0));
    assert!(model.notes[0].contains("no texture coordinates"), "{:?}", model.notes);

    for (image, told) in [
        (json!({"uri": "missing.png"}), "image missing.png"),
        (json!({"uri": "https://example.org/a.png"}), "only files beside the model"),
        (json!({"uri": "data:image/png;base64,AAAA"}), "image 0"),
        (json!({"bufferView": 0}), "neither PNG nor JPEG"),
        (json!({"name": "nothing"}), "image nothing"),
    ] {
        let mut square = Square::new().with_texture([2, 1], &TWO_TEXELS);
        square.document["images"] = json!([image]);
        let model = square.model().unwrap();
        assert_eq!((model.triangle_count(), model.materials[0].texture), (2, None));
        let note = &model.notes[0];
        assert!(note.contains(told) && note.contains("the material's colour"), "{note}");
    }
    // A texture whose image only an extension knows.
    let mut square = Square::new().with_texture([2, 1], &TWO_TEXELS);
    square.document["textures"] = json!([{"extensions": {"EXT_texture_webp": {"source": 0}}}]);
    assert_eq!(square.model().unwrap().materials[0].texture, None);
}

#[test]
fn several_primitives_share_their_materials_and_blending_is_told() {
    let mut square = Square::new().with_texture([2, 1], &TWO_TEXELS);
    let primitive = square.primitive().clone();
    let mut bare = primitive.clone();
    bare.as_object_mut().unwrap().remove("material");
    square.document["meshes"][0]["primitives"] = json!([primitive, primitive, bare]);
    square.document["materials"][0]["alphaMode"] = "BLEND".into();
    let model = square.model().unwrap();
    assert_eq!((model.triangle_count(), model.materials.len(), model.images.len()), (6, 2, 1));
    assert_eq!(model.materials[1].colour, [1.0; 4], "glTF's own material is white");
    assert_eq!(model.materials[0].alpha_cutoff, Some(0.5));
    assert!(model.notes[0].contains("opaque"), "{:?}", model.notes);
}

#[test]
fn an_extension_that_must_be_known_and_is_not_is_an_error() {
    let mut square = Square::new();
    square.document["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    let error = read(&glb(&square.document, &square.bin)).unwrap_err().to_string();
    assert!(error.contains("made/model.glb") && error.contains("draco"), "{error}");
}
