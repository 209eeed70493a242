// How ground looks whose imagery comes from cached tiles.

// Fixed when the pipeline is built, so that what is not wanted costs nothing.
override HAS_COLOURS: bool = true;
// Whether there is ground without data, to be left out.
override HAS_VOIDS: bool = true;

// Imagery of a tile under a pixel.
fn imagery_under(tile: TilePlace, pixel: Footprint) -> vec4<f32> {
    let flip = vec2<f32>(tile.texels_per_m, -tile.texels_per_m);
    let place = texel_in_tile(tile, pixel.offset_m);
    return sample_colour(tile, place, pixel.step_x_m * flip, pixel.step_y_m * flip);
}

// Where the imagery of a place is: it ends with the data, and its outermost texels go on to the very edge.
fn imaged_offset_m(tile: TilePlace, offset_m: vec2<f32>) -> vec2<f32> {
    let half_texel_m = vec2<f32>(0.5 / tile.texels_per_m);
    return clamp(offset_m, frame.data_min_from_eye_m + half_texel_m, frame.data_max_from_eye_m - half_texel_m);
}

fn tile_border(place: vec2<f32>, size: f32, pixel: vec2<f32>) -> f32 {
    let to_border = min(place, vec2<f32>(size) - place) / max(pixel, vec2<f32>(1.0e-6));
    return 1.0 - smoothstep(0.5, 1.5, min(to_border.x, to_border.y));
}

// The picture with what the debug view shows. Where borders are drawn there is no haze over them.
fn debug_colour(bare: vec3<f32>, lit: f32, shown: TileEntry, pixel: Footprint, size: f32, clear: f32) -> vec4<f32> {
    if DEBUG_VIEW == DEBUG_SLOPES {
        return vec4<f32>(mix(frame.haze_colour, vec3<f32>(lit * 0.6), clear), 1.0);
    }
    let hue = level_colour(shown.level);
    let shaded = mix(bare * lit, hue, select(0.0, 0.45, DEBUG_VIEW == DEBUG_LEVELS));
    let pixel_texels = (abs(pixel.step_x_m) + abs(pixel.step_y_m)) * shown.place.texels_per_m;
    let gutter = select(frame.height_gutter_texels, frame.colour_gutter_texels, HAS_COLOURS);
    let place = texel_in_tile(shown.place, pixel.offset_m) + told_from_texel(shown.place, size, gutter);
    return vec4<f32>(mix(shaded, hue, tile_border(place, size, pixel_texels)), 1.0);
}
