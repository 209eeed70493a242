// What every pass of a frame knows. World positions are metres relative to the eye
// (x east, y north, z up); absolute coordinates never reach the GPU.

struct TableRange {
    // Where the layer's entries and quadtree nodes begin in the shared buffers.
    first_entry: u32,
    entry_count: u32,
    first_node: u32,
    // The root's own word; see tile_lookup.wgsl.
    root_word: u32,
}

struct FrameUniforms {
    clip_from_relative: mat4x4<f32>,
    // World direction of the picture's centre, and of its right and upper borders from there.
    view_forward: vec3<f32>,
    units_per_m: f32,
    view_right: vec3<f32>,
    mesh_scale_m: f32,
    view_up: vec3<f32>,
    vertical_exaggeration: f32,
    // Fixed-point position of the anchor, the root's point nearest to the eye, and its place.
    anchor_fixed: vec2<i32>,
    anchor_from_eye_m: vec2<f32>,
    // The ground that holds data.
    data_min_from_eye_m: vec2<f32>,
    data_max_from_eye_m: vec2<f32>,
    // Unexaggerated height of the eye in two parts: heights are taken relative to the first
    // (exact), and the small rest is subtracted after interpolation.
    eye_height_coarse_m: f32,
    eye_height_rest_m: f32,
    haze_distance_m: f32,
    haze_scale_height_m: f32,
    sun_direction: vec3<f32>,
    shading_strength: f32,
    haze_colour: vec3<f32>,
    eye_height_above_base_m: f32,
    zenith_colour: vec3<f32>,
    height_min_m: f32,
    // Part of the way from the lowest to the highest ground, at the eye and gained per metre up.
    tint_at_eye: f32,
    tint_per_m: f32,
    height_tile_texels: f32,
    colour_tile_texels: f32,
    height_gutter_texels: f32,
    colour_gutter_texels: f32,
    has_colours: u32,
    @align(16) height_table: TableRange,
    colour_table: TableRange,
}

@group(0) @binding(0) var<uniform> frame: FrameUniforms;

// Mips a slot has below its own texels: two halvings leave a gutter of one texel.
const COARSEST_MIP: f32 = 2.0;
// Heights at or below this hold no data.
const NO_DATA_M: f32 = -1.0e30;
