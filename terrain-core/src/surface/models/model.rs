use std::sync::Arc;

use glam::{Vec2, Vec3};

/// A vertex of a model, as the GPU reads it: nine words, without gaps.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct ModelVertex {
    /// Metres east, north and up of the model's origin, the model heading north.
    pub position_m: Vec3,
    /// Unit length, in the same axes.
    pub normal: Vec3,
    /// Texture coordinates, (0, 0) at the image's top left corner, (1, 1) at its bottom right one; any values, which
    /// the texture's [`WrapMode`]s bring back.
    pub uv: Vec2,
    /// Index among the model's materials.
    pub material: u32,
}

/// A model: all triangles of all nodes of a file's scene in one list, in the model's own axes.
///
/// glTF's +x is east, its +y up and its -z north: what faces +z in the file faces south at heading 0.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Model {
    /// Vertices; each belongs to a triangle.
    pub vertices: Vec<ModelVertex>,
    /// Three a triangle, counter-clockwise as seen from its front: first those whose back is not drawn, from
    /// [`Self::single_sided`] on those seen from both sides.
    pub indices: Vec<u32>,
    /// How many of the indices belong to triangles whose back is not drawn.
    pub single_sided: u32,
    /// Materials; at least one.
    pub materials: Vec<ModelMaterial>,
    /// Decoded images that materials use.
    pub images: Vec<ModelImage>,
    /// Smallest and largest coordinates of all vertices, metres.
    pub bounds_m: [Vec3; 2],
    /// What the first of its nodes with a mesh says besides, as JSON.
    pub extras: Option<String>,
    /// What a reader should know: textures missing, triangles left out, features not drawn.
    pub notes: Vec<String>,
}

impl Model {
    /// Number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.indices.len() / 3
    }
}

/// How a surface of a model looks.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelMaterial {
    /// Factor on the texture's colour, or the colour where there is no texture: linear red, green and blue, and
    /// coverage.
    pub colour: [f32; 4],
    /// The image on it.
    pub texture: Option<ModelTexture>,
    /// What is covered less than this is left out; `None` where all shows. Within 0..=1.
    pub alpha_cutoff: Option<f32>,
    /// Whether its back is seen as well.
    pub is_double_sided: bool,
}

impl Default for ModelMaterial {
    fn default() -> Self {
        Self { colour: [1.0; 4], texture: None, alpha_cutoff: None, is_double_sided: false }
    }
}

/// Which image a material shows, and how it goes on beyond its borders.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ModelTexture {
    /// Index among the model's images.
    pub image: usize,
    /// Along u and v.
    pub wrap: [WrapMode; 2],
}

/// How an image goes on beyond its borders.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum WrapMode {
    /// Again and again.
    #[default]
    Repeat,
    /// Again and again, every second time mirrored.
    Mirror,
    /// With the texel at the border.
    Clamp,
}

impl WrapMode {
    /// The number the shader knows the mode by.
    pub(crate) fn code(self) -> u32 {
        self as u32
    }

    /// The texel of an image `size` texels long that shows at `index`, which may be any.
    pub(super) fn texel(self, index: i64, size: u32) -> u32 {
        let length = i64::from(size.max(1));
        let texel = match self {
            Self::Repeat => index.rem_euclid(length),
            Self::Clamp => index.clamp(0, length - 1),
            Self::Mirror => {
                let turned = index.rem_euclid(2 * length);
                turned.min(2 * length - 1 - turned)
            }
        };
        texel as u32
    }
}

/// A decoded image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ModelImage {
    /// Width and height in texels, both at least 1.
    pub size_texels: [u32; 2],
    /// Row by row from the top left: sRGB colour and linear coverage. Shared, since packing keeps it as well.
    pub rgba: Arc<[u8]>,
}
