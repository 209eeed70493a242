// A mesh as compute passes read and write it.

// Where a block's vertices and indices begin, and how many there are.
struct MeshBlock {
    vertex_start: u32,
    vertex_count: u32,
    index_start: u32,
    index_count: u32,
}

struct DisplacedVertex {
    // The cached tiles that hold the vertex.
    height_tile: TilePlace,
    colour_tile: TilePlace,
    // The cells the lookups of both layers ended at, or NO_CELL: a triangle whose vertices share
    // them lies within its tiles as a whole.
    cells: vec2<u32>,
    // Metres east, north and up from the eye.
    x: f32,
    y: f32,
    z: f32,
}

const NO_CELL: u32 = 0xffffffffu;
