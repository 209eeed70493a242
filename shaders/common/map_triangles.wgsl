// Lays triangles into the texture map and marks the pages that its cells show.
//
// Conservative rasterisation in software, since hardware's may be absent: a triangle is drawn as the rectangle of
// cells round it, and each cell asks whether the triangle reaches into it. So every cell a triangle touches is drawn
// exactly once, however small the triangle is. (After Hasselgren, Akenine-Moeller and Ohlsson, "Conservative
// Rasterization", 2005, whose second algorithm bounds by a rectangle as well.)
// needs frame.wgsl page_table.wgsl page_request.wgsl page_marks.wgsl texture_map.wgsl, and map_triangle and
// triangle_in_range of one kind of triangles

// Where back faces are dropped: BY_COMPUTE, in a pass before; BY_VERTEX, when their rectangle is placed; BY_FRAGMENT,
// in every cell.
override BACK_FACES: u32 = 0u;
const BY_COMPUTE: u32 = 0u;
const BY_VERTEX: u32 = 1u;

struct IndirectDraw {
    vertex_count: u32,
    instance_count: atomic<u32>,
    first_vertex: u32,
    first_instance: u32,
}

// Triangles that face the eye and lie in the picture.
@group(1) @binding(2) var<storage, read_write> kept: array<u32>;
@group(1) @binding(3) var<storage, read_write> kept_draw: IndirectDraw;

@compute @workgroup_size(64)
fn keep_triangles(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    if all(group.xy == vec2<u32>(0u)) && lane == 0u {
        kept_draw.vertex_count = 6u;
    }
    let number = triangle_in_range(group.x * 64u + lane, group.y);
    if number == NO_TRIANGLE {
        return;
    }
    let t = map_triangle(number);
    if !faces_eye(t) || is_out_of_picture(clip_of(t.a.relative_m), clip_of(t.b.relative_m), clip_of(t.c.relative_m)) {
        return;
    }
    kept[atomicAdd(&kept_draw.instance_count, 1u)] = number;
}

struct MapVertex {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(flat) number: u32,
    @location(1) @interpolate(flat) mip: u32,
}

// One of the six corners of the two triangles that make up the rectangle of a triangle's cells.
fn rectangle_corner(number: u32, vertex: u32) -> MapVertex {
    let nowhere = MapVertex(vec4<f32>(0.0, 0.0, 0.0, 1.0), number, 0u);
    let t = map_triangle(number);
    if BACK_FACES == BY_VERTEX {
        if !faces_eye(t) { return nowhere; }
    }
    let laid = lay(t);
    if !laid.is_in_picture {
        return nowhere;
    }
    let corners = array<u32, 6>(0u, 1u, 2u, 2u, 1u, 3u);
    let corner = corners[vertex];
    let is_last = vec2<bool>((corner & 1u) != 0u, (corner & 2u) != 0u);
    let cell = select(laid.first, laid.last + 1u, is_last);
    let place = vec2<f32>(cell) / vec2<f32>(map.cells) * 2.0 - 1.0;
    return MapVertex(vec4<f32>(place.x, -place.y, 0.0, 1.0), number, laid.mip);
}

@vertex
fn map_kept(@builtin(vertex_index) vertex: u32, @location(0) number: u32) -> MapVertex {
    return rectangle_corner(number, vertex);
}

@vertex
fn map_all(@builtin(vertex_index) vertex: u32, @builtin(instance_index) number: u32) -> MapVertex {
    return rectangle_corner(number, vertex);
}

// Bits of the steps from one to another of a level, as `PageRequest` has them.
fn step_bits(first_step: i32, last_step: i32, level: i32) -> u32 {
    let first = u32(first_step - level * STEPS + STEPS_BELOW);
    let count = u32(last_step - first_step + 1);
    return ((1u << count) - 1u) << first;
}

@fragment
fn mark_cell(in: MapVertex) -> @location(0) vec4<f32> {
    let cell = vec2<u32>(in.clip.xy);
    let t = map_triangle(in.number);
    if BACK_FACES != BY_COMPUTE && BACK_FACES != BY_VERTEX {
        if !faces_eye(t) { return vec4<f32>(0.0); }
    }
    let around = corner_rect(t);
    let of_cell = rect_of_cell(t, cell, in.mip);
    if !reaches_into(t, of_cell) {
        return vec4<f32>(0.0);
    }
    var rect = around;
    if !t.is_scattered {
        rect = TexelRect(max(around.low, of_cell.low), min(around.high, of_cell.high));
    }
    let whole = bounds_of(clip_of(t.a.relative_m), clip_of(t.b.relative_m), clip_of(t.c.relative_m));
    let bounds = bounds_in(t, whole, rect);
    if !may_show(bounds) {
        return vec4<f32>(0.0);
    }
    let field = footprint_field(t, 0.5 * (around.low + around.high));
    let levels = (level_bounds(field, bounds, rect) + pages.request_bias) * f32(STEPS);
    let coarsest_asked = min(f32(pages.first_resident_level), t.coarsest_level + 1.0 + pages.request_bias);
    let coarsest_step = i32(ceil(coarsest_asked * f32(STEPS))) - 1;
    // The mip was chosen no coarser than the finest level of all the triangle.
    let least = max(i32(in.mip) * STEPS, -STEPS_BELOW) - select(0, STEPS_BELOW, in.mip == 0u);
    let finest = clamp(floor(levels.x), f32(least), f32(coarsest_step) + 1.0);
    let coarsest = clamp(floor(levels.y), finest, f32(coarsest_step));
    let finest_cell_page = min(cell >> vec2<u32>(map.cells_per_page_log2), vec2<u32>(pages.columns - 1u, pages.rows - 1u) >> vec2<u32>(in.mip));
    var step = i32(finest);
    loop {
        if step > i32(coarsest) { break; }
        let level = max(step, 0) / STEPS;
        let last = min(i32(coarsest), level * STEPS + STEPS - 1);
        mark_page(u32(level), finest_cell_page >> vec2<u32>(u32(level) - in.mip), step_bits(step, last, level));
        step = last + 1;
    }
    return vec4<f32>(1.0);
}
