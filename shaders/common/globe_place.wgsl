// Where a point of the globe lies in the virtual texture of all longitudes and latitudes. Angles are taken from the
// anchor, the point of the ellipsoid below the eye, by formulas whose error is in proportion to the distance from it:
// so places are exact near the eye however large the texture is. Longitudes are never interpolated and never
// differenced from pixel to pixel, so there is nothing special about the date line, and nothing about the poles.
// needs globe.wgsl page_table.wgsl

// Square of the ellipsoid's first eccentricity, and the equator's radius: WGS 84.
const ECCENTRICITY_SQUARED: f32 = 6.69437999014e-3;
const EQUATOR_RADIUS_M: f32 = 6378137.0;
const PI: f32 = 3.14159265358979;

struct GlobePoint {
    place: TexturePlace,
    // Unit directions in the axes of the anchor: east, away from the earth's axis, along it.
    east: vec3<f32>,
    north: vec3<f32>,
    // Texels of level 0 to a metre east and south, where rows at high latitudes were as long as the equator's part
    // they show, so that a texel is as wide as high.
    texels_per_m: vec2<f32>,
    cos_latitude: f32,
}

// The angle of (x, y) from (1, 0), within a few last bits: WGSL promises no more than 4096 of them of its own.
// The polynomial is that of atanf in S. Moshier, "Methods and Programs for Mathematical Functions" (1989).
fn angle_of(y: f32, x: f32) -> f32 {
    let size = abs(vec2<f32>(x, y));
    let ratio = min(size.x, size.y) / max(max(size.x, size.y), 1.0e-30);
    // Above tan(pi / 8) the angle from the diagonal is the smaller one.
    let is_steep = ratio > 0.41421356;
    let near = select(ratio, (ratio - 1.0) / (ratio + 1.0), is_steep);
    let square = near * near;
    let series = ((8.05374449538e-2 * square - 1.38776856032e-1) * square + 1.99777106478e-1) * square
        - 3.33329491539e-1;
    var angle = series * square * near + near + select(0.0, 0.25 * PI, is_steep);
    angle = select(angle, 0.5 * PI - angle, size.y > size.x);
    angle = select(angle, PI - angle, x < 0.0);
    return select(angle, -angle, y < 0.0);
}

// Axes of the eye to those of the anchor.
fn anchor_axes(relative: vec3<f32>) -> vec3<f32> {
    let sine = globe.sin_latitude;
    let cosine = globe.cos_latitude;
    return vec3<f32>(
        relative.x,
        cosine * relative.z - sine * relative.y,
        cosine * relative.y + sine * relative.z,
    );
}

// The point at these metres from the eye, so high above the ellipsoid.
fn globe_point(relative_m: vec3<f32>, height_m: f32) -> GlobePoint {
    // From the point as high above the anchor.
    let lift_m = globe.eye_height_m - height_m;
    let step = anchor_axes(vec3<f32>(relative_m.xy, relative_m.z + lift_m));
    let anchor_from_axis_m = globe.anchor_from_axis_m + height_m * globe.cos_latitude;
    let meridian = vec2<f32>(anchor_from_axis_m + step.y, step.x);
    let from_axis_m = length(meridian);
    let turn = angle_of(meridian.y, meridian.x);
    // What from_axis_m is more than the anchor's, without the difference of two large numbers.
    let gained = (2.0 * anchor_from_axis_m + step.y) * step.y + step.x * step.x;
    let gained_m = gained / max(from_axis_m + anchor_from_axis_m, 1.0e-6);
    // The latitude's tangent is the distance from the equator's plane by flattening * from_axis_m.
    let polar_m = globe.anchor_radius_m * (1.0 - ECCENTRICITY_SQUARED) + height_m;
    let flattening = polar_m / (globe.anchor_radius_m + height_m);
    let along_m = flattening * gained_m;
    let rise = angle_of(
        globe.cos_latitude * step.z - globe.sin_latitude * along_m,
        polar_m + globe.cos_latitude * along_m + globe.sin_latitude * step.z,
    );
    let offset = vec2<f32>(turn, -rise) * globe.texels_per_radian;
    var point: GlobePoint;
    point.place = place_from(globe.anchor_texel, globe.anchor_part + offset);
    let towards = normalize(vec2<f32>(
        polar_m * globe.cos_latitude + along_m,
        polar_m * globe.sin_latitude + step.z,
    ));
    let outward = select(vec2<f32>(1.0, 0.0), meridian / from_axis_m, from_axis_m > 1.0e-3);
    point.east = vec3<f32>(outward.x, -outward.y, 0.0);
    point.north = vec3<f32>(-towards.y * outward.y, -towards.y * outward.x, towards.x);
    let bend = 1.0 - ECCENTRICITY_SQUARED * towards.y * towards.y;
    let radius_m = EQUATOR_RADIUS_M * inverseSqrt(bend);
    let meridian_radius_m = radius_m * (1.0 - ECCENTRICITY_SQUARED) / bend;
    point.texels_per_m =
        globe.texels_per_radian / (vec2<f32>(radius_m, meridian_radius_m) + height_m);
    point.cos_latitude = towards.x;
    return point;
}

// How far a step from a pixel to the next leads over its ground: no farther than a part of the way to it. The plane
// of a triangle seen edge on goes on far beyond the ground that the pixel shows.
fn bounded_step(step_m: vec3<f32>, relative_m: vec3<f32>) -> vec3<f32> {
    let most_m = 0.25 * length(relative_m);
    return step_m * min(1.0, most_m / max(length(step_m), 1.0e-9));
}

// How a step from the point in the axes of the eye leads over the texture, rows as long as they are on the ground.
fn ground_span(point: GlobePoint, relative_step_m: vec3<f32>) -> vec2<f32> {
    let step = anchor_axes(relative_step_m);
    return vec2<f32>(dot(step, point.east), -dot(step, point.north)) * point.texels_per_m;
}

// The same in texels of the texture's own rows, at most half a row.
fn row_span(point: GlobePoint, ground: vec2<f32>) -> vec2<f32> {
    let most = PI * globe.texels_per_radian;
    return vec2<f32>(clamp(ground.x / max(point.cos_latitude, 1.0e-9), -most, most), ground.y);
}

// The footprint of a pixel. Its level goes by what is on the ground: rows near a pole repeat themselves.
fn globe_footprint(point: GlobePoint, step_x_m: vec3<f32>, step_y_m: vec3<f32>) -> PageFootprint {
    let footprint = page_footprint(ground_span(point, step_x_m), ground_span(point, step_y_m));
    return PageFootprint(footprint.level, footprint.taps, row_span(point, footprint.axis));
}
