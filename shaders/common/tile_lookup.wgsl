// Which cached tile holds a point: the finest one. Two ways with the same answer:
// the paper's linear search through the table (sorted finest first), and a descent of the
// quadtree over the cached tiles, which costs one load a level.

// Where a tile lies, on the ground and in its atlas: all that sampling it takes. Both are told from one
// of its texels: the first for imagery, for heights one near the eye, since places near it are then
// small and exact.
struct TilePlace {
    // The texel's north-west corner relative to the eye, metres east and north.
    origin_from_eye_m: vec2<f32>,
    texels_per_m: f32,
    // The texel in the atlas: column, and row << 16.
    atlas_texel: u32,
}

struct TileEntry {
    place: TilePlace,
    level: u32,
    column: u32,
    row: u32,
    padding: u32,
}

@group(1) @binding(0) var<storage, read> tile_entries: array<TileEntry>;
@group(1) @binding(1) var<storage, read> tile_nodes: array<u32>;

override LINEAR_LOOKUP: bool = false;

const FIXED_BITS: u32 = 30u;
const FIXED_UNITS: i32 = 1073741824; // 2^30 a root side

// Fixed-point position (x east, y south) of a point given in metres east and north of the eye.
// Points outside the root are taken to its border. Rounded down: a unit of a planet's root is several
// texels of its finest level, and rounding to nearest would look for a point up to half a unit short of
// a border in the tile beyond it.
fn fixed_from_offset(offset_m: vec2<f32>) -> vec2<i32> {
    let from_anchor_m = offset_m - frame.anchor_from_eye_m;
    let units = vec2<f32>(from_anchor_m.x, -from_anchor_m.y) * frame.units_per_m;
    let reach = vec2<f32>(f32(FIXED_UNITS));
    let offset_units = vec2<i32>(floor(clamp(units, -reach, reach)));
    return clamp(frame.anchor_fixed + offset_units, vec2<i32>(0), vec2<i32>(FIXED_UNITS - 1));
}

fn find_tile_linear(table: TableRange, position: vec2<i32>) -> u32 {
    let place = vec2<u32>(position);
    for (var i = 0u; i < table.entry_count; i++) {
        let index = table.first_entry + i;
        let shift = FIXED_BITS - tile_entries[index].level;
        if (place.x >> shift) == tile_entries[index].column && (place.y >> shift) == tile_entries[index].row {
            return index;
        }
    }
    // Level 0 is always resident and sorted last.
    return table.first_entry + table.entry_count - 1u;
}

struct FoundTile {
    // Index of the tile's entry.
    entry: u32,
    // Index of the word the descent ended at. Its square of ground shows this one tile as a whole:
    // nothing finer is cached anywhere in it.
    cell: u32,
}

// A node is four words (north-west, north-east, south-west, south-east). The low half of a word is
// the child's own node, 0 where nothing finer is cached; the high half is its entry plus one, 0
// where the child itself is not cached.
fn descend(table: TableRange, position: vec2<i32>) -> FoundTile {
    let place = vec2<u32>(position);
    var word = table.root_word;
    var entry = word >> 16u;
    var shift = FIXED_BITS;
    var node = 0u;
    var cell = 0u;
    loop {
        shift -= 1u;
        let quadrant = ((place.y >> shift) & 1u) * 2u + ((place.x >> shift) & 1u);
        cell = table.first_node + node * 4u + quadrant;
        word = tile_nodes[cell];
        entry = select(entry, word >> 16u, (word >> 16u) != 0u);
        node = word & 0xffffu;
        if node == 0u || shift == 0u { break; }
    }
    return FoundTile(table.first_entry + entry - 1u, cell);
}

fn find_tile(table: TableRange, position: vec2<i32>) -> u32 {
    if LINEAR_LOOKUP {
        return find_tile_linear(table, position);
    }
    return descend(table, position).entry;
}

fn atlas_texel(tile: TilePlace) -> vec2<u32> {
    return vec2<u32>(tile.atlas_texel & 0xffffu, tile.atlas_texel >> 16u);
}

// The texel that a tile is told from, counted from the first of the tile proper (inside its gutter).
fn told_from_texel(tile: TilePlace, tile_texels: f32, gutter_texels: f32) -> vec2<f32> {
    let stored_texels = tile_texels + 2.0 * gutter_texels;
    let at = vec2<f32>(vec2<i32>(atlas_texel(tile)));
    return at - floor(at / stored_texels) * stored_texels - gutter_texels;
}

// Where in its atlas a place in the tile (texels of level 0) lies, in parts of the atlas's sides.
fn atlas_uv(tile: TilePlace, place: vec2<f32>, uv_per_texel: vec2<f32>) -> vec2<f32> {
    return (vec2<f32>(vec2<i32>(atlas_texel(tile))) + place) * uv_per_texel;
}

// Place of a point in its tile, in texels east and south of where the tile is told from.
// Formula (3) of the tile-scheduling paper, in texels.
fn texel_in_tile(tile: TilePlace, offset_m: vec2<f32>) -> vec2<f32> {
    let from_origin_m = offset_m - tile.origin_from_eye_m;
    return vec2<f32>(from_origin_m.x, -from_origin_m.y) * tile.texels_per_m;
}
