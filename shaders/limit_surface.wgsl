// Casts rays on a limit-triangulated surface and colours them: from the triangles' own colours over
// distance, or by the texture unit's filters. The walk over the grid is that of the CPU's caster, in
// f32 and relative to the cell under the eye.

struct LimitUniforms {
    // Direction through the picture's top left corner, and its change by a pixel right and down: x in
    // cells to the east, y in cells to the south, z in metres.
    ray_corner: vec3<f32>,
    cell_m: f32,
    ray_per_column: vec3<f32>,
    lowest_m: f32,
    ray_per_row: vec3<f32>,
    highest_m: f32,
    // The eye within its cell, and metres above the base that heights are relative to.
    eye: vec3<f32>,
    // Angle in radians that a ray stands for.
    ray_angle: f32,
    background: vec3<f32>,
    rays: u32,
    // Column and row of the eye's cell, which may lie beyond the grid.
    eye_cell: vec2<i32>,
    grid_size: vec2<i32>,
    // From cells relative to the eye's to the texture: uv = (cells + uv_origin) * uv_per_cell.
    uv_origin: vec2<f32>,
    uv_per_cell: vec2<f32>,
    size_px: vec2<u32>,
    texel_m: f32,
    top_level: u32,
    // Where each level of the ranges starts, and its columns.
    levels: array<vec4<u32>, 32>,
}

struct CastPixel {
    linear: vec3<f32>,
    // What the first ray met, and how far away; NO_TRIANGLE where nothing.
    triangle: u32,
    distance_m: f32,
    hits: u32,
    words: u32,
    places: u32,
}

struct Hit {
    triangle: u32,
    distance_m: f32,
}

struct ColourRead {
    linear: vec3<f32>,
    words: u32,
    places: u32,
}

@group(0) @binding(0) var<uniform> setup: LimitUniforms;
@group(0) @binding(1) var<storage, read> heights_m: array<f32>;
@group(0) @binding(2) var<storage, read> ranges_m: array<vec2<f32>>;
@group(0) @binding(3) var<storage, read> triangle_words: array<u32>;
@group(0) @binding(4) var<storage, read> knots: array<u32>;
@group(0) @binding(5) var<storage, read> distances_m: array<f32>;
@group(0) @binding(6) var<storage, read> places_px: array<vec2<f32>>;
@group(0) @binding(7) var<storage, read_write> pixels: array<CastPixel>;
@group(0) @binding(8) var imagery: texture_2d<f32>;
@group(0) @binding(9) var trilinear_sampler: sampler;
@group(0) @binding(10) var anisotropic_sampler: sampler;

const NO_TRIANGLE: u32 = 0xffffffffu;
const IS_RUN: u32 = 0x80000000u;
const ABSENT: u32 = 0x40000000u;
const IS_LAST: u32 = 0x80000000u;
const INFINITY_M: f32 = 3.0e38;
// Which side of the surface a ray is on.
const UNKNOWN: i32 = 0;
const ABOVE: i32 = 1;
const BELOW: i32 = -1;

// 0: the triangles' colours, 1: trilinear, 2: anisotropic.
override METHOD: u32 = 0u;

fn node_height_m(cell: vec2<i32>) -> f32 {
    return heights_m[u32(cell.y) * u32(setup.grid_size.x + 1) + u32(cell.x)];
}

// NaN marks nodes without heights; arithmetic that may assume there is none must not see it.
fn is_void(height_m: f32) -> bool {
    return (bitcast<u32>(height_m) & 0x7fffffffu) > 0x7f800000u;
}

fn side_of(above_m: f32) -> i32 {
    return select(BELOW, ABOVE, above_m > 0.0);
}

// Corners of a cell's half as the height at its north-western node and the rise to east and south;
// the last part is 0 in a void.
fn plane_of_half(cell: vec2<i32>, half: u32) -> vec4<f32> {
    let north_west = node_height_m(cell);
    let south_east = node_height_m(cell + vec2<i32>(1, 1));
    let other = node_height_m(cell + select(vec2<i32>(0, 1), vec2<i32>(1, 0), half == 0u));
    if is_void(north_west) || is_void(south_east) || is_void(other) {
        return vec4<f32>(0.0);
    }
    if half == 0u {
        return vec4<f32>(north_west, other - north_west, south_east - other, 1.0);
    }
    return vec4<f32>(north_west, south_east - other, other - north_west, 1.0);
}

