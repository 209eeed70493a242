// Heights of a clipmap's levels, filtered to a wanted level.

@group(1) @binding(2) var clip_heights: texture_2d_array<f32>;

// Height of one texel relative to the coarse eye height, or NO_DATA_M.
fn load_clip_height(layer: u32, texel: vec2<i32>) -> f32 {
    let whole = clip_levels[layer].whole;
    let inside = clamp(texel, whole.xy, whole.zw - 1);
    let side = vec2<i32>(i32(textureDimensions(clip_heights).x));
    let wrapped = ((clip_levels[layer].texture_texel + inside) % side + side) % side;
    let height_m = textureLoad(clip_heights, wrapped, layer, 0).x;
    return select(height_m - frame.eye_height_coarse_m, NO_DATA_M, height_m <= NO_DATA_M);
}

// Bilinear height of a level at a place: see bilinear_of.
fn level_height(layer: u32, offset_m: vec2<f32>) -> vec2<f32> {
    let at = place_in_level(layer, offset_m) - 0.5;
    let low = floor(at);
    let corner = vec2<i32>(low);
    let heights = vec4<f32>(
        load_clip_height(layer, corner),
        load_clip_height(layer, corner + vec2<i32>(1, 0)),
        load_clip_height(layer, corner + vec2<i32>(0, 1)),
        load_clip_height(layer, corner + vec2<i32>(1, 1)));
    return bilinear_of(heights, at - low);
}

// Height above the eye at a place, exaggerated, by the wanted level; the lowest there is where none has
// data.
fn ground_above_eye_m(offset_m: vec2<f32>, wanted: f32) -> f32 {
    let choice = choose_level(0u, clip.height_levels, offset_m, wanted, clip.height_fade_texels);
    var height = level_height(choice.level, offset_m);
    if choice.level > 0u && (choice.part < 1.0 || height.y == 0.0) {
        let coarser = level_height(choice.level - 1u, offset_m);
        let fine_x = select(coarser.x, height.x, height.y > 0.0);
        let coarse_x = select(height.x, coarser.x, coarser.y > 0.0);
        height = vec2<f32>(coarse_x + (fine_x - coarse_x) * choice.part, max(height.y, coarser.y));
    }
    let lowest_m = frame.height_min_m - frame.eye_height_coarse_m;
    let above_coarse_m = select(lowest_m, height.x, height.y > 0.0);
    return (above_coarse_m - frame.eye_height_rest_m) * frame.vertical_exaggeration;
}
