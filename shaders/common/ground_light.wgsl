// How ground looks in the picture: its light, the air before it, and what the debug views show of it.

// Fixed when the pipeline is built, so that what is not wanted costs nothing.
override DEBUG_VIEW: u32 = 0u;
override MULTISAMPLED: bool = false;

const DEBUG_OFF: u32 = 0u;
const DEBUG_LEVELS: u32 = 2u;
const DEBUG_SLOPES: u32 = 3u;

// Where a pixel is multisampled, a triangle that covers only a part of it may miss its centre, and its
// plane may be anywhere there: hence centroids, which lie on the triangle. In a pixel that is covered
// as a whole they are its centre.

// Part of the ground's light that comes through the air to this fragment. Interpolated between the
// vertices, except where a fragment may lie beside its triangle: an interpolated part could then be
// more than all, and centroids are not to be had either, because llvmpipe (Mesa 22.3) divides what it
// interpolates there by the depth at the pixel's centre.
fn clear_at(relative_m: vec3<f32>, interpolated: f32) -> f32 {
    if MULTISAMPLED {
        return transmittance(relative_m);
    }
    return interpolated;
}

// Where there is no imagery: tints by height, as on a relief map.
fn tint_by_height(relative_z_m: f32) -> vec3<f32> {
    let part = clamp(relative_z_m * frame.tint_per_m + frame.tint_at_eye, 0.0, 1.0);
    let low = vec3<f32>(0.19, 0.30, 0.15);
    let high = vec3<f32>(0.80, 0.76, 0.70);
    return low + (high - low) * part;
}

// Light on a surface relative to level ground, so that imagery on level ground keeps its colours.
fn light_on(normal: vec3<f32>) -> f32 {
    let ambient = 0.35 + 0.15 * normal.z;
    let direct = max(dot(normal, frame.sun_direction), 0.0);
    let level = 0.5 + frame.sun_direction.z;
    return mix(1.0, (ambient + direct) / level, frame.shading_strength);
}

// Light on a slope of the ground.
fn light(slope: vec2<f32>) -> f32 {
    return light_on(normalize(vec3<f32>(-slope * frame.vertical_exaggeration, 1.0)));
}

fn level_colour(level: u32) -> vec3<f32> {
    let hue = f32(level) * 0.381966;
    return 0.5 + 0.5 * cos(6.2831853 * (hue + vec3<f32>(0.0, 0.333, 0.667)));
}

// A pixel on the ground: metres east and north of the eye, and how they change to the next pixels.
// Gradients of the continuous coordinate do not jump where the tile changes.
struct Footprint {
    offset_m: vec2<f32>,
    step_x_m: vec2<f32>,
    step_y_m: vec2<f32>,
}

// The picture's colour of ground lit by its slope, seen through the air.
fn ground_colour(bare: vec3<f32>, slope: vec2<f32>, clear: f32) -> vec4<f32> {
    return vec4<f32>(mix(frame.haze_colour, bare * light(slope), clear), 1.0);
}
