// A vertex of a mesh that was made on the CPU and sent as geometry.

struct SentVertex {
    // Fixed-point position in the root, x to the east and y to the south, in the low 31 bits. The highest
    // bits are the coverage: see coverage_of.
    @location(0) position: vec2<u32>,
    // Metres above the datum.
    @location(1) height_m: f32,
    // Metres gained per metre east and north.
    @location(2) slope: vec2<f32>,
}

const POSITION_BITS: u32 = 0x7fffffffu;

// Metres east, north and up of the eye. Beyond the data the mesh folds onto its border.
fn place_of(vertex: SentVertex) -> vec3<f32> {
    // Whole units: the difference is exact.
    let from_anchor = vec2<i32>(vertex.position & vec2<u32>(POSITION_BITS)) - frame.anchor_fixed;
    let metres = vec2<f32>(from_anchor) / frame.units_per_m;
    let offset_m = frame.anchor_from_eye_m + vec2<f32>(metres.x, -metres.y);
    let folded_m = clamp(offset_m, frame.data_min_from_eye_m, frame.data_max_from_eye_m);
    let above_coarse_m = vertex.height_m - frame.eye_height_coarse_m;
    return vec3<f32>(folded_m, (above_coarse_m - frame.eye_height_rest_m) * frame.vertical_exaggeration);
}

// Part of the samples around the vertex that hold data: none, less than half, half or more, all.
fn coverage_of(vertex: SentVertex) -> f32 {
    let bits = vertex.position >> vec2<u32>(31u);
    let steps = vec4<f32>(0.0, 0.25, 0.5, 1.0);
    return steps[bits.x + 2u * bits.y];
}
