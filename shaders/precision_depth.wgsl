// A grid of cells, each with two squares one behind the other: whether the depth test tells them apart.
// Columns are distances, rows are gaps between the squares.

struct Projection {
    clip_from_relative: mat4x4<f32>,
    // Half the picture's width and height at distance 1.
    half_size: vec2<f32>,
    // Columns and rows of the grid.
    cells: vec2<u32>,
}

@group(0) @binding(0) var<uniform> projection: Projection;
// Distance of the nearer square of each column, and of the farther one of each cell, row by row.
@group(0) @binding(1) var<storage, read> distances_m: array<f32>;

struct Corner {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(flat) is_nearer: u32,
}

// The first instance of each cell is the farther square, drawn first where nearer ones come last.
@vertex
fn square(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> Corner {
    let count = projection.cells.x * projection.cells.y;
    let is_nearer = instance / count;
    let cell = instance % count;
    let at = vec2<u32>(cell % projection.cells.x, cell / projection.cells.x);
    let corner = vec2<f32>(vec2<u32>(vertex & 1u, vertex >> 1u) + at) / vec2<f32>(projection.cells);
    let on_picture = (2.0 * corner - 1.0) * projection.half_size;
    let distance_m = select(distances_m[projection.cells.x + cell], distances_m[at.x], is_nearer == 1u);
    // The camera looks north.
    let relative_m = vec3<f32>(on_picture.x * distance_m, distance_m, on_picture.y * distance_m);
    return Corner(projection.clip_from_relative * vec4<f32>(relative_m, 1.0), is_nearer);
}

@fragment
fn mark(in: Corner) -> @location(0) vec4<f32> {
    return vec4<f32>(f32(in.is_nearer));
}
