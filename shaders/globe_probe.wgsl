// Places vertices and points of the globe as its passes do, so that a test can compare every answer with f64.
// needs: common/frame.wgsl common/globe.wgsl common/page_table.wgsl common/globe_place.wgsl common/globe_air.wgsl

struct GlobeProbePoint {
    coarse: vec3<i32>,
    height_m: f32,
    fine: vec3<i32>,
    padding: u32,
}

struct GlobeProbeAnswer {
    clip: vec4<f32>,
    relative_m: vec3<f32>,
    cos_latitude: f32,
    texel: vec2<i32>,
    part: vec2<f32>,
    // Unit directions, and the texels to a metre, of the texture's axes on the ground.
    east: vec3<f32>,
    texels_per_m_east: f32,
    north: vec3<f32>,
    texels_per_m_south: f32,
    clear: vec3<f32>,
    padding: u32,
    sky: vec3<f32>,
    padding_too: u32,
}

@group(3) @binding(0) var<storage, read> points: array<GlobeProbePoint>;
@group(3) @binding(1) var<storage, read_write> answers: array<GlobeProbeAnswer>;

@compute @workgroup_size(64)
fn globe_probe(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&points) {
        return;
    }
    let point = points[id.x];
    let fine = vec4<u32>(vec3<u32>(point.fine), 0u);
    let relative_m = relative_place(GlobeVertex(point.coarse, fine, point.height_m, vec2<f32>(0.0)));
    let found = globe_point(relative_m, point.height_m);
    answers[id.x] = GlobeProbeAnswer(
        frame.clip_from_relative * vec4<f32>(relative_m, 1.0), relative_m, found.cos_latitude,
        found.place.texel, found.place.part, found.east, found.texels_per_m.x, found.north,
        found.texels_per_m.y, globe_clear(relative_m), 0u, globe_sky(normalize(relative_m)), 0u);
}
