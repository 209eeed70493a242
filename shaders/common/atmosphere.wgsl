// Haze and sky: one exponential layer of air whose density halves with height, so that far ground
// fades into the sky at the horizon and high cameras see clearly straight down.

// Part of the light that reaches the eye from a point `relative_m` away: Beer's law with the optical
// depth of an exponential atmosphere integrated along the ray in closed form.
fn transmittance(relative_m: vec3<f32>) -> f32 {
    let distance_m = length(relative_m);
    let rise = relative_m.z / frame.haze_scale_height_m;
    let density = exp(-max(frame.eye_height_above_base_m, 0.0) / frame.haze_scale_height_m);
    let mean = select((1.0 - exp(-rise)) / rise, 1.0 - 0.5 * rise, abs(rise) < 1.0e-3);
    return exp(-distance_m / frame.haze_distance_m * density * mean);
}

fn sky_colour(direction: vec3<f32>) -> vec3<f32> {
    let up = clamp(direction.z, 0.0, 1.0);
    return mix(frame.haze_colour, frame.zenith_colour, 1.0 - pow(1.0 - up, 4.0));
}

// Beyond the edge of the data and below the horizon: haze deepening like the sky above it.
fn background_colour(direction: vec3<f32>) -> vec3<f32> {
    if direction.z >= 0.0 {
        return sky_colour(direction);
    }
    let down = 1.0 - pow(1.0 + direction.z, 3.0);
    return mix(frame.haze_colour, frame.zenith_colour, 0.7 * down);
}
