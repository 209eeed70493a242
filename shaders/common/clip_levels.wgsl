// The windows of a clipmap: which level shows a place, and what it holds there.

struct ClipLevel {
    // North-west corner of the texel nearest to the eye, metres east and north of it. Places are told
    // from there: near the eye they are small and exact.
    origin_from_eye_m: vec2<f32>,
    texels_per_m: f32,
    texel_m: f32,
    // What the level shows, in texels east and south of that corner: west, north, east, south. Far
    // beyond its texels where no coarser level goes on either.
    shown: vec4<f32>,
    // All texels that the level has at any time, likewise.
    whole: vec4<i32>,
    // That texel in the texture, whose sides wrap round.
    texture_texel: vec2<i32>,
    padding: vec2<i32>,
}

struct ClipFrame {
    // The mesh's grid point nearest to the eye, metres east and north of it.
    reference_from_eye_m: vec2<f32>,
    // Spacing of the finest ring in metres.
    unit_m: f32,
    // Cells along a ring's side.
    ring_cells: f32,
    // Vertices of a patch from west to east.
    patch_columns: u32,
    // Height level whose texels are half as large as the finest ring's spacing; may lie beyond the levels.
    mesh_level: f32,
    // Levels in use of either layer: those of the heights stand first in the list.
    height_levels: u32,
    colour_levels: u32,
    // Texels over which a level fades into the next coarser one before its border.
    height_fade_texels: f32,
    colour_fade_texels: f32,
}

const MOST_LEVELS: u32 = 50u;
// A filter at a place so far inside a border takes in none of what lies beyond, nor slopes that know one
// side only.
const BORDER_TEXELS: f32 = 2.0;

@group(1) @binding(0) var<uniform> clip: ClipFrame;
@group(1) @binding(1) var<uniform> clip_levels: array<ClipLevel, MOST_LEVELS>;

struct ClipChoice {
    // Index in the list of levels.
    level: u32,
    // Its part; the rest is the next coarser level's, which is the one before it in the list.
    part: f32,
}

// Levels are named by their index, not handed on: loading one as a whole for every fragment is dear.

fn place_in_level(index: u32, offset_m: vec2<f32>) -> vec2<f32> {
    let from_origin_m = offset_m - clip_levels[index].origin_from_eye_m;
    return vec2<f32>(from_origin_m.x, -from_origin_m.y) * clip_levels[index].texels_per_m;
}

// Texels from a place to the border of what the level shows; negative beyond it.
fn inside_texels(index: u32, offset_m: vec2<f32>) -> f32 {
    let place = place_in_level(index, offset_m);
    let shown = clip_levels[index].shown;
    let inset = min(place - shown.xy, shown.zw - place);
    return min(inset.x, inset.y);
}

// The level to sample a place at, of `count` levels from `first` on, where `wanted` would be best (0 the
// coarsest, in between both): the wanted one, or the finest one there is. Continuous, also where levels
// end.
fn choose_level(first: u32, count: u32, offset_m: vec2<f32>, wanted: f32, fade_texels: f32) -> ClipChoice {
    let capped = clamp(wanted, 0.0, f32(count - 1u));
    var index = u32(ceil(capped));
    loop {
        if index == 0u { break; }
        let inside = inside_texels(first + index, offset_m);
        let presence = clamp((inside - BORDER_TEXELS) / fade_texels, 0.0, 1.0);
        if presence > 0.0 {
            return ClipChoice(first + index, min(presence, capped - f32(index - 1u)));
        }
        index -= 1u;
    }
    return ClipChoice(first, 1.0);
}

// Where in its texture the level has a point of the ground, in parts of the texture's side; a sampler
// that repeats finds the place that wraps round. The data's outermost texels go on to its very edge.
fn clip_uv(index: u32, offset_m: vec2<f32>, texture_side: u32) -> vec2<f32> {
    let half_texel_m = vec2<f32>(0.5 * clip_levels[index].texel_m);
    let inside_m = clamp(offset_m, frame.data_min_from_eye_m + half_texel_m, frame.data_max_from_eye_m - half_texel_m);
    let place = vec2<f32>(clip_levels[index].texture_texel) + place_in_level(index, inside_m);
    return place / f32(texture_side);
}
