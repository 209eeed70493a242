// Heights of the cached tiles, filtered to a wanted spacing.

@group(1) @binding(2) var height_atlas: texture_2d<f32>;

// Height of one texel relative to the coarse eye height, or NO_DATA_M.
fn load_height(texel: vec2<i32>, mip: i32) -> f32 {
    let height_m = textureLoad(height_atlas, texel, mip).x;
    return select(height_m - frame.eye_height_coarse_m, NO_DATA_M, height_m <= NO_DATA_M);
}

// Bilinear height at a place in the tile (texels of mip 0), from one mip of its slot: x is the
// height weighted by the data under the four texels, y that weight.
fn bilinear_height(tile: TilePlace, place: vec2<f32>, mip: i32) -> vec2<f32> {
    let scale = 1.0 / f32(1 << u32(mip));
    let gutter = frame.height_gutter_texels * scale;
    let size = frame.height_tile_texels * scale;
    // What the place is told from may lie within a texel of a coarser mip.
    let told_from = told_from_texel(tile, frame.height_tile_texels, frame.height_gutter_texels) * scale;
    let first = -floor(told_from);
    let from_texel = place * scale + fract(told_from);
    let at = clamp(from_texel, first + (0.5 - gutter), first + (size + gutter - 0.5)) - 0.5;
    let low = floor(at);
    let part = at - low;
    let corner = vec2<i32>(atlas_texel(tile) >> vec2<u32>(u32(mip))) + vec2<i32>(low);
    let h00 = load_height(corner, mip);
    let h10 = load_height(corner + vec2<i32>(1, 0), mip);
    let h01 = load_height(corner + vec2<i32>(0, 1), mip);
    let h11 = load_height(corner + vec2<i32>(1, 1), mip);
    return bilinear_of(vec4<f32>(h00, h10, h01, h11), part);
}

// Height relative to the coarse eye height, band-limited to `spacing_m`: trilinear between the two
// mips whose texels bracket the spacing, so that a vertex sees no feature its mesh cannot carry.
// Where a mip holds no data the next coarser one stands in; x is the height, y 0 where none had any.
fn sample_height(tile: TilePlace, place: vec2<f32>, spacing_m: f32) -> vec2<f32> {
    let mip = clamp(log2(max(spacing_m * tile.texels_per_m, 1.0e-6)), 0.0, COARSEST_MIP);
    let fine = i32(floor(mip));
    let part = mip - floor(mip);
    var near = bilinear_height(tile, place, fine);
    if part == 0.0 && near.y > 0.0 {
        return near;
    }
    let far = bilinear_height(tile, place, min(fine + 1, i32(COARSEST_MIP)));
    near.x = select(far.x, near.x, near.y > 0.0);
    let far_x = select(near.x, far.x, far.y > 0.0);
    return vec2<f32>(near.x + (far_x - near.x) * part, max(near.y, far.y));
}
