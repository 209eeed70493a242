// Models as triangles for the texture map.
// needs: common/frame.wgsl common/page_table.wgsl common/page_request.wgsl common/page_marks.wgsl common/object.wgsl common/texture_map.wgsl common/map_triangles.wgsl

// The triangles of an instance. Numbers of triangles count over all of them.
struct ObjectRange {
    first_number: u32,
    triangles: u32,
    first_index: u32,
    base_vertex: u32,
    instance: u32,
    // So many show their front alone, those after them both sides.
    single_sided: u32,
}

// Words as object.wgsl explains them.
@group(3) @binding(1) var<storage, read> object_vertices: array<f32>;
@group(3) @binding(2) var<storage, read> object_indices: array<u32>;
@group(3) @binding(3) var<storage, read> object_instances: array<vec4<f32>>;
@group(3) @binding(4) var<storage, read> object_ranges: array<ObjectRange>;

const WORDS_A_VERTEX: u32 = 9u;

fn triangle_in_range(place: u32, range: u32) -> u32 {
    let found = object_ranges[range];
    return select(NO_TRIANGLE, found.first_number + place, place < found.triangles);
}

fn range_of(number: u32) -> ObjectRange {
    var first = 0u;
    var end = map.ranges;
    while end - first > 1u {
        let middle = (first + end) / 2u;
        if object_ranges[middle].first_number <= number { first = middle; } else { end = middle; }
    }
    return object_ranges[first];
}

struct StoredCorner {
    relative_m: vec3<f32>,
    uv: vec2<f32>,
    material: u32,
}

fn stored_corner(range: ObjectRange, index: u32) -> StoredCorner {
    let word = (range.base_vertex + object_indices[range.first_index + index]) * WORDS_A_VERTEX;
    let local = vec4<f32>(object_vertices[word], object_vertices[word + 1u], object_vertices[word + 2u], 1.0);
    let rows = range.instance * 3u;
    let relative_m = vec3<f32>(
        dot(object_instances[rows], local),
        dot(object_instances[rows + 1u], local),
        dot(object_instances[rows + 2u], local),
    );
    let uv = vec2<f32>(object_vertices[word + 6u], object_vertices[word + 7u]);
    return StoredCorner(relative_m, uv, bitcast<u32>(object_vertices[word + 8u]));
}

// Texture coordinates of a triangle brought into the image as the wrap mode says, where one turn of it holds them all.
struct Unwrapped {
    a: f32,
    b: f32,
    c: f32,
    is_inside: bool,
}

fn unwrapped(a: f32, b: f32, c: f32, mode: u32) -> Unwrapped {
    let low = min(a, min(b, c));
    let high = max(a, max(b, c));
    let turn = select(floor(low), 0.0, mode == WRAP_CLAMP);
    let is_inside = low >= turn && high <= turn + 1.0;
    if mode == WRAP_MIRROR && fract(0.5 * turn) > 0.25 {
        return Unwrapped(turn + 1.0 - a, turn + 1.0 - b, turn + 1.0 - c, is_inside);
    }
    return Unwrapped(a - turn, b - turn, c - turn, is_inside);
}

fn map_triangle(number: u32) -> MapTriangle {
    let range = range_of(number);
    let place = number - range.first_number;
    let a = stored_corner(range, 3u * place);
    let b = stored_corner(range, 3u * place + 1u);
    let c = stored_corner(range, 3u * place + 2u);
    let material = object_materials[a.material];
    let u = unwrapped(a.uv.x, b.uv.x, c.uv.x, material.wrap.x);
    let v = unwrapped(a.uv.y, b.uv.y, c.uv.y, material.wrap.y);
    let size = material.size_texels;
    return MapTriangle(
        material.first_texel,
        MapCorner(a.relative_m, vec2<f32>(u.a, v.a) * size),
        MapCorner(b.relative_m, vec2<f32>(u.b, v.b) * size),
        MapCorner(c.relative_m, vec2<f32>(u.c, v.c) * size),
        // Across a turn's end all of the image counts as seen.
        !(u.is_inside && v.is_inside),
        size,
        material.coarsest_level,
        place >= range.single_sided,
    );
}
