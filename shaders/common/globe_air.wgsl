// The air round the globe: one layer whose density falls with height by a constant factor, in which light is taken
// and given along the way. The sky is what air there is before black space: blue overhead, white where the way is
// long, a thin rim from far away. Its twin in f64 is `GlobeAir` in the library.
// needs frame.wgsl globe.wgsl

// Scale heights above the ellipsoid where the air ends, and parts that the way through it is taken in.
const AIR_TOP: f32 = 10.0;
const AIR_PARTS: i32 = 8;

// The way through air of full density, metres, that is as much air as lies before a distance in a direction.
fn air_m(direction: vec3<f32>, distance_m: f32) -> f32 {
    let along = globe.unit_from_relative * direction;
    let speed = length(along);
    // The way's point nearest to the centre; from there on, places along the way are told in units.
    let nearest = -dot(globe.unit_eye, along) / (speed * speed);
    let low = globe.unit_eye + nearest * along;
    let low_square = dot(low, low);
    let top = 1.0 + AIR_TOP / globe.air_per_unit;
    let half = sqrt(max(top * top - low_square, 0.0));
    let first = max(-nearest * speed, -half);
    let last = min((distance_m - nearest) * speed, half);
    if last <= first {
        return 0.0;
    }
    let part = (last - first) / f32(AIR_PARTS);
    var sum = 0.0;
    var before = air_depth(low_square, first);
    for (var i = 1; i <= AIR_PARTS; i++) {
        let after = air_depth(low_square, first + part * f32(i));
        // The mean of exp(-depth) where depth changes evenly.
        let rise = after - before;
        sum += select((exp(-before) - exp(-after)) / rise, exp(-0.5 * (before + after)), abs(rise) < 1.0e-2);
        before = after;
    }
    return sum * part / speed;
}

// Scale heights above the ellipsoid at a place along a way; none below it.
fn air_depth(low_square: f32, place: f32) -> f32 {
    return max(sqrt(low_square + place * place) - 1.0, 0.0) * globe.air_per_unit;
}

// Parts of the ground's light that come through the air to the eye: red, green and blue.
fn globe_clear(relative_m: vec3<f32>) -> vec3<f32> {
    let distance_m = length(relative_m);
    return exp(-globe.haze_per_m * air_m(relative_m / max(distance_m, 1.0e-3), distance_m));
}

// Light of the sky in a direction that meets no ground.
fn globe_sky(direction: vec3<f32>) -> vec3<f32> {
    return frame.haze_colour * (1.0 - exp(-globe.sky_per_m * air_m(direction, 1.0e9)));
}
