//! Triangles from a file's primitives: whatever way they are listed, in the model's axes, without those that are none.

use glam::{DMat3, DMat4, DVec3, Vec2, Vec3, dvec3};
use gltf::Primitive;
use gltf::mesh::{Mode, Semantic};

use super::accessors::Buffers;
use super::materials::Coordinates;
use super::model::ModelVertex;

/// The triangles of a primitive.
pub(super) struct Triangles {
    pub vertices: Vec<ModelVertex>,
    pub indices: Vec<u32>,
    /// Triangles left out: without area, with a place that is no number, with vertices that are not there.
    pub dropped: usize,
}

/// How a node's own axes lie in the model's.
#[derive(Clone, Copy)]
pub(super) struct Placing {
    model_from_node: DMat4,
    /// Of normals; not of unit length.
    normals: DMat3,
    is_mirrored: bool,
}

/// The model's axes (x east, y north, z up) from the file's (x east, y up, z south).
fn axes() -> DMat4 {
    DMat4::from_cols(
        DVec3::X.extend(0.0),
        DVec3::Z.extend(0.0),
        DVec3::NEG_Y.extend(0.0),
        DVec3::ZERO.extend(1.0),
    )
}

impl Placing {
    /// Of a node at this place in the file's axes.
    pub fn new(file_from_node: DMat4) -> Self {
        let model_from_node = axes() * file_from_node;
        let linear = DMat3::from_mat4(model_from_node);
        // The matrix of cofactors, which is there even where there is no inverse.
        let [x, y, z] = [linear.x_axis, linear.y_axis, linear.z_axis];
        let is_mirrored = linear.determinant() < 0.0;
        let sign = if is_mirrored { -1.0 } else { 1.0 };
        let normals = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * sign;
        Self { model_from_node, normals, is_mirrored }
    }

    fn position_m(&self, [x, y, z]: [f32; 3]) -> Vec3 {
        let place = dvec3(f64::from(x), f64::from(y), f64::from(z));
        self.model_from_node.transform_point3(place).as_vec3()
    }

    fn normal(&self, [x, y, z]: [f32; 3]) -> Vec3 {
        let normal = self.normals * dvec3(f64::from(x), f64::from(y), f64::from(z));
        normal.try_normalize().unwrap_or(DVec3::Z).as_vec3()
    }
}

/// What a primitive's vertices are made of.
struct Attributes {
    positions_m: Vec<Vec3>,
    normals: Option<Vec<Vec3>>,
    uvs: Option<Vec<Vec2>>,
}

/// Whether the primitive has the texture coordinates.
pub(super) fn has_set(primitive: &Primitive<'_>, coordinates: Option<&Coordinates>) -> bool {
    coordinates
        .is_some_and(|coordinates| primitive.get(&Semantic::TexCoords(coordinates.set)).is_some())
}

/// The triangles of a primitive whose vertices get this material; `None` for points and lines.
///
/// Without normals each triangle is flat, as glTF has it.
///
/// # Errors
/// In words, where its numbers are not there.
pub(super) fn triangles(
    primitive: &Primitive<'_>,
    buffers: &Buffers,
    placing: &Placing,
    (material, coordinates): (u32, Option<&Coordinates>),
) -> Result<Option<Triangles>, String> {
    if matches!(primitive.mode(), Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
        return Ok(None);
    }
    let attributes = attributes(primitive, buffers, placing, coordinates)?;
    let count = attributes.positions_m.len();
    let corners = match primitive.indices() {
        Some(accessor) => buffers.indices(&accessor)?,
        None => (0..count as u32).collect(),
    };
    let list = listed(primitive.mode(), &corners);
    let mut made = Triangles { vertices: Vec::new(), indices: Vec::new(), dropped: 0 };
    let mut places = vec![u32::MAX; count];
    for mut triangle in list {
        let Some(face) = face_normal(&attributes.positions_m, triangle) else {
            made.dropped += 1;
            continue;
        };
        if placing.is_mirrored {
            triangle.swap(1, 2);
        }
        let face = if placing.is_mirrored { -face } else { face };
        for corner in triangle {
            made.push(&attributes, (corner, face, material), &mut places);
        }
    }
    Ok(Some(made))
}

