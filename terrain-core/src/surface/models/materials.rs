//! How surfaces look, as far as it is drawn: base colour and its texture, cut-outs, both sides.

use std::collections::BTreeMap;

use glam::{Mat2, Vec2};
use gltf::Material;
use gltf::material::AlphaMode;
use gltf::texture::WrappingMode;

use super::model::{ModelImage, ModelMaterial, ModelTexture, WrapMode};

/// What is covered less than this of a material that lets light through is left out.
const BLENDED_CUTOFF: f32 = 0.5;

/// The materials and images that triangles use, in the order they are first used.
pub(super) struct Materials<'a> {
    pub list: Vec<ModelMaterial>,
    pub images: Vec<ModelImage>,
    pub notes: Vec<String>,
    decode: Box<dyn Fn(usize) -> Result<ModelImage, String> + 'a>,
    /// The place of a file's material in the list, with texture coordinates and without.
    known: BTreeMap<(Option<usize>, bool), u32>,
    /// The place of a file's image in the list; `None` where it cannot be had.
    known_images: BTreeMap<usize, Option<usize>>,
}

/// Where a material's texture coordinates come from.
#[derive(Clone, Copy)]
pub(super) struct Coordinates {
    /// The set of the mesh.
    pub set: u32,
    offset: Vec2,
    /// Applied before the offset.
    matrix: Mat2,
}

impl Coordinates {
    /// Those of a material; `None` where it has no texture.
    ///
    /// The extension KHR_texture_transform scales, then turns, then moves: counter-clockwise as the image is seen,
    /// whose v runs down.
    pub fn of(material: &Material<'_>) -> Option<Self> {
        let info = material.pbr_metallic_roughness().base_color_texture()?;
        let mut coordinates =
            Self { set: info.tex_coord(), offset: Vec2::ZERO, matrix: Mat2::IDENTITY };
        if let Some(transform) = info.texture_transform() {
            let scale = Mat2::from_diagonal(transform.scale().into());
            coordinates.matrix = Mat2::from_angle(-transform.rotation()) * scale;
            coordinates.offset = transform.offset().into();
            coordinates.set = transform.tex_coord().unwrap_or(coordinates.set);
        }
        Some(coordinates)
    }

    /// The coordinates in the image.
    pub fn apply(&self, uv: [f32; 2]) -> Vec2 {
        self.matrix * Vec2::from(uv) + self.offset
    }
}

impl<'a> Materials<'a> {
    /// None yet. `decode` gives the file's images by their numbers.
    pub fn new(decode: impl Fn(usize) -> Result<ModelImage, String> + 'a) -> Self {
        Self {
            list: Vec::new(),
            images: Vec::new(),
            notes: Vec::new(),
            decode: Box::new(decode),
            known: BTreeMap::new(),
            known_images: BTreeMap::new(),
        }
    }

    /// The place of the material in the list. Without texture coordinates its texture is left out.
    pub fn place(&mut self, material: &Material<'_>, has_coordinates: bool) -> u32 {
        let key = (material.index(), has_coordinates);
        if let Some(&place) = self.known.get(&key) {
            return place;
        }
        let place = self.list.len() as u32;
        let looks = self.looks(material, has_coordinates);
        self.list.push(looks);
        self.known.insert(key, place);
        place
    }

    fn looks(&mut self, material: &Material<'_>, has_coordinates: bool) -> ModelMaterial {
        let pbr = material.pbr_metallic_roughness();
        let unit = |value: f32| if value.is_finite() { value.clamp(0.0, 1.0) } else { 1.0 };
        let mut colour = pbr.base_color_factor().map(unit);
        let alpha_cutoff = match material.alpha_mode() {
            AlphaMode::Opaque => None,
            AlphaMode::Mask => Some(unit(material.alpha_cutoff().unwrap_or(0.5))),
            AlphaMode::Blend => {
                // Panes are drawn opaque, leaves cut out: nothing is seen through.
                colour[3] = 1.0;
                self.note("what lets light through is drawn opaque, or cut out by its texture");
                Some(BLENDED_CUTOFF)
            }
        };
        let texture = pbr.base_color_texture().filter(|_| has_coordinates);
        ModelMaterial {
            colour,
            texture: texture.and_then(|info| self.texture(&info.texture())),
            alpha_cutoff,
            is_double_sided: material.double_sided(),
        }
    }

    fn texture(&mut self, texture: &gltf::Texture<'_>) -> Option<ModelTexture> {
        let Some(source) = texture.source() else {
            self.note("a texture has no PNG or JPEG image: drawn in the material's colour");
            return None;
        };
        let wrap = |mode| match mode {
            WrappingMode::Repeat => WrapMode::Repeat,
            WrappingMode::MirroredRepeat => WrapMode::Mirror,
            WrappingMode::ClampToEdge => WrapMode::Clamp,
        };
        let sampler = texture.sampler();
        let wrap = [wrap(sampler.wrap_s()), wrap(sampler.wrap_t())];
        self.image(source.index()).map(|image| ModelTexture { image, wrap })
    }

    fn image(&mut self, index: usize) -> Option<usize> {
        if let Some(&known) = self.known_images.get(&index) {
            return known;
        }
        let place = match (self.decode)(index) {
            Ok(image) => {
                self.images.push(image);
                Some(self.images.len() - 1)
            }
            Err(reason) => {
                self.notes.push(format!("{reason}: drawn in the material's colour"));
                None
            }
        };
        self.known_images.insert(index, place);
        place
    }

    fn note(&mut self, note: &str) {
        if !self.notes.iter().any(|known| known == note) {
            self.notes.push(note.to_owned());
        }
    }
}
