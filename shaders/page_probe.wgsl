// Runs the page table's functions at given places, so that a test can compare every answer with the twin on the
// CPU.
// needs: common/page_table.wgsl common/page_request.wgsl common/page_colour.wgsl

struct PageProbePoint {
    st: vec2<f32>,
    span_x: vec2<f32>,
    span_y: vec2<f32>,
    padding: vec2<f32>,
}

struct PageProbeAnswer {
    colour: vec4<f32>,
    texel: vec2<i32>,
    part: vec2<f32>,
    request: vec2<u32>,
    in_page: vec2<f32>,
    level: f32,
    taps: f32,
    found_level: u32,
    found_word: u32,
}

@group(0) @binding(0) var<storage, read> points: array<PageProbePoint>;
@group(0) @binding(1) var<storage, read_write> answers: array<PageProbeAnswer>;

@compute @workgroup_size(64)
fn page_probe(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&points) {
        return;
    }
    let point = points[id.x];
    let place = place_at(point.st);
    let footprint = page_footprint(point.span_x, point.span_y);
    let wanted = clamp(floor(footprint.level + pages.lookup_bias), 0.0, f32(pages.coarsest_level));
    let found = find_page(place, u32(wanted));
    answers[id.x] = PageProbeAnswer(
        page_colour(place, footprint), place.texel, place.part, page_request(place, footprint),
        place_in_page(place, found.level, found.page), footprint.level, footprint.taps, found.level,
        found.word);
}
