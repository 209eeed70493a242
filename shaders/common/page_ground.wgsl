// Where the ground of a plane dataset lies in its virtual texture.
// needs page_table.wgsl

struct PageGround {
    // A texel of level 0 near the eye, and where its north-west corner lies from the eye, metres east and north.
    anchor_texel: vec2<i32>,
    anchor_from_eye_m: vec2<f32>,
    // Texels of level 0.
    texels_per_m: f32,
    padding: f32,
}

@group(3) @binding(0) var<uniform> page_ground: PageGround;

// Texels of level 0 east and south.
fn ground_texels(offset_m: vec2<f32>) -> vec2<f32> {
    return vec2<f32>(offset_m.x, -offset_m.y) * page_ground.texels_per_m;
}

// The texture's place at metres east and north of the eye.
fn ground_place(offset_m: vec2<f32>) -> TexturePlace {
    return place_from(page_ground.anchor_texel, ground_texels(offset_m - page_ground.anchor_from_eye_m));
}