// Where the ray enters and leaves the box that holds the surface; empty (x > y) where it does not.
fn range_in_box(ray: vec3<f32>) -> vec2<f32> {
    let low = vec3<f32>(vec2<f32>(-setup.eye_cell), setup.lowest_m - 1.0);
    let high = vec3<f32>(vec2<f32>(setup.grid_size - setup.eye_cell), setup.highest_m + 1.0);
    var span = vec2<f32>(0.0, INFINITY_M);
    for (var axis = 0; axis < 3; axis++) {
        if ray[axis] == 0.0 {
            if setup.eye[axis] < low[axis] || setup.eye[axis] > high[axis] {
                return vec2<f32>(1.0, 0.0);
            }
            continue;
        }
        let a = (low[axis] - setup.eye[axis]) / ray[axis];
        let b = (high[axis] - setup.eye[axis]) / ray[axis];
        span = vec2<f32>(max(span.x, min(a, b)), min(span.y, max(a, b)));
    }
    return span;
}

// The half of a cell in which the ray is at a distance.
fn half_at(ray: vec3<f32>, cell: vec2<i32>, t: f32) -> u32 {
    let place = setup.eye.xy + ray.xy * t - vec2<f32>(cell - setup.eye_cell);
    return select(1u, 0u, place.x >= place.y);
}

// Height of the ray above the plane of a half.
fn above_half_m(ray: vec3<f32>, cell: vec2<i32>, plane: vec4<f32>, t: f32) -> f32 {
    let point = setup.eye + ray * t;
    let place = point.xy - vec2<f32>(cell - setup.eye_cell);
    return point.z - (plane.x + place.x * plane.y + place.y * plane.z);
}

fn meet_half(ray: vec3<f32>, cell: vec2<i32>, half: u32, from_m: f32, to_m: f32, side: ptr<function, i32>) -> Hit {
    let plane = plane_of_half(cell, half);
    if plane.w == 0.0 {
        *side = UNKNOWN;
        return Hit(NO_TRIANGLE, 0.0);
    }
    let start = above_half_m(ray, cell, plane, from_m);
    let end = above_half_m(ray, cell, plane, to_m);
    let triangle = 2u * u32(cell.y * setup.grid_size.x + cell.x) + half;
    let before = *side;
    *side = side_of(start);
    if before != UNKNOWN && before != *side {
        return Hit(triangle, from_m);
    }
    if *side != side_of(end) {
        return Hit(triangle, from_m + (to_m - from_m) * (start / (start - end)));
    }
    return Hit(NO_TRIANGLE, 0.0);
}

fn meet_cell(ray: vec3<f32>, cell: vec2<i32>, from_m: f32, to_m: f32, side: ptr<function, i32>) -> Hit {
    let start = setup.eye.xy - vec2<f32>(cell - setup.eye_cell);
    let closing = ray.x - ray.y;
    let diagonal_m = select(INFINITY_M, (start.y - start.x) / closing, closing != 0.0);
    if diagonal_m > from_m && diagonal_m < to_m {
        let first = meet_half(ray, cell, half_at(ray, cell, 0.5 * (from_m + diagonal_m)), from_m, diagonal_m, side);
        if first.triangle != NO_TRIANGLE {
            return first;
        }
        return meet_half(ray, cell, half_at(ray, cell, 0.5 * (diagonal_m + to_m)), diagonal_m, to_m, side);
    }
    return meet_half(ray, cell, half_at(ray, cell, 0.5 * (from_m + to_m)), from_m, to_m, side);
}

