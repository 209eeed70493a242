// Slopes and coverage of a clipmap's ground, for shading.

// x, y: height gained per metre east and north; z: 1 where there is data, 0 where there is none.
@group(1) @binding(3) var clip_slopes: texture_2d_array<f32>;
@group(1) @binding(4) var clip_sampler: sampler;

fn level_slope(layer: u32, offset_m: vec2<f32>) -> vec3<f32> {
    let uv = clip_uv(layer, offset_m, textureDimensions(clip_slopes).x);
    return textureSampleLevel(clip_slopes, clip_sampler, uv, layer, 0.0).xyz;
}

// Slopes under a footprint so many metres wide.
fn clip_surface(offset_m: vec2<f32>, footprint_m: f32) -> vec3<f32> {
    let count = clip.height_levels;
    let finest_texels = footprint_m * clip_levels[count - 1u].texels_per_m;
    let coarser = log2(max(finest_texels, 1.0));
    let wanted = f32(count - 1u) - coarser;
    let choice = choose_level(0u, count, offset_m, wanted, clip.height_fade_texels);
    let fine = level_slope(choice.level, offset_m);
    if choice.level == 0u || choice.part == 1.0 {
        return fine;
    }
    return mix(level_slope(choice.level - 1u, offset_m), fine, choice.part);
}
