// Slopes and coverage of the cached height tiles, for shading.

// x, y: height gained per metre east and north; z: 1 where there is data, 0 where there is none.
@group(1) @binding(3) var slope_atlas: texture_2d<f32>;
@group(1) @binding(4) var atlas_sampler: sampler;

// Slopes at a place in the tile, filtered to 2^mip texels.
fn sample_slope(tile: TilePlace, place: vec2<f32>, wanted_mip: f32) -> vec3<f32> {
    let mip = clamp(wanted_mip, 0.0, COARSEST_MIP);
    let uv = atlas_uv(tile, place, frame.height_uv_per_texel);
    return textureSampleLevel(slope_atlas, atlas_sampler, uv, mip).xyz;
}
