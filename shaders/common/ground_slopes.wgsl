// Slopes and coverage of the ground under a pixel.
// needs tile_lookup.wgsl surface_sample.wgsl ground_light.wgsl, and ANISOTROPY

fn surface_under(tile: TilePlace, pixel: Footprint) -> vec3<f32> {
    // The footprint's two sides squared and multiplied: its geometric mean to the fourth power.
    let footprint_m4 = dot(pixel.step_x_m, pixel.step_x_m) * dot(pixel.step_y_m, pixel.step_y_m);
    let mip = 0.25 * log2(max(footprint_m4, 1.0e-30)) + log2(tile.texels_per_m);
    return sample_slope(tile, texel_in_tile(tile, pixel.offset_m), mip);
}

// Within one tile the places of a triangle's fragments are continuous, so that the sampler itself can
// tell the mip from them. Where nothing finer than its isotropic filter is asked for, that will do: a
// mip of its own for every fragment costs a software renderer half as much again.
fn surface_within(tile: TilePlace, pixel: Footprint) -> vec3<f32> {
    if ANISOTROPY == 1u {
        let place = texel_in_tile(tile, pixel.offset_m);
        return textureSample(slope_atlas, atlas_sampler, atlas_uv(tile, place, frame.height_uv_per_texel)).xyz;
    }
    return surface_under(tile, pixel);
}
