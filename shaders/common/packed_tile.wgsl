// A tile and the slot it has or is to get in two words: what crosses the bus about tiles.
// The first word holds the level (5 bits), the slot (11) and the low half of the column, the second
// the row (24 bits) and the rest of the column.

struct TileInSlot {
    level: u32,
    row: u32,
    column: u32,
    slot: u32,
}

fn pack_tile(tile: TileInSlot) -> vec2<u32> {
    let low = tile.level | (tile.slot << 5u) | (tile.column << 16u);
    return vec2<u32>(low, tile.row | ((tile.column >> 16u) << 24u));
}

fn unpack_tile(words: vec2<u32>) -> TileInSlot {
    let column = (words.x >> 16u) | ((words.y >> 24u) << 16u);
    return TileInSlot(words.x & 0x1fu, words.y & 0xffffffu, column, (words.x >> 5u) & 0x7ffu);
}
