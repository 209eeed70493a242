// Where on the ground each pixel looks, of a mesh that was made on the CPU: metres east, north and up
// of the eye, and 1.
// needs: common/frame.wgsl common/view_mesh_vertex.wgsl

struct PlaceVertex {
    @builtin(position) clip: vec4<f32>,
    @location(0) relative_m: vec3<f32>,
    @location(1) coverage: f32,
}

@vertex
fn place_vertex(vertex: SentVertex) -> PlaceVertex {
    let relative_m = place_of(vertex);
    let clip = frame.clip_from_relative * vec4<f32>(relative_m, 1.0);
    return PlaceVertex(clip, relative_m, coverage_of(vertex));
}

@fragment
fn place_fragment(in: PlaceVertex) -> @location(0) vec4<f32> {
    if in.coverage < 0.5 {
        discard;
    }
    return vec4<f32>(in.relative_m, 1.0);
}
