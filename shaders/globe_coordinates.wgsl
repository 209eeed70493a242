// Where on the globe each pixel looks: metres east, north and up of the eye, and 1.
// needs: common/frame.wgsl common/globe.wgsl

struct PlaceVertex {
    @builtin(position) clip: vec4<f32>,
    @location(0) relative_m: vec3<f32>,
}

@vertex
fn globe_place_vertex(vertex: GlobeVertex) -> PlaceVertex {
    let relative_m = relative_place(vertex);
    return PlaceVertex(frame.clip_from_relative * vec4<f32>(relative_m, 1.0), relative_m);
}

@fragment
fn globe_place_fragment(in: PlaceVertex) -> @location(0) vec4<f32> {
    return vec4<f32>(in.relative_m, 1.0);
}
