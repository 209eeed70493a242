// Where the tiles of the table lie, seen from the eye: the entries that tile_lookup.wgsl reads. Places
// of tiles and eye are whole units, 2^46 a root side, whose difference is exact; only that is rounded to
// a float. One lane an entry.
// needs: common/packed_tile.wgsl

const MOST_SLOTS: u32 = 1600u;
const UNIT_BITS: u32 = 46u;

// As in build_tile_table.wgsl.
struct TableRange {
    first_entry: u32,
    entry_count: u32,
    first_node: u32,
    root_word: u32,
}

struct ShownTiles {
    ranges: array<TableRange, 2>,
    tiles: array<array<TileInSlot, MOST_SLOTS>, 2>,
}

// As in tile_lookup.wgsl.
struct TilePlace {
    origin_from_eye_m: vec2<f32>,
    texels_per_m: f32,
    atlas_texel: u32,
}

struct TileEntry {
    place: TilePlace,
    level: u32,
    column: u32,
    row: u32,
    padding: u32,
}

struct PlacedLayer {
    // The atlas: slots across, texels of a slot, and of its gutter.
    columns: u32,
    slot_texels: u32,
    gutter_texels: u32,
    // Of level 0.
    texels_per_m: f32,
    // A tile is told from one of these corners of its texels: so many texels apart, 2^bits times along a
    // side. None apart: from its first texel.
    step_texels: u32,
    step_bits: u32,
    padding: vec2<u32>,
}

struct Ground {
    // Metres a unit: mantissa (its highest bit set) times 2^exponent.
    metres_mantissa: u32,
    metres_exponent: i32,
    padding: vec2<u32>,
    layers: array<PlacedLayer, 2>,
}

@group(0) @binding(0) var<uniform> ground: Ground;
// The eye east (low and high word) and south of the root's corner, units.
@group(0) @binding(1) var<uniform> eye: vec4<u32>;
@group(0) @binding(2) var<storage, read> table: ShownTiles;
@group(0) @binding(3) var<storage, read_write> tile_entries: array<TileEntry>;

// Two's complement integers of 64 bits: low word, high word.

fn add64(a: vec2<u32>, b: vec2<u32>) -> vec2<u32> {
    let low = a.x + b.x;
    return vec2<u32>(low, a.y + b.y + u32(low < a.x));
}

fn negative64(a: vec2<u32>) -> vec2<u32> {
    return add64(~a, vec2<u32>(1u, 0u));
}

fn is_negative64(a: vec2<u32>) -> bool {
    return (a.y & 0x80000000u) != 0u;
}

// For shifts below 64.
fn shifted_left64(value: u32, bits: u32) -> vec2<u32> {
    if bits >= 32u {
        return vec2<u32>(0u, value << (bits - 32u));
    }
    if bits == 0u {
        return vec2<u32>(value, 0u);
    }
    return vec2<u32>(value << bits, value >> (32u - bits));
}

// The low word of a positive number shifted right by less than 64 bits.
fn low_word_shifted_right(a: vec2<u32>, bits: u32) -> u32 {
    if bits >= 32u {
        return a.y >> (bits - 32u);
    }
    if bits == 0u {
        return a.x;
    }
    return (a.x >> bits) | (a.y << (32u - bits));
}

fn product64(a: u32, b: u32) -> vec2<u32> {
    let a_low = a & 0xffffu;
    let a_high = a >> 16u;
    let b_low = b & 0xffffu;
    let b_high = b >> 16u;
    let low = a_low * b_low;
    let middle = a_high * b_low + (low >> 16u);
    let other = a_low * b_high + (middle & 0xffffu);
    let high = a_high * b_high + (middle >> 16u) + (other >> 16u);
    return vec2<u32>((low & 0xffffu) | (other << 16u), high);
}

// 2^exponent, for exponents a float has.
fn power_of_two(exponent: i32) -> f32 {
    return bitcast<f32>(u32(clamp(exponent, -126, 127) + 127) << 23u);
}

