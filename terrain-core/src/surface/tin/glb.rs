//! A TIN as a binary glTF file (Khronos Group, "glTF 2.0 Specification", 2021).

use glam::{DVec2, DVec3, dvec2, dvec3};
use serde_json::json;

use super::{Tin, TinError};
use crate::tiling::Extent;

/// What a glTF file cannot say by itself: where its ground lies.
#[derive(Clone, Debug, PartialEq)]
pub struct GlbPlace {
    /// The CRS, such as `EPSG:32632`; `None` where it is not known.
    pub crs: Option<String>,
    /// Metres that one unit of the CRS stands for along x and y: 1 for metres; for degrees those at
    /// the origin's latitude.
    pub metres_per_unit: DVec2,
    /// The ground that texture coordinates span, in the CRS: (0, 0) at the north-west, (1, 1) at the
    /// south-east.
    pub extent: Extent,
}

/// Bytes of a glTF file's header and of a chunk's.
const HEADER_BYTES: usize = 12;
const CHUNK_HEADER_BYTES: usize = 8;

/// Writes positions, normals, texture coordinates and indices.
///
/// The file's axes are x east, y up and z south, in metres from an origin that the node's `extras` name
/// in f64, with the CRS and the metres in its unit: east = origin x + x / metres_per_unit x, north =
/// origin y - z / metres_per_unit y, height = origin z + y. The node itself is not moved there, since
/// viewers compute in float32.
///
/// # Errors
/// Where the file would exceed the 4 GiB that glTF can hold.
pub fn write_glb(tin: &Tin, place: &GlbPlace) -> Result<Vec<u8>, TinError> {
    let [min, max] = tin.bounds().map(DVec3::from);
    let origin = if tin.vertices.is_empty() { DVec3::ZERO } else { rounded(0.5 * (min + max)) };
    let scale = place.metres_per_unit.extend(1.0);
    let local: Vec<DVec3> =
        tin.vertices.iter().map(|vertex| (DVec3::from(*vertex) - origin) * scale).collect();
    let mut bin = Vec::new();
    let bounds = push_vectors(&mut bin, local.iter().copied());
    push_vectors(&mut bin, normals(&local, &tin.triangles).into_iter());
    for vertex in &tin.vertices {
        let uv = uv_of(dvec2(vertex[0], vertex[1]), &place.extent);
        bin.extend(uv.as_vec2().to_array().into_iter().flat_map(f32::to_le_bytes));
    }
    for index in tin.triangles.iter().flatten() {
        bin.extend(index.to_le_bytes());
    }
    let json = document(tin, place, origin, bounds, bin.len());
    assemble(json.to_string().into_bytes(), bin)
}

/// Three decimals are enough, in degrees too, for an origin to be near and still easy to read.
fn rounded(place: DVec3) -> DVec3 {
    (place * 1000.0).round() / 1000.0
}

fn uv_of(position: DVec2, extent: &Extent) -> DVec2 {
    let size = extent.size_m();
    let from_corner = dvec2(position.x - extent.min.x, extent.max.y - position.y);
    from_corner / size.max(DVec2::splat(f64::MIN_POSITIVE))
}

/// Appends vectors in the file's axes; returns their bounds as they are stored.
fn push_vectors(bin: &mut Vec<u8>, vectors: impl Iterator<Item = DVec3>) -> [[f32; 3]; 2] {
    let mut bounds = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
    for vector in vectors {
        let stored = dvec3(vector.x, vector.z, -vector.y).as_vec3().to_array();
        for axis in 0..3 {
            bounds[0][axis] = bounds[0][axis].min(stored[axis]);
            bounds[1][axis] = bounds[1][axis].max(stored[axis]);
        }
        bin.extend(stored.into_iter().flat_map(f32::to_le_bytes));
    }
    bounds
}

/// Unit normals of vertices, upwards: the mean of the triangles round each, weighed by their area.
fn normals(local: &[DVec3], triangles: &[[u32; 3]]) -> Vec<DVec3> {
    let mut normals = vec![DVec3::ZERO; local.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|index| local[index as usize]);
        let normal = (b - a).cross(c - a);
        for index in triangle {
            normals[*index as usize] += normal;
        }
    }
    normals.into_iter().map(|normal| normal.try_normalize().unwrap_or(DVec3::Z)).collect()
}

fn document(
    tin: &Tin,
    place: &GlbPlace,
    origin: DVec3,
    bounds: [[f32; 3]; 2],
    bin_bytes: usize,
) -> serde_json::Value {
    const FLOAT: u32 = 5126;
    const UNSIGNED_INT: u32 = 5125;
    const ARRAY_BUFFER: u32 = 34962;
    const ELEMENT_ARRAY_BUFFER: u32 = 34963;
    let (vertices, indices) = (tin.vertices.len(), 3 * tin.triangles.len());
    let view = |offset: usize, bytes: usize, target: u32| json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes, "target": target});
    let Extent { min, max } = place.extent;
    json!({
        "asset": {"version": "2.0", "generator": concat!("terrain ", env!("CARGO_PKG_VERSION"))},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": "TIN", "extras": {
            "crs": place.crs,
            "origin": origin.to_array(),
            "metres_per_unit": place.metres_per_unit.to_array(),
            "extent": [min.x, min.y, max.x, max.y],
        }}],
        "meshes": [{"primitives": [{
            "attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2},
            "indices": 3,
            "material": 0,
        }]}],
        "materials": [{"name": "ground", "pbrMetallicRoughness": {
            "baseColorFactor": [0.7, 0.7, 0.7, 1.0], "metallicFactor": 0.0, "roughnessFactor": 1.0,
        }}],
        "accessors": [
            {"bufferView": 0, "componentType": FLOAT, "count": vertices, "type": "VEC3",
             "min": bounds[0], "max": bounds[1]},
            {"bufferView": 1, "componentType": FLOAT, "count": vertices, "type": "VEC3"},
            {"bufferView": 2, "componentType": FLOAT, "count": vertices, "type": "VEC2"},
            {"bufferView": 3, "componentType": UNSIGNED_INT, "count": indices, "type": "SCALAR"},
        ],
        "bufferViews": [
            view(0, 12 * vertices, ARRAY_BUFFER),
            view(12 * vertices, 12 * vertices, ARRAY_BUFFER),
            view(24 * vertices, 8 * vertices, ARRAY_BUFFER),
            view(32 * vertices, 4 * indices, ELEMENT_ARRAY_BUFFER),
        ],
        "buffers": [{"byteLength": bin_bytes}],
    })
}

fn assemble(mut json: Vec<u8>, mut bin: Vec<u8>) -> Result<Vec<u8>, TinError> {
    json.resize(json.len().next_multiple_of(4), b' ');
    bin.resize(bin.len().next_multiple_of(4), 0);
    let total = HEADER_BYTES + 2 * CHUNK_HEADER_BYTES + json.len() + bin.len();
    let size =
        |bytes: usize| u32::try_from(bytes).map_err(|_| TinError::TooLargeForGlb { bytes: total });
    let mut file = Vec::with_capacity(total);
    file.extend(b"glTF");
    file.extend(2_u32.to_le_bytes());
    file.extend(size(total)?.to_le_bytes());
    for (kind, chunk) in [(b"JSON", json), (b"BIN\0", bin)] {
        file.extend(size(chunk.len())?.to_le_bytes());
        file.extend(kind);
        file.extend(chunk);
    }
    Ok(file)
}
