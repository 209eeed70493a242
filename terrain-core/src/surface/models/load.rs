//! A glTF file as a [`Model`].

use std::path::Path;

use glam::{DMat4, Vec3};
use gltf::mesh::Semantic;
use gltf::{Document, Gltf, Node};

use super::accessors::Buffers;
use super::error::ModelError;
use super::materials::{Coordinates, Materials};
use super::model::Model;
use super::primitives::{Placing, has_set, triangles};
use super::resources;

/// Most bytes of a model's own file.
const MOST_BYTES: u64 = 1 << 31;
/// Most vertices of a model.
const MOST_VERTICES: usize = 1 << 24;
/// Most nodes above one another.
const MOST_DEPTH: usize = 256;

impl Model {
    /// Reads a .glb or .gltf file with the buffers and images it names.
    ///
    /// What of a model cannot be drawn is left out and told in [`Model::notes`]: textures that are missing,
    /// triangles without area or with places that are no numbers, points and lines.
    ///
    /// # Errors
    /// [`ModelError`] where the file is no glTF 2.0, needs an extension that is not known, is cut short, or has
    /// no triangles.
    pub fn load(path: &Path) -> Result<Self, ModelError> {
        let failed = |error: std::io::Error| ModelError::new(path, error.to_string());
        let size = std::fs::metadata(path).map_err(failed)?.len();
        if size > MOST_BYTES {
            return Err(ModelError::new(path, format!("{size} bytes are too many for a model")));
        }
        Self::from_bytes(&std::fs::read(path).map_err(failed)?, path)
    }

    /// The same from a file's bytes; the files it names are looked for beside `path`.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub fn from_bytes(bytes: &[u8], path: &Path) -> Result<Self, ModelError> {
        read(bytes, path).map_err(|reason| ModelError::new(path, reason))
    }
}

fn read(bytes: &[u8], path: &Path) -> Result<Model, String> {
    check_length(bytes)?;
    let failed = |error: gltf::Error| error.to_string();
    let Gltf { document, blob } = Gltf::from_slice_without_validation(bytes).map_err(failed)?;
    let json = document.into_json();
    check_positions(&json)?;
    let document = Document::from_json(json).map_err(failed)?;
    let buffers = resources::buffers(&document, blob, path);
    let decode = |index| resources::image(&document, index, &buffers, path);
    let mut reader = Reader {
        buffers: &buffers,
        materials: Materials::new(decode),
        model: Model::default(),
        double_sided: Vec::new(),
        visited: vec![false; document.nodes().count()],
        dropped: 0,
    };
    let scene = document.default_scene().or_else(|| document.scenes().next());
    let Some(scene) = scene else { return Err("there is no scene in it".to_owned()) };
    for node in scene.nodes() {
        reader.add_node(&node, DMat4::IDENTITY, 0)?;
    }
    reader.finish()
}

/// A binary file tells its own length; the decoder relies on it being no less than that of its head.
fn check_length(bytes: &[u8]) -> Result<(), String> {
    if !bytes.starts_with(b"glTF") {
        return Ok(());
    }
    let stated = bytes.get(8..12).and_then(|word| word.first_chunk().copied());
    match stated.map(u32::from_le_bytes) {
        Some(stated) if stated >= 12 && stated as usize <= bytes.len() => Ok(()),
        _ => Err(format!("the file is cut short at {} bytes", bytes.len())),
    }
}

/// Validation looks the accessors of positions up before it has checked that they are there.
fn check_positions(json: &gltf::json::Root) -> Result<(), String> {
    let positions = gltf::json::validation::Checked::Valid(Semantic::Positions);
    let mut primitives = json.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let is_there = |primitive: &gltf::json::mesh::Primitive| {
        let accessor = primitive.attributes.get(&positions);
        accessor.is_none_or(|accessor| accessor.value() < json.accessors.len())
    };
    match primitives.all(is_there) {
        true => Ok(()),
        false => Err("the accessor of a mesh's positions is missing".to_owned()),
    }
}

