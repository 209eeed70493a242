// The ground last seen, as it lies in its buffer: eight words, then a table of the tiles that pixels
// saw.

// The box: floats turned so that they order as whole numbers do, and so that each is the largest of its
// kind: the western border is that of the largest way west. A cleared buffer has seen nothing.
const SEEN_WEST: u32 = 0u;
const SEEN_SOUTH: u32 = 1u;
const SEEN_EAST: u32 = 2u;
const SEEN_NORTH: u32 = 3u;
const SEEN_PIXELS: u32 = 4u;
// Tiles in the table, and whether there were more than it is to hold.
const SEEN_TILES: u32 = 5u;
const SEEN_OVERFLOW: u32 = 6u;
const SEEN_HEADER: u32 = 8u;

const TABLE_BITS: u32 = 16u;
// Half of the table.
const MOST_SEEN_TILES: u32 = 32768u;
// Tiles are told by where they lie from the eye's, up to so many rows and columns away.
const KEY_REACH: i32 = 4096;

fn ordered(value: f32) -> u32 {
    let bits = bitcast<u32>(value + 0.0);
    return bits ^ select(0x80000000u, 0xffffffffu, bits >> 31u == 1u);
}

fn from_ordered(word: u32) -> f32 {
    return bitcast<f32>(word ^ select(0xffffffffu, 0x80000000u, word >> 31u == 1u));
}

// The word a tile of level 1 or finer has in the table; 0 where it is too far from the eye.
fn tile_key(level: u32, row: u32, column: u32, eye_ground: vec2<i32>) -> u32 {
    let place = vec2<i32>(i32(column), i32(row)) - (eye_ground >> vec2<u32>(30u - level)) + KEY_REACH;
    if any(place < vec2<i32>(0)) || any(place >= vec2<i32>(2 * KEY_REACH)) {
        return 0u;
    }
    return (level << 26u) | (u32(place.y) << 13u) | u32(place.x);
}

// Where the search for a key begins.
fn first_slot(key: u32) -> u32 {
    return (key * 2654435769u) >> (32u - TABLE_BITS);
}

fn next_slot(slot: u32) -> u32 {
    return (slot + 1u) & ((1u << TABLE_BITS) - 1u);
}
