// The sky round the globe, from blue on the ground to black in space: one triangle over the picture at the far plane.
// needs: common/frame.wgsl common/globe.wgsl common/globe_air.wgsl

struct SkyVertex {
    @builtin(position) clip: vec4<f32>,
    @location(0) direction: vec3<f32>,
}

@vertex
fn globe_sky_vertex(@builtin(vertex_index) index: u32) -> SkyVertex {
    let corner = vec2<f32>(f32((index << 1u) & 2u), f32(index & 2u)) * 2.0 - 1.0;
    let direction = frame.view_forward + corner.x * frame.view_right + corner.y * frame.view_up;
    // Depth 0 is infinitely far in reverse depth.
    return SkyVertex(vec4<f32>(corner, 0.0, 1.0), direction);
}

@fragment
fn globe_sky_fragment(in: SkyVertex) -> @location(0) vec4<f32> {
    return vec4<f32>(globe_sky(normalize(in.direction)), 1.0);
}
