// Imagery of the cached colour tiles, decoded on the GPU after their upload, with two coarser mips.

@group(1) @binding(5) var colour_atlas: texture_2d<f32>;

// One filtered tap at a place in the tile (texels of level 0): trilinear over the slot's mips.
fn colour_tap(tile: TilePlace, place: vec2<f32>, mip: f32) -> vec4<f32> {
    let coarsest = ceil(mip);
    let margin = frame.colour_gutter_texels - 0.5 * exp2(coarsest);
    let inside = clamp(place, vec2<f32>(-margin), vec2<f32>(frame.colour_tile_texels + margin));
    let uv = atlas_uv(tile, inside, frame.colour_uv_per_texel);
    return textureSampleLevel(colour_atlas, atlas_sampler, uv, mip);
}

// Most taps along the longer axis of a pixel's footprint; 1 filters isotropically.
override ANISOTROPY: u32 = 4u;

// Imagery under a pixel whose footprint is spanned by `span_x` and `span_y` (texels a pixel step):
// taps along the longer axis, each filtered to the shorter one (after the usual definition of
// anisotropic filtering, as in EXT_texture_filter_anisotropic).
fn sample_colour(tile: TilePlace, place: vec2<f32>, span_x: vec2<f32>, span_y: vec2<f32>) -> vec4<f32> {
    let square_x = dot(span_x, span_x);
    let square_y = dot(span_y, span_y);
    let major_square = max(max(square_x, square_y), 1.0e-12);
    if ANISOTROPY == 1u {
        return colour_tap(tile, place, clamp(0.5 * log2(major_square), 0.0, COARSEST_MIP));
    }
    let major = sqrt(major_square);
    let minor = sqrt(max(min(square_x, square_y), 1.0));
    let taps = clamp(ceil(major / minor), 1.0, f32(ANISOTROPY));
    let mip = clamp(log2(major / taps), 0.0, COARSEST_MIP);
    let axis = select(span_y, span_x, square_x > square_y);
    var sum = vec4<f32>(0.0);
    for (var i = 0.0; i < taps; i += 1.0) {
        sum += colour_tap(tile, place + axis * ((i + 0.5) / taps - 0.5), mip);
    }
    return sum / taps;
}