// Metres of a length in units, rounded to the nearest float but for a part in 2^6 of its last bit.
fn metres(units: vec2<u32>) -> f32 {
    let is_negative = is_negative64(units);
    let size = select(units, negative64(units), is_negative);
    if all(size == vec2<u32>(0u)) {
        return 0.0;
    }
    // The 32 leading bits of the length, of the product with the metres of a unit, and of that the 24 of
    // a float.
    var zeros = countLeadingZeros(size.y);
    if size.y == 0u {
        zeros = 32u + countLeadingZeros(size.x);
    }
    let leading = leading_bits(size, zeros);
    var exponent = 72 - i32(zeros) + ground.metres_exponent;
    let product = product64(leading, ground.metres_mantissa);
    var high = product.y;
    if (high & 0x80000000u) == 0u {
        high = (high << 1u) | (product.x >> 31u);
        exponent -= 1;
    }
    let rounded = (high >> 8u) + ((high >> 7u) & 1u);
    let length_m = f32(rounded) * power_of_two(exponent);
    return select(length_m, -length_m, is_negative);
}

// The 32 bits behind so many leading zeros.
fn leading_bits(size: vec2<u32>, zeros: u32) -> u32 {
    if zeros >= 32u {
        return size.x << (zeros - 32u);
    }
    if zeros == 0u {
        return size.y;
    }
    return (size.y << zeros) | (size.x >> (32u - zeros));
}

struct Told {
    // Metres from the eye, positive to the east and to the south.
    from_eye_m: f32,
    texel: u32,
}

// Where along an axis a tile is told from: its row or column, and the eye.
fn told_from(layer: u32, level: u32, index: u32, eye_units: vec2<u32>) -> Told {
    let side_bits = UNIT_BITS - level;
    let corner_from_eye = add64(shifted_left64(index, side_bits), negative64(eye_units));
    let step_texels = ground.layers[layer].step_texels;
    if step_texels == 0u || !is_negative64(corner_from_eye) {
        return Told(metres(corner_from_eye), 0u);
    }
    // The step nearest to the eye, which lies east or south of the tile's corner; at the most the last.
    let step_bits = ground.layers[layer].step_bits;
    let shift = side_bits - step_bits;
    let beyond = add64(negative64(corner_from_eye), shifted_left64(1u, shift - 1u));
    var step = 1u << step_bits;
    if all(low_and_high_shifted(beyond, side_bits) == vec2<u32>(0u)) {
        step = low_word_shifted_right(beyond, shift);
    }
    let from_eye = add64(corner_from_eye, shifted_left64(step, shift));
    return Told(metres(from_eye), step * step_texels);
}

// A positive number shifted right by 22 to 46 bits.
fn low_and_high_shifted(a: vec2<u32>, bits: u32) -> vec2<u32> {
    return vec2<u32>(low_word_shifted_right(a, bits), select(a.y >> bits, 0u, bits >= 32u));
}

@compute @workgroup_size(64)
fn place_tiles(@builtin(global_invocation_id) id: vec3<u32>) {
    let layer = id.y;
    let range = table.ranges[layer];
    if id.x >= range.entry_count {
        return;
    }
    let tile = table.tiles[layer][id.x];
    let space = ground.layers[layer];
    let east = told_from(layer, tile.level, tile.column, eye.xy);
    let south = told_from(layer, tile.level, tile.row, eye.zw);
    let corner = vec2<u32>(tile.slot % space.columns, tile.slot / space.columns) * space.slot_texels;
    let texel = corner + space.gutter_texels + vec2<u32>(east.texel, south.texel);
    let texels_per_m = space.texels_per_m * power_of_two(i32(tile.level));
    let place = TilePlace(vec2<f32>(east.from_eye_m, -south.from_eye_m), texels_per_m, texel.x | (texel.y << 16u));
    tile_entries[range.first_entry + id.x] = TileEntry(place, tile.level, tile.column, tile.row, 0u);
}
