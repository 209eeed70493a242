// Haze and sky: one exponential layer of air whose density halves with height, so that far ground
// fades into the sky at the horizon and high cameras see clearly straight down.

// Part of the light that reaches the eye from a point `relative_m` away: Beer's law with the optical
// depth of an exponential atmosphere integrated along the ray in closed form.
fn transmittance(relative_m: vec3<f32>) -> f32 {
    // In scale heights above the lowest ground; below it the air is as dense as there.
    let eye = max(frame.eye_height_above_base_m, 0.0) / frame.haze_scale_height_m;
    let ground = max(frame.eye_height_above_base_m + relative_m.z, 0.0) / frame.haze_scale_height_m;
    let rise = ground - eye;
    // The mean of exp(-h) over the ray; each part stays finite however high the eye is.
    let mean = select((exp(-eye) - exp(-ground)) / rise, exp(-0.5 * (eye + ground)), abs(rise) < 1.0e-3);
    return exp(-length(relative_m) / frame.haze_distance_m * mean);
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
    let down = 1.0 - pow(1.0 + direction.z, 2.0);
    return mix(frame.haze_colour, frame.zenith_colour, 0.7 * down);
}