// Whether the ray passes over or under everything in a block without changing sides.
fn passes_block(ray: vec3<f32>, cell: vec2<i32>, level: u32, from_m: f32, to_m: f32, side: ptr<function, i32>) -> bool {
    let stored = setup.levels[level - 1u];
    let block = vec2<u32>(cell) >> vec2<u32>(level);
    let range = ranges_m[stored.x + block.y * stored.y + block.x];
    if range.x > range.y {
        *side = UNKNOWN;
        return true;
    }
    let a = setup.eye.z + ray.z * from_m;
    let b = setup.eye.z + ray.z * to_m;
    var passed = UNKNOWN;
    if min(a, b) > range.y {
        passed = ABOVE;
    } else if max(a, b) < range.x {
        passed = BELOW;
    }
    if passed == UNKNOWN || (*side != UNKNOWN && *side != passed) {
        return false;
    }
    *side = passed;
    return true;
}

fn border_m(ray: vec3<f32>, cell: vec2<i32>, level: u32, axis: i32) -> f32 {
    let direction = ray[axis];
    if direction == 0.0 {
        return INFINITY_M;
    }
    let block = (cell[axis] >> level) + select(0, 1, direction > 0.0);
    return (f32((block << level) - setup.eye_cell[axis]) - setup.eye[axis]) / direction;
}

fn first_hit(ray: vec3<f32>) -> Hit {
    let span = range_in_box(ray);
    if !(span.x < span.y && span.y < INFINITY_M) {
        return Hit(NO_TRIANGLE, 0.0);
    }
    var from_m = span.x;
    var level = setup.top_level;
    var side = UNKNOWN;
    let entry = vec2<i32>(floor(setup.eye.xy + ray.xy * from_m)) + setup.eye_cell;
    var cell = clamp(entry, vec2<i32>(0), setup.grid_size - 1);
    loop {
        let x_m = border_m(ray, cell, level, 0);
        let y_m = border_m(ray, cell, level, 1);
        let axis = select(1, 0, x_m <= y_m);
        let to_m = clamp(min(x_m, y_m), from_m, span.y);
        if level > 0u && !passes_block(ray, cell, level, from_m, to_m, &side) {
            level -= 1u;
            continue;
        }
        if level == 0u {
            let hit = meet_cell(ray, cell, from_m, to_m, &side);
            if hit.triangle != NO_TRIANGLE {
                return hit;
            }
        }
        if to_m >= span.y {
            break;
        }
        let block = cell[axis] >> level;
        let next = select((block << level) - 1, (block + 1) << level, ray[axis] > 0.0);
        if next < 0 || next >= setup.grid_size[axis] {
            break;
        }
        let other = 1 - axis;
        let first = (cell[other] >> level) << level;
        let last = min(first + (1 << level) - 1, setup.grid_size[other] - 1);
        let crossing = i32(floor(setup.eye[other] + ray[other] * to_m)) + setup.eye_cell[other];
        let along = clamp(crossing, first, last);
        cell = select(vec2<i32>(along, next), vec2<i32>(next, along), axis == 0);
        from_m = to_m;
        if level < setup.top_level && ((next >> level) >> 1u) != (block >> 1u) {
            level += 1u;
        }
    }
    return Hit(NO_TRIANGLE, 0.0);
}

fn linear_of(word: u32) -> vec3<f32> {
    let codes = vec3<f32>(vec3<u32>(word, word >> 8u, word >> 16u) & vec3<u32>(0xffu)) / 255.0;
    let bright = pow((codes + 0.055) / 1.055, vec3<f32>(2.4));
    return select(bright, codes / 12.92, codes <= vec3<f32>(0.04045));
}

// Formula (4) between the two knots around the distance.
fn triangle_colour(triangle: u32, distance_m: f32) -> ColourRead {
    let word = triangle_words[triangle];
    if word == ABSENT {
        return ColourRead(setup.background, 1u, 1u);
    }
    if (word & IS_RUN) == 0u {
        return ColourRead(linear_of(word), 1u, 1u);
    }
    var index = word & ~IS_RUN;
    var near = knots[index];
    var words = 2u;
    if distance_m < distances_m[(near >> 24u) & 0x7fu] {
        return ColourRead(linear_of(near), words, 2u);
    }
    while (near & IS_LAST) == 0u {
        index += 1u;
        words += 1u;
        let far = knots[index];
        let far_m = distances_m[(far >> 24u) & 0x7fu];
        if distance_m < far_m {
            let near_m = distances_m[(near >> 24u) & 0x7fu];
            let part = (distance_m - near_m) / (far_m - near_m);
            return ColourRead(mix(linear_of(near), linear_of(far), part), words, 2u);
        }
        near = far;
    }
    return ColourRead(linear_of(near), words, 2u);
}

