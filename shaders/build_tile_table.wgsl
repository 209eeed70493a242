// The tile offset table of the tiles that are shown, finest level first, and the quadtree over them:
// what tile_lookup.wgsl searches and descends. One workgroup a layer, one lane a tile.
//
// In the order of a walk through the quadtree, tiles below the same node follow one another. So each
// tile needs to compare itself with the one before it only, to know which nodes on its way from the root
// are there already and which are its own to make.
// needs: common/packed_tile.wgsl common/workgroup_scan.wgsl

const LANES: u32 = 256u;
const MOST_SLOTS: u32 = 1600u;
// Bits of the rows and columns of the finest level.
const LEVEL_BITS: u32 = 24u;

struct ShownSlots {
    count: u32,
    @align(16) tiles: array<TileInSlot, MOST_SLOTS>,
}

// As in frame.wgsl.
struct TableRange {
    first_entry: u32,
    entry_count: u32,
    first_node: u32,
    root_word: u32,
}

struct ShownTiles {
    ranges: array<TableRange, 2>,
    // Finest level first, then by row and column.
    tiles: array<array<TileInSlot, MOST_SLOTS>, 2>,
}

// A tile in the order of the walk.
struct Step {
    // Its place in the table.
    entry: u32,
    // Down to this level the nodes on its way from the root are there before it.
    known_level: u32,
    // Its own nodes follow: the first of them.
    first_node: u32,
}

// Entries of a layer follow those of the one before, and so do its words among the nodes.
struct TableSpace {
    entries: u32,
    nodes: u32,
}

@group(0) @binding(0) var<uniform> space: TableSpace;
@group(0) @binding(1) var<storage, read> shown: array<ShownSlots, 2>;
@group(0) @binding(2) var<storage, read_write> table: ShownTiles;
@group(0) @binding(3) var<storage, read_write> walk: array<array<Step, MOST_SLOTS>, 2>;
@group(0) @binding(4) var<storage, read_write> tile_nodes: array<atomic<u32>>;


// The tile's north-west corner in tiles of the finest level.
fn corner_of(tile: TileInSlot) -> vec2<u32> {
    return vec2<u32>(tile.column, tile.row) << vec2<u32>(LEVEL_BITS - tile.level);
}

fn bit_count(value: u32) -> u32 {
    return 32u - countLeadingZeros(value);
}

fn is_finer_or_before(a: TileInSlot, b: TileInSlot) -> bool {
    if a.level != b.level {
        return a.level > b.level;
    }
    if a.row != b.row {
        return a.row < b.row;
    }
    return a.column < b.column;
}

// Whether corner a, of a tile of this level, comes before b in the walk: quadrant by quadrant, and
// parents before their children.
fn is_walked_before(a: vec2<u32>, a_level: u32, b: vec2<u32>, b_level: u32) -> bool {
    if all(a == b) {
        return a_level < b_level;
    }
    // The coarser of the two axes' highest differing bits decides; rows come before columns.
    let differing = a ^ b;
    if bit_count(differing.y) >= bit_count(differing.x) {
        return a.y < b.y;
    }
    return a.x < b.x;
}

fn sort(layer: u32, lane: u32, count: u32) {
    for (var i = lane; i < count; i += LANES) {
        let tile = shown[layer].tiles[i];
        let corner = corner_of(tile);
        var entry = 0u;
        var step = 0u;
        for (var j = 0u; j < count; j++) {
            let other = shown[layer].tiles[j];
            entry += u32(is_finer_or_before(other, tile));
            step += u32(is_walked_before(corner_of(other), other.level, corner, tile.level));
        }
        table.tiles[layer][entry] = tile;
        walk[layer][step].entry = entry;
    }
    storageBarrier();
}

fn walked(layer: u32, step: u32) -> TileInSlot {
    return table.tiles[layer][walk[layer][step].entry];
}

// Level of the finest node on the tile's way from the root that the step before has made or met. A
// tile makes the nodes above itself, its own children's is not among them.
fn known_level(layer: u32, step: u32, tile: TileInSlot) -> u32 {
    if step == 0u || tile.level == 0u {
        return 0u;
    }
    let before = walked(layer, step - 1u);
    let differing = corner_of(tile) ^ corner_of(before);
    let common_level = LEVEL_BITS - bit_count(differing.x | differing.y);
    return min(common_level, max(before.level, 1u) - 1u);
}

// Numbers the nodes that each tile makes; node 0 is the root's. Returns how many there are.
fn number_nodes(layer: u32, lane: u32, count: u32) -> u32 {
    var nodes = 1u;
    for (var base = 0u; base < count; base += LANES) {
        let step = base + lane;
        var made = 0u;
        var known = 0u;
        if step < count {
            let tile = walked(layer, step);
            known = known_level(layer, step, tile);
            made = max(tile.level, 1u) - 1u - known;
        }
        let made_before = sum_of_lanes(lane, made);
        if step < count {
            walk[layer][step].known_level = known;
            walk[layer][step].first_node = nodes + made_before.before;
        }
        nodes += made_before.total;
    }
    storageBarrier();
    return nodes;
}

// The node of the tile's ancestor at a level that an earlier tile has made: by the first tile in the
// walk that lies below the ancestor.
fn known_node(layer: u32, count: u32, tile: TileInSlot, level: u32) -> u32 {
    if level == 0u {
        return 0u;
    }
    let up = vec2<u32>(LEVEL_BITS - level);
    let corner = (corner_of(tile) >> up) << up;
    var low = 0u;
    var high = count - 1u;
    while low < high {
        let middle = (low + high) / 2u;
        let other = walked(layer, middle);
        if is_walked_before(corner_of(other), other.level, corner, level + 1u) {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    let maker = walk[layer][low];
    return maker.first_node + level - maker.known_level - 1u;
}

// Quadrant of the tile's ancestor at the level within that one's parent.
fn quadrant(tile: TileInSlot, level: u32) -> u32 {
    let up = tile.level - level;
    return ((tile.row >> up) & 1u) * 2u + ((tile.column >> up) & 1u);
}

fn link_nodes(layer: u32, lane: u32, count: u32, first_word: u32) {
    for (var step = lane; step < count; step += LANES) {
        let tile = walked(layer, step);
        let own = walk[layer][step];
        let entry_bits = (own.entry + 1u) << 16u;
        if tile.level == 0u {
            table.ranges[layer].root_word = entry_bits;
            continue;
        }
        var node = known_node(layer, count, tile, own.known_level);
        for (var level = own.known_level + 1u; level < tile.level; level++) {
            let made = own.first_node + level - own.known_level - 1u;
            atomicOr(&tile_nodes[first_word + node * 4u + quadrant(tile, level)], made);
            node = made;
        }
        atomicOr(&tile_nodes[first_word + node * 4u + quadrant(tile, tile.level)], entry_bits);
    }
}

@compute @workgroup_size(256)
fn build_tile_table(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let layer = group.x;
    let count = shown[layer].count;
    let first_word = layer * space.nodes;
    sort(layer, lane, count);
    let nodes = number_nodes(layer, lane, count);
    for (var word = lane; word < nodes * 4u; word += LANES) {
        atomicStore(&tile_nodes[first_word + word], 0u);
    }
    if lane == 0u {
        table.ranges[layer] = TableRange(layer * space.entries, count, first_word, 0u);
    }
    storageBarrier();
    link_nodes(layer, lane, count, first_word);
}
