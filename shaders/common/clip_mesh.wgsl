// The vertices of a clipmap's rings. Every block is the same patch of vertices; those beyond its own
// size fall on its border, where their triangles shrink to nothing.

struct ClipBlock {
    @location(0) corner: vec2<i32>,
    // Cells from west to east in the low half, from north to south in the high.
    @location(1) cells: u32,
    @location(2) ring_and_flags: u32,
}

const WEST: u32 = 256u;
const NORTH: u32 = 512u;
const EAST: u32 = 1024u;
const SOUTH: u32 = 2048u;
const ODD_COLUMN: u32 = 4096u;
const ODD_ROW: u32 = 8192u;
const OUTERMOST: u32 = 16384u;

// Part of a ring's side over which it takes on the shape of the next one (Losasso and Hoppe, 2004).
const BLEND_PART: f32 = 0.1;

fn has(block: ClipBlock, flag: u32) -> bool {
    return (block.ring_and_flags & flag) != 0u;
}

// A grid point, units east and south of the reference, in metres east and north of the eye.
fn grid_offset_m(units: vec2<i32>) -> vec2<f32> {
    let from_reference = vec2<f32>(f32(units.x), f32(-units.y)) * clip.unit_m;
    return clip.reference_from_eye_m + from_reference;
}

// Height of the ground above the eye at a grid point as a ring has it. Beyond the data the mesh folds
// onto its border.
fn ring_height_m(units: vec2<i32>, ring: u32) -> f32 {
    let offset_m = clamp(grid_offset_m(units), frame.data_min_from_eye_m, frame.data_max_from_eye_m);
    return ground_above_eye_m(offset_m, clip.mesh_level - f32(ring));
}

struct RingVertex {
    // Units east and south of the reference.
    units: vec2<i32>,
    // The ring whose vertex it is: the next one on the outer border, which is that ring's inner one.
    ring: u32,
    // 1 for each axis in which it stands between two vertices of the next ring.
    between: vec2<i32>,
    // Part of the next ring's shape that it takes on.
    blend: f32,
}

fn ring_vertex(index: u32, block: ClipBlock) -> RingVertex {
    let size = vec2<i32>(i32(block.cells & 0xffffu), i32(block.cells >> 16u));
    let row = index / clip.patch_columns;
    var cell = min(vec2<i32>(i32(index - row * clip.patch_columns), i32(row)), size);
    let ring = block.ring_and_flags & 0xffu;
    let first = vec2<i32>(i32(has(block, ODD_COLUMN)), i32(has(block, ODD_ROW)));
    let between = (cell + first) & vec2<i32>(1);
    let on_column = (has(block, WEST) && cell.x == 0) || (has(block, EAST) && cell.x == size.x);
    let on_row = (has(block, NORTH) && cell.y == 0) || (has(block, SOUTH) && cell.y == size.y);
    if !has(block, OUTERMOST) && (on_column || on_row) {
        // Onto a vertex of the next ring: both rings then have the same edges.
        cell -= between * vec2<i32>(i32(on_row), i32(on_column));
        return RingVertex(block.corner + (cell << vec2<u32>(ring)), ring + 1u, vec2<i32>(0), 0.0);
    }
    let units = block.corner + (cell << vec2<u32>(ring));
    let from_eye = abs(grid_offset_m(units)) / (clip.unit_m * exp2(f32(ring)));
    // The eye is within a cell of the ring's middle: all of the border is reached by then.
    let width = clip.ring_cells * BLEND_PART;
    let to_border = 0.5 * clip.ring_cells - 1.0 - max(from_eye.x, from_eye.y);
    let blend = select(clamp(1.0 - to_border / width, 0.0, 1.0), 0.0, has(block, OUTERMOST));
    return RingVertex(units, ring, between, blend);
}

// A vertex in metres east, north and up from the eye.
fn ring_place_m(index: u32, block: ClipBlock) -> vec3<f32> {
    let vertex = ring_vertex(index, block);
    var z = ring_height_m(vertex.units, vertex.ring);
    if vertex.blend > 0.0 {
        // The next ring's surface here: the middle of one of its edges, or a vertex of it.
        let apart = vertex.between << vec2<u32>(vertex.ring);
        let before = ring_height_m(vertex.units - apart, vertex.ring + 1u);
        let after = ring_height_m(vertex.units + apart, vertex.ring + 1u);
        z += (0.5 * (before + after) - z) * vertex.blend;
    }
    let place_m = clamp(grid_offset_m(vertex.units), frame.data_min_from_eye_m, frame.data_max_from_eye_m);
    return vec3<f32>(place_m, z);
}
