//! Triangles from whatever way a file lists them.

use glam::{Vec3, vec2, vec3};
use serde_json::json;

use super::{Square, floats, triangles};

#[test]
fn a_square_stands_upright_and_faces_south() {
    let model = Square::new().model().unwrap();
    assert_eq!((model.triangle_count(), model.single_sided, model.images.len()), (2, 6, 0));
    // The file's x is east, its y up.
    assert_eq!(model.bounds_m, [Vec3::ZERO, vec3(1.0, 0.0, 1.0)]);
    for triangle in triangles(&model) {
        let [a, b, c] = triangle;
        assert_eq!(
            (b - a).cross(c - a).normalize(),
            Vec3::NEG_Y,
            "its front faces the file's +z: south"
        );
    }
    assert!(model.vertices.iter().all(|vertex| (vertex.normal - Vec3::NEG_Y).length() < 1e-6));
    assert_eq!(model.materials[0].colour, [0.5, 0.25, 1.0, 1.0]);
}

#[test]
fn indices_of_every_kind_strips_and_fans_make_the_same_square() {
    let expected = triangles(&Square::new().model().unwrap());
    for (kind, bytes) in [
        (5121, [0_u8, 1, 2, 0, 2, 3].to_vec()),
        (5125, [0_u32, 1, 2, 0, 2, 3].iter().flat_map(|index| index.to_le_bytes()).collect()),
    ] {
        let mut square = Square::new();
        square.document["bufferViews"][2] =
            json!({"buffer": 0, "byteOffset": 80, "byteLength": bytes.len()});
        square.document["accessors"][2]["componentType"] = kind.into();
        square.bin.truncate(80);
        square.bin.extend(bytes);
        square.document["buffers"][0]["byteLength"] = square.bin.len().into();
        assert_eq!(triangles(&square.model().unwrap()), expected);
    }
    // The corners run round the square: a fan without indices.
    let mut fan = Square::new();
    fan.primitive().as_object_mut().unwrap().remove("indices");
    fan.primitive()["mode"] = 6.into();
    assert_eq!(triangles(&fan.model().unwrap()), expected);
    let mut strip = Square::new();
    strip.primitive()["mode"] = 5.into();
    strip.document["accessors"][2]["count"] = 4.into();
    strip.bin[80..88].copy_from_slice(&[1, 0, 2, 0, 0, 0, 3, 0]);
    let strip = strip.model().unwrap();
    assert_eq!(strip.triangle_count(), 2);
    for [a, b, c] in triangles(&strip) {
        assert_eq!((b - a).cross(c - a).normalize(), Vec3::NEG_Y, "every second is turned round");
    }
}

#[test]
fn nodes_move_turn_and_mirror_what_is_below_them() {
    let mut square = Square::new();
    square.document["nodes"] = json!([
        {"translation": [10.0, 20.0, 30.0], "children": [1, 2]},
        {"mesh": 0, "rotation": [0.0, 0.6, 0.0, 0.8], "scale": [2.0, 2.0, 2.0]},
        {"mesh": 0, "scale": [-1.0, 1.0, 1.0]},
    ]);
    let model = square.model().unwrap();
    assert_eq!(model.triangle_count(), 4);
    let corner = |triangle: usize, index: usize| triangles(&model)[triangle][index];
    // The turn about the file's y, of cosine 0.28 and sine 0.96, takes its x towards its -z, which is north.
    let expected = vec3(10.0 + 2.0 * 0.28, -30.0 + 2.0 * 0.96, 20.0);
    assert!((corner(0, 1) - expected).length() < 1e-5, "{}", corner(0, 1));
    for [a, b, c] in triangles(&model).into_iter().skip(2) {
        assert_eq!(
            (b - a).cross(c - a).normalize(),
            Vec3::NEG_Y,
            "mirrored, it faces the same way"
        );
    }
    let mirrored = model.vertices.iter().rev().take(6);
    assert!(mirrored.into_iter().all(|vertex| (vertex.normal - Vec3::NEG_Y).length() < 1e-5));
}

#[test]
fn sparse_and_interleaved_and_normalised_numbers_are_read() {
    let mut square = Square::new();
    // The third corner is replaced by one twice as far.
    let place = square.bin.len();
    square.bin.extend(2_u16.to_le_bytes());
    square.bin.extend([0; 2]);
    square.bin.extend(floats(&[2.0, 2.0, 0.0]));
    let view = |offset: usize, length: usize| json!({"buffer": 0, "byteOffset": offset, "byteLength": length});
    let views = square.document["bufferViews"].as_array_mut().unwrap();
    views.extend([view(place, 2), view(place + 4, 12)]);
    square.document["buffers"][0]["byteLength"] = square.bin.len().into();
    square.document["accessors"][0]["sparse"] = json!({
        "count": 1,
        "indices": {"bufferView": 3, "componentType": 5123},
        "values": {"bufferView": 4},
    });
    assert_eq!(square.model().unwrap().bounds_m[1], vec3(2.0, 0.0, 2.0));

    // Texture coordinates as whole numbers of two bytes, eight bytes apart, begin where the floats did.
    let mut square = Square::new().with_texture([1, 1], &[9, 9, 9, 255]);
    square.document["bufferViews"][1]["byteStride"] = 8.into();
    let accessor = &mut square.document["accessors"][1];
    *accessor = json!({"bufferView": 1, "componentType": 5123, "normalized": true, "count": 4, "type": "VEC2"});
    for (corner, uv) in [[0_u16, 65_535], [65_535; 2], [65_535, 0], [0, 0]].iter().enumerate() {
        let bytes = uv.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<_>>();
        square.bin[48 + 8 * corner..][..4].copy_from_slice(&bytes);
    }
    let model = square.model().unwrap();
    let uvs = model.vertices.iter().map(|vertex| vertex.uv).take(3).collect::<Vec<_>>();
    assert_eq!(uvs, [vec2(0.0, 1.0), vec2(1.0, 1.0), vec2(1.0, 0.0)]);
}

#[test]
fn what_is_no_triangle_is_left_out_and_told() {
    let mut square = Square::new();
    square.bin[80..92].copy_from_slice(&[0, 0, 1, 0, 2, 0, 3, 0, 3, 0, 99, 0]);
    let model = square.model().unwrap();
    assert_eq!(model.triangle_count(), 1);
    assert!(model.notes[0].starts_with("1 triangles without area or place"), "{:?}", model.notes);

    let mut square = Square::new();
    square.bin[36..40].copy_from_slice(&f32::NAN.to_le_bytes());
    assert_eq!(square.model().unwrap().triangle_count(), 1, "the fourth corner is no place");

    let mut points = Square::new();
    points.primitive()["mode"] = 0.into();
    assert!(points.model().unwrap_err().reason.contains("no triangles"));
}