// The two sides of the ray's footprint on the triangle's plane, seen from above, in metres to the east
// and to the south.
fn footprint_sides(ray: vec3<f32>, hit: Hit) -> mat2x2<f32> {
    let cell_index = i32(hit.triangle / 2u);
    let cell = vec2<i32>(cell_index % setup.grid_size.x, cell_index / setup.grid_size.x);
    let plane = plane_of_half(cell, hit.triangle % 2u);
    let normal = normalize(vec3<f32>(-plane.y / setup.cell_m, -plane.z / setup.cell_m, 1.0));
    let direction = vec3<f32>(ray.xy * setup.cell_m, ray.z);
    let crossed = cross(direction, normal);
    let across = select(vec3<f32>(1.0, 0.0, 0.0), normalize(crossed), length(crossed) > 1.0e-6);
    let along = cross(across, normal);
    let width_m = hit.distance_m * setup.ray_angle;
    let stretch = min(1.0 / abs(dot(direction, normal)), 1.0e3);
    return mat2x2<f32>(across.xy * width_m, along.xy * (width_m * stretch));
}

fn texture_colour(ray: vec3<f32>, hit: Hit) -> ColourRead {
    let point = setup.eye.xy + ray.xy * hit.distance_m;
    let uv = (point + setup.uv_origin) * setup.uv_per_cell;
    let sides = footprint_sides(ray, hit);
    let longest_m = max(length(sides[0]), length(sides[1]));
    if METHOD == 1u {
        let lod = log2(longest_m / setup.texel_m);
        let sample = textureSampleLevel(imagery, trilinear_sampler, uv, lod);
        let is_magnified = lod <= 0.0;
        return ColourRead(sample.rgb, select(8u, 4u, is_magnified), select(4u, 2u, is_magnified));
    }
    let per_m = setup.uv_per_cell / setup.cell_m;
    let sample = textureSampleGrad(imagery, anisotropic_sampler, uv, sides[0] * per_m, sides[1] * per_m);
    let shortest_m = max(min(length(sides[0]), length(sides[1])), 1.0e-3 * longest_m);
    let taps = u32(clamp(ceil(longest_m / shortest_m), 1.0, 16.0));
    return ColourRead(sample.rgb, 8u * taps, 4u * taps);
}

@compute @workgroup_size(8, 8)
fn cast_rays(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= setup.size_px) {
        return;
    }
    var pixel = CastPixel(vec3<f32>(0.0), NO_TRIANGLE, 0.0, 0u, 0u, 0u);
    for (var index = 0u; index < setup.rays; index++) {
        let at = vec2<f32>(id.xy) + places_px[index];
        let unscaled = setup.ray_corner + setup.ray_per_column * at.x + setup.ray_per_row * at.y;
        let length_m = length(vec3<f32>(unscaled.xy * setup.cell_m, unscaled.z));
        let ray = unscaled / length_m;
        let hit = first_hit(ray);
        if index == 0u {
            pixel.triangle = hit.triangle;
            pixel.distance_m = hit.distance_m;
        }
        if hit.triangle == NO_TRIANGLE {
            pixel.linear += setup.background;
            continue;
        }
        var read = ColourRead(vec3<f32>(0.0), 0u, 0u);
        if METHOD == 0u {
            read = triangle_colour(hit.triangle, hit.distance_m);
        } else {
            read = texture_colour(ray, hit);
        }
        pixel.linear += read.linear;
        pixel.hits += 1u;
        pixel.words += read.words;
        pixel.places += read.places;
    }
    pixel.linear /= f32(setup.rays);
    pixels[id.y * setup.size_px.x + id.x] = pixel;
}
