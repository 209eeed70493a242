// What the debug views show of a virtual texture's pages on whatever it is drawn on.
// needs page_colour.wgsl ground_light.wgsl

// A picture's colour with the level of the page that shows there, or its borders alone. A pixel covers so many
// texels of level 0.
fn with_pages(colour: vec3<f32>, place: TexturePlace, footprint: PageFootprint, pixel_texels: vec2<f32>) -> vec3<f32> {
    let wanted = floor(footprint.level + pages.lookup_bias);
    let found = find_page(place, u32(clamp(wanted, 0.0, f32(pages.coarsest_level))));
    // Tiles' levels count from the coarsest.
    let hue = level_colour(pages.coarsest_level - found.level);
    let shaded = mix(colour, hue, select(0.0, 0.45, DEBUG_VIEW == DEBUG_LEVELS));
    let step_texels = pixel_texels * level_scale(found.level);
    let within = place_in_page(place, found.level, found.page);
    let to_border = min(within, f32(pages.tile_texels) - within) / max(step_texels, vec2<f32>(1.0e-6));
    let border = 1.0 - smoothstep(0.5, 1.5, min(to_border.x, to_border.y));
    return mix(shaded, hue, border);
}
