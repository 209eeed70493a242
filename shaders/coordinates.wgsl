// The coordinate pass: where on the ground each pixel looks. x and y are metres east and north of
// the eye, z metres above it, w 1 on the ground. A two-channel target keeps x and y only.
// needs: common/frame.wgsl common/tile_lookup.wgsl common/surface_sample.wgsl

struct CoordinateVertex {
    @builtin(position) clip: vec4<f32>,
    @location(0) relative_m: vec3<f32>,
}

@vertex
fn coordinate_vertex(@location(0) relative_m: vec3<f32>) -> CoordinateVertex {
    return CoordinateVertex(frame.clip_from_relative * vec4<f32>(relative_m, 1.0), relative_m);
}

@fragment
fn coordinate_fragment(in: CoordinateVertex) -> @location(0) vec4<f32> {
    let position = fixed_from_offset(in.relative_m.xy);
    let entry = tile_entries[find_tile(frame.height_table, position)];
    let surface = sample_slope(entry.place, texel_in_tile(entry.place, in.relative_m.xy), 0.0);
    if surface.z < 0.5 {
        discard;
    }
    return vec4<f32>(in.relative_m, 1.0);
}