struct Reader<'a> {
    buffers: &'a Buffers,
    materials: Materials<'a>,
    model: Model,
    /// Indices of triangles seen from both sides.
    double_sided: Vec<u32>,
    visited: Vec<bool>,
    dropped: usize,
}

impl Reader<'_> {
    /// Adds a node and its children. Nodes that are their own ancestors, which glTF forbids, are met once.
    fn add_node(
        &mut self,
        node: &Node<'_>,
        file_from_parent: DMat4,
        depth: usize,
    ) -> Result<(), String> {
        if depth > MOST_DEPTH {
            return Err(format!("more than {MOST_DEPTH} nodes lie one below the other"));
        }
        match self.visited.get_mut(node.index()) {
            Some(visited) if !*visited => *visited = true,
            _ => {
                self.note("a node is the child of several: drawn once");
                return Ok(());
            }
        }
        let columns = node.transform().matrix().map(|column| column.map(f64::from));
        let file_from_node = file_from_parent * DMat4::from_cols_array_2d(&columns);
        if let Some(mesh) = node.mesh() {
            let extras = || node.extras().as_ref().map(|extras| extras.get().to_owned());
            self.model.extras = self.model.extras.take().or_else(extras);
            let placing = Placing::new(file_from_node);
            for primitive in mesh.primitives() {
                self.add_primitive(&primitive, &placing).map_err(|reason| {
                    format!("mesh {}: {reason}", mesh.name().unwrap_or("without a name"))
                })?;
            }
        }
        if node.skin().is_some() {
            self.note("a skin is drawn at rest");
        }
        for child in node.children() {
            self.add_node(&child, file_from_node, depth + 1)?;
        }
        Ok(())
    }

    fn add_primitive(
        &mut self,
        primitive: &gltf::Primitive<'_>,
        placing: &Placing,
    ) -> Result<(), String> {
        let material = primitive.material();
        let coordinates = Coordinates::of(&material);
        let has_coordinates = has_set(primitive, coordinates.as_ref());
        if coordinates.is_some() && !has_coordinates {
            self.note("a textured surface has no texture coordinates: drawn in its colour");
        }
        let place = self.materials.place(&material, has_coordinates);
        let made = triangles(primitive, self.buffers, placing, (place, coordinates.as_ref()))?;
        let Some(made) = made else {
            self.note("points and lines are not drawn");
            return Ok(());
        };
        let first = self.model.vertices.len();
        if first + made.vertices.len() > MOST_VERTICES {
            return Err(format!("more than {MOST_VERTICES} vertices"));
        }
        self.dropped += made.dropped;
        self.model.vertices.extend(made.vertices);
        let indices = made.indices.into_iter().map(|index| first as u32 + index);
        match material.double_sided() {
            true => self.double_sided.extend(indices),
            false => self.model.indices.extend(indices),
        }
        Ok(())
    }

    fn note(&mut self, note: &str) {
        if !self.model.notes.iter().any(|known| known == note) {
            self.model.notes.push(note.to_owned());
        }
    }

    fn finish(mut self) -> Result<Model, String> {
        if self.dropped > 0 {
            let note = format!("{} triangles without area or place are left out", self.dropped);
            self.note(&note);
        }
        let Self { materials, mut model, double_sided, .. } = self;
        model.single_sided = model.indices.len() as u32;
        model.indices.extend(double_sided);
        if model.indices.is_empty() {
            return Err("no triangles in it".to_owned());
        }
        let positions = || model.vertices.iter().map(|vertex| vertex.position_m);
        let (low, high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        model.bounds_m = [positions().fold(low, Vec3::min), positions().fold(high, Vec3::max)];
        model.notes.extend(materials.notes);
        model.materials = materials.list;
        model.images = materials.images;
        Ok(model)
    }
}
