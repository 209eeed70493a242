// Runs the tile lookup and the height sampling at given points, so that a test can compare every
// answer with the twin on the CPU.
// needs: common/frame.wgsl common/tile_lookup.wgsl common/bilinear_height.wgsl common/height_sample.wgsl

struct ProbePoint {
    east_m: f32,
    north_m: f32,
    spacing_m: f32,
    padding: u32,
}

struct ProbeAnswer {
    fixed_x: i32,
    fixed_y: i32,
    linear: u32,
    descended: u32,
    // Height relative to the coarse eye height, and whether there is any.
    height_m: f32,
    weight: f32,
    place_x: f32,
    place_y: f32,
    cell: u32,
}

@group(2) @binding(0) var<storage, read> points: array<ProbePoint>;
@group(2) @binding(1) var<storage, read_write> answers: array<ProbeAnswer>;

@compute @workgroup_size(64)
fn probe(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&points) {
        return;
    }
    let point = points[id.x];
    let offset_m = vec2<f32>(point.east_m, point.north_m);
    let position = fixed_from_offset(offset_m);
    let found = descend(frame.height_table, position);
    let entry = tile_entries[found.entry].place;
    let place = texel_in_tile(entry, offset_m);
    let sample = sample_height(entry, place, point.spacing_m);
    answers[id.x] = ProbeAnswer(
        position.x, position.y,
        find_tile_linear(frame.height_table, position), found.entry,
        sample.x, sample.y, place.x, place.y, found.cell);
}
