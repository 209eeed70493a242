// Draws the displaced mesh: imagery of the finest cached tile, lit by the slopes, seen through haze.
// needs: common/frame.wgsl common/tile_lookup.wgsl common/surface_sample.wgsl common/colour_sample.wgsl common/atmosphere.wgsl

// Fixed when the pipeline is built, so that what is not wanted costs nothing.
override HAS_COLOURS: bool = true;
// Whether there is ground without data, to be left out.
override HAS_VOIDS: bool = true;
override DEBUG_VIEW: u32 = 0u;

const DEBUG_TILE_BORDERS: u32 = 1u;
const DEBUG_LEVELS: u32 = 2u;
const DEBUG_SLOPES: u32 = 3u;

struct TerrainVertex {
    @builtin(position) clip: vec4<f32>,
    @location(0) relative_m: vec3<f32>,
    // Part of the ground's light that comes through the air.
    @location(1) clear: f32,
    @location(2) @interpolate(flat) tile_hints: u32,
}

@vertex
fn terrain_vertex(@location(0) relative_m: vec3<f32>, @location(1) tile_hints: u32) -> TerrainVertex {
    let clip = frame.clip_from_relative * vec4<f32>(relative_m, 1.0);
    return TerrainVertex(clip, relative_m, transmittance(relative_m), tile_hints);
}

// Where there is no imagery: tints by height, as on a relief map.
fn tint_by_height(relative_z_m: f32) -> vec3<f32> {
    let part = clamp(relative_z_m * frame.tint_per_m + frame.tint_at_eye, 0.0, 1.0);
    let low = vec3<f32>(0.19, 0.30, 0.15);
    let high = vec3<f32>(0.80, 0.76, 0.70);
    return low + (high - low) * part;
}

// Light on a slope relative to level ground, so that imagery on level ground keeps its colours.
fn light(slope: vec2<f32>) -> f32 {
    let normal = normalize(vec3<f32>(-slope * frame.vertical_exaggeration, 1.0));
    let ambient = 0.35 + 0.15 * normal.z;
    let direct = max(dot(normal, frame.sun_direction), 0.0);
    let level = 0.5 + frame.sun_direction.z;
    return mix(1.0, (ambient + direct) / level, frame.shading_strength);
}

fn level_colour(level: u32) -> vec3<f32> {
    let hue = f32(level) * 0.381966;
    return 0.5 + 0.5 * cos(6.2831853 * (hue + vec3<f32>(0.0, 0.333, 0.667)));
}

fn tile_border(place: vec2<f32>, size: f32, pixel: vec2<f32>) -> f32 {
    let to_border = min(place, vec2<f32>(size) - place) / max(pixel, vec2<f32>(1.0e-6));
    return 1.0 - smoothstep(0.5, 1.5, min(to_border.x, to_border.y));
}

@fragment
fn terrain_fragment(in: TerrainVertex) -> @location(0) vec4<f32> {
    let offset_m = in.relative_m.xy;
    // Gradients of the continuous coordinate: they do not jump where the tile changes.
    let step_x_m = dpdx(offset_m);
    let step_y_m = dpdy(offset_m);
    let position = fixed_from_offset(offset_m);

    let height_entry = tile_entries[find_tile_near(frame.height_table, position, in.tile_hints & 0xffffu)];
    let height_place = texel_in_tile(height_entry, offset_m);
    // The footprint's two sides squared and multiplied: its geometric mean to the fourth power.
    let footprint_m4 = dot(step_x_m, step_x_m) * dot(step_y_m, step_y_m);
    let mip = 0.25 * log2(max(footprint_m4, 1.0e-30)) + log2(height_entry.texels_per_m);
    let surface = sample_slope(height_entry, height_place, mip);
    if HAS_VOIDS {
        if surface.z < 0.5 {
            discard;
        }
    }

    var colour = tint_by_height(in.relative_m.z);
    var shown = height_entry;
    var place = height_place;
    var size = frame.height_tile_texels;
    if HAS_COLOURS {
        let entry = tile_entries[find_tile_near(frame.colour_table, position, in.tile_hints >> 16u)];
        // Imagery ends with the data; its outermost texels go on to the very edge.
        let half_texel_m = vec2<f32>(0.5 / entry.texels_per_m);
        let inside_m = clamp(offset_m, frame.data_min_from_eye_m + half_texel_m, frame.data_max_from_eye_m - half_texel_m);
        place = texel_in_tile(entry, inside_m);
        shown = entry;
        size = frame.colour_tile_texels;
        let flip = vec2<f32>(entry.texels_per_m, -entry.texels_per_m);
        let imagery = sample_colour(entry, place, step_x_m * flip, step_y_m * flip);
        colour = mix(colour, imagery.rgb, imagery.a);
    }
    var shaded = colour * light(surface.xy);
    if DEBUG_VIEW == DEBUG_LEVELS {
        shaded = mix(shaded, level_colour(tile_level(shown)), 0.45);
    }
    if DEBUG_VIEW == DEBUG_SLOPES {
        shaded = vec3<f32>(light(surface.xy) * 0.6);
    }
    if DEBUG_VIEW == DEBUG_TILE_BORDERS || DEBUG_VIEW == DEBUG_LEVELS {
        let pixel = (abs(step_x_m) + abs(step_y_m)) * shown.texels_per_m;
        shaded = mix(shaded, level_colour(tile_level(shown)), tile_border(place, size, pixel));
        return vec4<f32>(shaded, 1.0);
    }
    return vec4<f32>(mix(frame.haze_colour, shaded, in.clear), 1.0);
}
