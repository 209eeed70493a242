// Models with textures from one virtual texture: their materials, and where on the texture a surface is.
// needs page_table.wgsl
//
// The buffers that models are drawn from can be bound as storage as well:
// - vertices, nine words each without gaps: metres east, north and up in the model's own axes (3 floats), the normal
//   there (3 floats), texture coordinates u and v (2 floats), the number of the material among those of all models
//   (1 whole number);
// - indices, three words a triangle, counted from the model's first vertex: of each model first those of triangles
//   whose back is not drawn, then those seen from both sides;
// - instances, twelve words each: the rows of the matrix that turns a model's metres into metres relative to the eye,
//   for those in view, model by model.

struct ObjectMaterial {
    // Factor on the texture's colour, or the colour itself where there is none: linear light, and coverage.
    colour: vec4<f32>,
    // The mean colour of the image, which stands for it where it is only a few texels large.
    mean: vec4<f32>,
    // Texel of level 0 of the virtual texture at the image's top left corner, and the image's texels.
    first_texel: vec2<i32>,
    size_texels: vec2<f32>,
    // WRAP_..., along u and v.
    wrap: vec2<u32>,
    // The coarsest level at which the texture shows by itself; below 0 where there is no texture.
    coarsest_level: f32,
    // What is covered less is left out; 0 where all shows.
    alpha_cutoff: f32,
}

@group(3) @binding(0) var<storage, read> object_materials: array<ObjectMaterial>;

const WRAP_MIRROR: u32 = 1u;
const WRAP_CLAMP: u32 = 2u;

// A texture coordinate brought into 0 to 1 as the wrap mode says; repeating is what is left.
fn wrapped(coordinate: f32, mode: u32) -> f32 {
    if mode == WRAP_CLAMP {
        return clamp(coordinate, 0.0, 1.0);
    }
    if mode == WRAP_MIRROR {
        return 1.0 - abs(2.0 * fract(0.5 * coordinate) - 1.0);
    }
    return fract(coordinate);
}

// The place in the virtual texture.
fn object_place(material: ObjectMaterial, uv: vec2<f32>) -> TexturePlace {
    let inside = vec2<f32>(wrapped(uv.x, material.wrap.x), wrapped(uv.y, material.wrap.y));
    return place_from(material.first_texel, inside * material.size_texels);
}

// The footprint of a pixel across which texture coordinates change so much.
fn object_footprint(material: ObjectMaterial, step_x: vec2<f32>, step_y: vec2<f32>) -> PageFootprint {
    return page_footprint(step_x * material.size_texels, step_y * material.size_texels);
}

// A corner of a triangle, and the rows of the instance's matrix with it.
struct ObjectCorner {
    @location(0) position_m: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) uv: vec2<f32>,
    @location(3) material: u32,
    @location(4) east: vec4<f32>,
    @location(5) north: vec4<f32>,
    @location(6) up: vec4<f32>,
}

// Metres relative to the eye.
fn object_relative_m(corner: ObjectCorner) -> vec3<f32> {
    let local = vec4<f32>(corner.position_m, 1.0);
    return vec3<f32>(dot(corner.east, local), dot(corner.north, local), dot(corner.up, local));
}

// The direction of the normal; the matrix scales all axes alike.
fn object_normal(corner: ObjectCorner) -> vec3<f32> {
    let rows = array<vec3<f32>, 3>(corner.east.xyz, corner.north.xyz, corner.up.xyz);
    return vec3<f32>(dot(rows[0], corner.normal), dot(rows[1], corner.normal), dot(rows[2], corner.normal));
}
