//! Models made in memory: the usual, the unusual and the damaged; scene files.

mod damaged;
mod files;
mod looks;
mod placed;
mod shapes;

use std::path::Path;

use glam::Vec3;
use serde_json::{Value, json};

use super::{Model, ModelError};

/// A binary glTF file of these chunks.
fn glb(document: &Value, bin: &[u8]) -> Vec<u8> {
    let mut json = document.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut bin = bin.to_vec();
    bin.resize(bin.len().next_multiple_of(4), 0);
    let total = 12 + 8 + json.len() + 8 + bin.len();
    let mut file = b"glTF".to_vec();
    for word in [2, total as u32, json.len() as u32] {
        file.extend(word.to_le_bytes());
    }
    file.extend(b"JSON");
    file.extend(json);
    file.extend((bin.len() as u32).to_le_bytes());
    file.extend(b"BIN\0");
    file.extend(bin);
    file
}

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

/// A document of one node with one mesh of one primitive, to be changed by tests. Its buffer holds the views
/// one after the other: four corners of a unit square in x and y, their texture coordinates, and six indices.
struct Square {
    document: Value,
    bin: Vec<u8>,
}

impl Square {
    fn new() -> Self {
        let corners = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0];
        let uvs = [0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0];
        let mut bin = [floats(&corners), floats(&uvs)].concat();
        bin.extend([0_u16, 1, 2, 0, 2, 3].iter().flat_map(|index| index.to_le_bytes()));
        let view = |offset: usize, length: usize| json!({"buffer": 0, "byteOffset": offset, "byteLength": length});
        let document = json!({
            "asset": {"version": "2.0"},
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{
                "attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0,
            }]}],
            "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.25, 1.0, 1.0]}}],
            "accessors": [
                {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
                 "min": [0.0, 0.0, 0.0], "max": [1.0, 1.0, 0.0]},
                {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
                {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"},
            ],
            "bufferViews": [view(0, 48), view(48, 32), view(80, 12)],
            "buffers": [{"byteLength": bin.len()}],
        });
        Self { document, bin }
    }

    /// The same with a texture in a view of its own: a PNG of these rows.
    fn with_texture(mut self, size: [u32; 2], rgba: &[u8]) -> Self {
        let mut png = std::io::Cursor::new(Vec::new());
        let image = image::RgbaImage::from_raw(size[0], size[1], rgba.to_vec()).unwrap();
        image.write_to(&mut png, image::ImageFormat::Png).unwrap();
        let png = png.into_inner();
        let view = json!({"buffer": 0, "byteOffset": self.bin.len(), "byteLength": png.len()});
        self.bin.extend(png);
        self.document["buffers"][0]["byteLength"] = self.bin.len().into();
        self.document["bufferViews"].as_array_mut().unwrap().push(view);
        self.document["images"] = json!([{"bufferView": 3, "mimeType": "image/png"}]);
        self.document["textures"] = json!([{"source": 0}]);
        let looks = &mut self.document["materials"][0]["pbrMetallicRoughness"];
        looks["baseColorTexture"] = json!({"index": 0});
        self
    }

    fn primitive(&mut self) -> &mut Value {
        &mut self.document["meshes"][0]["primitives"][0]
    }

    fn model(&self) -> Result<Model, ModelError> {
        read(&glb(&self.document, &self.bin))
    }
}

fn read(bytes: &[u8]) -> Result<Model, ModelError> {
    Model::from_bytes(bytes, Path::new("made/model.glb"))
}

/// The corners of the triangles.
fn triangles(model: &Model) -> Vec<[Vec3; 3]> {
    let corner = |index: u32| model.vertices[index as usize].position_m;
    model.indices.as_chunks().0.iter().map(|triangle: &[u32; 3]| triangle.map(corner)).collect()
}
