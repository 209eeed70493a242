//! The glTF file, read back by its definition.

use glam::dvec2;
use serde_json::Value;

use super::super::{GlbPlace, Tin, write_glb};
use crate::tiling::Extent;

#[test]
fn positions_normals_and_texture_coordinates_come_back() {
    let tin = Tin {
        vertices: vec![
            [1_839_100.125, 5_912_000.25, 10.5],
            [1_839_200.0, 5_912_000.25, 10.5],
            [1_839_100.125, 5_912_100.0, 110.25],
        ],
        triangles: vec![[0, 1, 2]],
    };
    let extent =
        Extent::new(dvec2(1_839_000.125, 5_912_000.25), dvec2(1_839_200.125, 5_912_100.25));
    let crs = Some("EPSG:2193".to_owned());
    let place = GlbPlace { crs, metres_per_unit: dvec2(1.0, 1.0), extent };
    let file = write_glb(&tin, &place).unwrap();

    let word = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!((&file[..4], word(4), word(8)), (&b"glTF"[..], 2, file.len()));
    let json_bytes = word(12);
    assert_eq!(
        (&file[16..20], &file[24 + json_bytes..28 + json_bytes]),
        (&b"JSON"[..], &b"BIN\0"[..])
    );
    let json: Value = serde_json::from_slice(&file[20..20 + json_bytes]).unwrap();
    let bin = &file[28 + json_bytes..];
    assert_eq!(json["buffers"][0]["byteLength"], bin.len());
    let floats = |view: usize| -> Vec<f64> {
        let view = &json["bufferViews"][view];
        let start = view["byteOffset"].as_u64().unwrap() as usize;
        let bytes = &bin[start..start + view["byteLength"].as_u64().unwrap() as usize];
        let floats = bytes.chunks_exact(4).map(|part| f32::from_le_bytes(part.try_into().unwrap()));
        floats.map(f64::from).collect()
    };
    let extras = &json["nodes"][0]["extras"];
    assert_eq!(extras["crs"], "EPSG:2193");
    let origin: Vec<f64> =
        extras["origin"].as_array().unwrap().iter().map(|part| part.as_f64().unwrap()).collect();
    for (vertex, local) in tin.vertices.iter().zip(floats(0).chunks_exact(3)) {
        // x east, y up, z south.
        assert!((origin[0] + local[0] - vertex[0]).abs() < 1e-5);
        assert!((origin[1] - local[2] - vertex[1]).abs() < 1e-5);
        assert!((origin[2] + local[1] - vertex[2]).abs() < 1e-5);
    }
    let low = json["accessors"][0]["min"].as_array().unwrap();
    assert_eq!(low[0].as_f64().unwrap(), floats(0)[0]);
    // The ground rises northwards by its own length: the normal leans south by 45 degrees.
    let half = 0.5_f64.sqrt();
    for (got, expected) in floats(1).iter().zip([0.0, half, half].iter().cycle()) {
        assert!((got - expected).abs() < 1e-6, "{got} {expected}");
    }
    let uv = floats(2);
    assert!((uv[0] - 0.5).abs() < 1e-6 && (uv[1] - 1.0).abs() < 1e-6, "{uv:?}");
    assert!((uv[5] - 0.0025).abs() < 1e-6, "{uv:?}");
    let start = json["bufferViews"][3]["byteOffset"].as_u64().unwrap() as usize;
    assert_eq!(bin[start..], [0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]);
}
