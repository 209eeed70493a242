// Where on a clipmap's ground each pixel looks: metres east, north and up of the eye, and 1.
// needs: common/frame.wgsl common/clip_levels.wgsl common/bilinear_height.wgsl common/clip_heights.wgsl common/clip_mesh.wgsl common/clip_surface.wgsl

struct CoordinateVertex {
    @builtin(position) @invariant position: vec4<f32>,
    @location(0) relative_m: vec3<f32>,
}

@vertex
fn coordinate_vertex(@builtin(vertex_index) index: u32, block: ClipBlock) -> CoordinateVertex {
    let relative_m = ring_place_m(index, block);
    return CoordinateVertex(frame.clip_from_relative * vec4<f32>(relative_m, 1.0), relative_m);
}

@fragment
fn coordinate_fragment(in: CoordinateVertex) -> @location(0) vec4<f32> {
    if clip_surface(in.relative_m.xy, 0.0).z < 0.5 {
        discard;
    }
    return vec4<f32>(in.relative_m, 1.0);
}
