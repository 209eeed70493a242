// What pages each pixel of the globe asks for; see page_requests.wgsl.
// needs: common/frame.wgsl common/globe.wgsl common/page_table.wgsl common/page_request.wgsl common/globe_place.wgsl

struct RequestVertex {
    @builtin(position) clip: vec4<f32>,
    @location(0) relative_m: vec3<f32>,
    @location(1) height_m: f32,
}

@vertex
fn globe_request_vertex(vertex: GlobeVertex) -> RequestVertex {
    let relative_m = relative_place(vertex);
    return RequestVertex(frame.clip_from_relative * vec4<f32>(relative_m, 1.0), relative_m, vertex.height_m);
}

@fragment
fn globe_request_fragment(in: RequestVertex) -> @location(0) vec2<u32> {
    let step_x_m = bounded_step(dpdx(in.relative_m), in.relative_m);
    let step_y_m = bounded_step(dpdy(in.relative_m), in.relative_m);
    let point = globe_point(in.relative_m, in.height_m);
    return page_request(point.place, globe_footprint(point, step_x_m, step_y_m));
}
