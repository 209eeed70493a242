// The globe as an eye sees it, and the vertices of its mesh. Relative metres are east, north and up of the eye.

struct Globe {
    // Earth-centred axes to those of the eye.
    relative_from_ecef: mat3x3<f32>,
    // The same to axes in which the ellipsoid is a ball of radius 1, per metre.
    unit_from_relative: mat3x3<f32>,
    // The eye there.
    unit_eye: vec3<f32>,
    // Scale heights of the air to a unit.
    air_per_unit: f32,
    // The eye, earth-centred, in COARSE_M and FINE_M.
    eye_coarse: vec3<i32>,
    // Metres above the ellipsoid.
    eye_height_m: f32,
    eye_fine: vec3<i32>,
    // Texels of level 0 to a radian.
    texels_per_radian: f32,
    // Light that a metre of the densest air takes and gives: of the sky, and before the ground.
    sky_per_m: vec3<f32>,
    sin_latitude: f32,
    haze_per_m: vec3<f32>,
    cos_latitude: f32,
    // The anchor, the ellipsoid's point below the eye: its texel of level 0, and the part of the way across it.
    anchor_texel: vec2<i32>,
    anchor_part: vec2<f32>,
    // Its distance from the earth's axis.
    anchor_from_axis_m: f32,
    // The ellipsoid's radius of curvature there, across the meridian.
    anchor_radius_m: f32,
}

@group(1) @binding(0) var<uniform> globe: Globe;

const COARSE_M: f32 = 0.25;
const FINE_M: f32 = 3.814697265625e-6;

struct GlobeVertex {
    // Earth-centred place: whole steps of COARSE_M, and the rest in steps of FINE_M.
    @location(0) coarse: vec3<i32>,
    @location(1) fine: vec4<u32>,
    // Metres above the ellipsoid, exaggerated as the place is.
    @location(2) height_m: f32,
    // Metres up per metre east and north.
    @location(3) slope: vec2<f32>,
}

// Differences of whole numbers are exact: a vertex that two patches share comes out the same in both.
fn relative_place(vertex: GlobeVertex) -> vec3<f32> {
    let coarse = vec3<f32>(vertex.coarse - globe.eye_coarse);
    let fine = vec3<f32>(vec3<i32>(vertex.fine.xyz) - globe.eye_fine);
    return globe.relative_from_ecef * (coarse * COARSE_M + fine * FINE_M);
}