impl Triangles {
    /// Adds a corner of a triangle: a vertex of its own where the triangle is flat.
    fn push(
        &mut self,
        attributes: &Attributes,
        (corner, face, material): (u32, Vec3, u32),
        places: &mut [u32],
    ) {
        let index = corner as usize;
        let place = self.vertices.len() as u32;
        if attributes.normals.is_some() && places[index] != u32::MAX {
            self.indices.push(places[index]);
            return;
        }
        places[index] = place;
        let normal = attributes.normals.as_ref().map_or(face, |normals| normals[index]);
        let uv = attributes.uvs.as_ref().map_or(Vec2::ZERO, |uvs| uvs[index]);
        let position_m = attributes.positions_m[index];
        self.vertices.push(ModelVertex { position_m, normal, uv, material });
        self.indices.push(place);
    }
}

fn attributes(
    primitive: &Primitive<'_>,
    buffers: &Buffers,
    placing: &Placing,
    coordinates: Option<&Coordinates>,
) -> Result<Attributes, String> {
    let positions = primitive.get(&Semantic::Positions).ok_or("a primitive has no positions")?;
    let positions =
        buffers.vectors::<3>(&positions).map_err(|reason| format!("positions: {reason}"))?;
    let count = positions.len();
    let matching = |found: usize, what: &str| match found == count {
        true => Ok(()),
        false => Err(format!("{found} {what} for {count} positions")),
    };
    let normals = primitive.get(&Semantic::Normals).map(|accessor| {
        let normals = buffers.vectors::<3>(&accessor)?;
        matching(normals.len(), "normals")?;
        Ok::<_, String>(normals.into_iter().map(|normal| placing.normal(normal)).collect())
    });
    let set = coordinates.and_then(|coordinates| {
        Some((primitive.get(&Semantic::TexCoords(coordinates.set))?, coordinates))
    });
    let uvs = set.map(|(accessor, coordinates)| {
        let uvs = buffers.vectors::<2>(&accessor)?;
        matching(uvs.len(), "texture coordinates")?;
        let finite = |uv: Vec2| if uv.is_finite() { uv } else { Vec2::ZERO };
        Ok::<_, String>(uvs.into_iter().map(|uv| finite(coordinates.apply(uv))).collect())
    });
    Ok(Attributes {
        positions_m: positions.into_iter().map(|place| placing.position_m(place)).collect(),
        normals: normals.transpose()?,
        uvs: uvs.transpose()?,
    })
}

/// Lists, strips and fans as triangles.
fn listed(mode: Mode, corners: &[u32]) -> Vec<[u32; 3]> {
    let windows = || corners.windows(3);
    match mode {
        Mode::TriangleStrip => windows()
            .enumerate()
            .map(|(index, window)| match index % 2 {
                0 => [window[0], window[1], window[2]],
                _ => [window[0], window[2], window[1]],
            })
            .collect(),
        Mode::TriangleFan => {
            let pairs = corners.get(1..).unwrap_or(&[]).windows(2);
            pairs.map(|pair| [corners[0], pair[0], pair[1]]).collect()
        }
        _ => corners.as_chunks::<3>().0.to_vec(),
    }
}

/// The unit normal of a triangle; `None` where it has none, or a corner is no place.
fn face_normal(positions_m: &[Vec3], triangle: [u32; 3]) -> Option<Vec3> {
    let [a, b, c] = triangle.map(|corner| positions_m.get(corner as usize).copied());
    let [a, b, c] = [a?, b?, c?].map(Vec3::as_dvec3);
    (b - a).cross(c - a).try_normalize().map(DVec3::as_vec3)
}
