// Draws the rings of a clipmap: imagery of the level that fits the pixel, lit by the slopes, seen through
// haze.
// needs: common/frame.wgsl common/clip_levels.wgsl common/bilinear_height.wgsl common/clip_heights.wgsl common/clip_mesh.wgsl common/clip_surface.wgsl common/atmosphere.wgsl common/ground_light.wgsl

override HAS_COLOURS: bool = true;
// Whether there is ground without data, to be left out.
override HAS_VOIDS: bool = true;
// Most taps along the longer axis of a pixel's footprint; 1 filters isotropically.
override ANISOTROPY: u32 = 4u;

@group(1) @binding(5) var clip_colours: texture_2d_array<f32>;

struct GroundVertex {
    @builtin(position) @invariant position: vec4<f32>,
    @location(0) @interpolate(perspective, centroid) relative_m: vec3<f32>,
    @location(1) clear: f32,
}

@vertex
fn clip_vertex(@builtin(vertex_index) index: u32, block: ClipBlock) -> GroundVertex {
    let relative_m = ring_place_m(index, block);
    let position = frame.clip_from_relative * vec4<f32>(relative_m, 1.0);
    return GroundVertex(position, relative_m, transmittance(relative_m));
}

fn level_imagery(index: u32, offset_m: vec2<f32>) -> vec4<f32> {
    let uv = clip_uv(index, offset_m, textureDimensions(clip_colours).x);
    return textureSampleLevel(clip_colours, clip_sampler, uv, index - clip.height_levels, 0.0);
}

// One filtered tap: trilinear between two levels.
fn imagery_tap(choice: ClipChoice, offset_m: vec2<f32>) -> vec4<f32> {
    let fine = level_imagery(choice.level, offset_m);
    if choice.level == clip.height_levels || choice.part == 1.0 {
        return fine;
    }
    return mix(level_imagery(choice.level - 1u, offset_m), fine, choice.part);
}

fn imagery_level(offset_m: vec2<f32>, footprint_m: f32) -> ClipChoice {
    let finest = clip.height_levels + clip.colour_levels - 1u;
    let coarser = log2(max(footprint_m * clip_levels[finest].texels_per_m, 1.0));
    let wanted = f32(clip.colour_levels - 1u) - coarser;
    return choose_level(clip.height_levels, clip.colour_levels, offset_m, wanted, clip.colour_fade_texels);
}

// Imagery under a pixel: taps along the longer axis of its footprint, each filtered to the shorter one
// (after the usual definition of anisotropic filtering, as in EXT_texture_filter_anisotropic).
fn imagery_under(pixel: Footprint) -> vec4<f32> {
    let along_x = length(pixel.step_x_m);
    let along_y = length(pixel.step_y_m);
    let major = max(along_x, along_y);
    if ANISOTROPY == 1u {
        return imagery_tap(imagery_level(pixel.offset_m, major), pixel.offset_m);
    }
    // Below a texel there is nothing to filter.
    let finest_m = clip_levels[clip.height_levels + clip.colour_levels - 1u].texel_m;
    let minor = max(min(along_x, along_y), finest_m);
    let taps = clamp(ceil(major / minor), 1.0, f32(ANISOTROPY));
    let axis = select(pixel.step_y_m, pixel.step_x_m, along_x > along_y);
    let choice = imagery_level(pixel.offset_m, major / taps);
    var sum = vec4<f32>(0.0);
    for (var i = 0.0; i < taps; i += 1.0) {
        sum += imagery_tap(choice, pixel.offset_m + axis * ((i + 0.5) / taps - 0.5));
    }
    return sum / taps;
}

// The picture with the level each pixel is drawn from as a colour, and where its window ends.
fn debug_colour(bare: vec3<f32>, lit: f32, pixel: Footprint, clear: f32) -> vec4<f32> {
    if DEBUG_VIEW == DEBUG_SLOPES {
        return vec4<f32>(mix(frame.haze_colour, vec3<f32>(lit * 0.6), clear), 1.0);
    }
    let footprint_m = max(length(pixel.step_x_m), length(pixel.step_y_m));
    var first = 0u;
    var choice = choose_level(0u, clip.height_levels, pixel.offset_m, f32(clip.height_levels), 1.0);
    if HAS_COLOURS {
        first = clip.height_levels;
        choice = imagery_level(pixel.offset_m, footprint_m);
    }
    let hue = mix(level_colour(max(choice.level, first + 1u) - 1u - first), level_colour(choice.level - first), choice.part);
    let shaded = mix(bare * lit, hue, select(0.0, 0.45, DEBUG_VIEW == DEBUG_LEVELS));
    // All windows' borders, the finest drawn last.
    var border = 0.0;
    for (var index = first + 1u; index < first + select(clip.height_levels, clip.colour_levels, HAS_COLOURS); index++) {
        let inside_m = abs(inside_texels(index, pixel.offset_m)) * clip_levels[index].texel_m;
        let border_px = inside_m / max(footprint_m, 1.0e-9);
        border = max(border, 1.0 - smoothstep(0.5, 1.5, border_px));
    }
    return vec4<f32>(mix(shaded, hue, border), 1.0);
}

@fragment
fn clip_fragment(in: GroundVertex) -> @location(0) vec4<f32> {
    let offset_m = in.relative_m.xy;
    let pixel = Footprint(offset_m, dpdx(offset_m), dpdy(offset_m));
    // The geometric mean of the footprint's sides.
    let footprint_m = sqrt(length(pixel.step_x_m) * length(pixel.step_y_m));
    let surface = clip_surface(offset_m, footprint_m);
    if HAS_VOIDS {
        if surface.z < 0.5 {
            discard;
        }
    }
    var bare = tint_by_height(in.relative_m.z);
    if HAS_COLOURS {
        let imagery = imagery_under(pixel);
        bare = mix(bare, imagery.rgb, imagery.a);
    }
    let clear = clear_at(in.relative_m, in.clear);
    if DEBUG_VIEW == DEBUG_OFF {
        return ground_colour(bare, surface.xy, clear);
    }
    return debug_colour(bare, light(surface.xy), pixel, clear);
}
