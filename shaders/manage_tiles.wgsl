// Which tile gets which slot, and which are shown: the cache of the tile-scheduling paper
// kept on the GPU. One workgroup a layer. The rules are those of the cache on the CPU: wanted tiles
// stay, what is missing takes free slots first, then those of the tiles that went unwanted longest (of
// equally old ones the finest), never level 0's. Here a slot is reserved when its tile is asked for and
// not when it comes.
// needs: common/packed_tile.wgsl common/tile_presence.wgsl common/workgroup_scan.wgsl

const LANES: u32 = 256u;
// Slots of a layer, and tiles of a selection, at the most.
const MOST_SLOTS: u32 = 1600u;
// Tiles of a layer that are asked for at a time.
const MOST_ASKED: u32 = 32u;
const NONE: u32 = 0xffffffffu;

const EMPTY: u32 = 0u;
// Its tile is asked for.
const RESERVED: u32 = 1u;
// Its tile cannot be had. Kept so that it is not asked for again while it is wanted.
const FAILED: u32 = 2u;
const RESIDENT: u32 = 3u;

struct ManagedLayer {
    slot_count: u32,
    // The layer has no tiles finer than this level.
    finest_level: u32,
    padding: vec2<u32>,
}

struct Slot {
    level: u32,
    row: u32,
    column: u32,
    state: u32,
    // The latest frame that wanted the tile.
    last_wanted: u32,
}

// What the CPU tells in a frame: for each layer the tiles that have been uploaded into their slots,
// then those that cannot be had.
struct Deliveries {
    frame: u32,
    padding: u32,
    // Tiles uploaded and failed, by layer.
    counts: array<vec2<u32>, 2>,
    tiles: array<vec2<u32>>,
}

// What the CPU gets to know.
struct Report {
    // By layer: missing tiles (11 bits), those of them that are listed (6), resident tiles (11).
    layers: array<u32, 2>,
    // Selected tiles (16 bits) and their finest level.
    selected: u32,
    // Tiles left out because they are hidden.
    hidden: u32,
    // By layer, most urgent first.
    asked: array<array<vec2<u32>, MOST_ASKED>, 2>,
}

struct ShownSlots {
    count: u32,
    @align(16) tiles: array<TileInSlot, MOST_SLOTS>,
}

// Work of one layer.
struct Workings {
    // The selection's tiles as this layer has them, with repetitions.
    candidates: array<TileInSlot, MOST_SLOTS>,
    wanted: array<TileInSlot, MOST_SLOTS>,
}

@group(0) @binding(0) var<uniform> layers: array<ManagedLayer, 2>;
// Number of tiles, three words, their finest level, tiles hidden, two words; then four words a tile, most
// urgent first: level, row, column, spare.
@group(0) @binding(1) var<storage, read> selected: array<u32>;
@group(0) @binding(2) var<storage, read> deliveries: Deliveries;
@group(0) @binding(3) var<storage, read_write> slots: array<array<Slot, MOST_SLOTS>, 2>;
@group(0) @binding(4) var<storage, read_write> workings: array<Workings, 2>;
// By layer and slot.
@group(0) @binding(5) var<storage, read_write> shown: array<ShownSlots, 2>;
@group(0) @binding(6) var<storage, read_write> report: Report;

// Numbers plus one of slots or of candidates, 0 in free cells, where their tiles hash to or behind.
const CELLS: u32 = 2048u;
var<workgroup> cells: array<atomic<u32>, CELLS>;
var<workgroup> victims: array<u32, MOST_ASKED>;
// A bit a slot.
var<workgroup> shown_slots: array<atomic<u32>, 50>;
var<workgroup> resident_count: atomic<u32>;
var<workgroup> reserved_count: atomic<u32>;
var<workgroup> absent_count: atomic<u32>;
var<workgroup> missing_count: atomic<u32>;

fn cell_of(level: u32, row: u32, column: u32) -> u32 {
    let mixed = (row * 0x9e3779b1u) ^ (column * 0x85ebca77u) ^ (level * 0xc2b2ae3du);
    return (mixed ^ (mixed >> 15u)) * 0x2c1b3c6du >> 21u;
}

fn is_same_tile(a: TileInSlot, b: TileInSlot) -> bool {
    return a.level == b.level && a.row == b.row && a.column == b.column;
}

fn tile_of_slot(layer: u32, slot: u32) -> TileInSlot {
    return TileInSlot(slots[layer][slot].level, slots[layer][slot].row, slots[layer][slot].column, slot);
}

fn clear_cells(lane: u32) {
    for (var cell = lane; cell < CELLS; cell += LANES) {
        atomicStore(&cells[cell], 0u);
    }
    workgroupBarrier();
}

// 1. What the CPU has brought. A slot that meanwhile was given to another tile takes nothing.

fn take_deliveries(layer: u32, lane: u32) {
    let counts = deliveries.counts[layer];
    let first = select(0u, deliveries.counts[0].x + deliveries.counts[0].y, layer == 1u);
    for (var i = lane; i < counts.x + counts.y; i += LANES) {
        let tile = unpack_tile(deliveries.tiles[first + i]);
        let slot = tile.slot;
        if slots[layer][slot].state == RESERVED && is_same_tile(tile, tile_of_slot(layer, slot)) {
            slots[layer][slot].state = select(FAILED, RESIDENT, i < counts.x);
        }
    }
    storageBarrier();
}

// 2. The layer's wanted tiles: each selected tile, or its finest ancestor that exists in the layer, once.

fn candidate(layer: u32, index: u32) -> TileInSlot {
    let word = 8u + 4u * index;
    var tile = TileInSlot(selected[word], selected[word + 1u], selected[word + 2u], NONE);
    loop {
        let is_too_fine = tile.level > layers[layer].finest_level;
        if tile.level == 0u || (!is_too_fine && is_present(layer, tile.level, tile.row, tile.column)) {
            break;
        }
        tile = TileInSlot(tile.level - 1u, tile.row >> 1u, tile.column >> 1u, NONE);
    }
    return tile;
}

// Notes the candidate; of equal ones the first is kept.
fn note_candidate(layer: u32, index: u32, tile: TileInSlot) {
    var cell = cell_of(tile.level, tile.row, tile.column);
    loop {
        let old = atomicCompareExchangeWeak(&cells[cell], 0u, index + 1u);
        if old.exchanged {
            return;
        }
        // A weak exchange may fail on a free cell: then once more.
        if old.old_value != 0u {
            if is_same_tile(workings[layer].candidates[old.old_value - 1u], tile) {
                atomicMin(&cells[cell], index + 1u);
                return;
            }
            cell = (cell + 1u) % CELLS;
        }
    }
}

fn is_first_of_its_kind(layer: u32, index: u32) -> bool {
    let tile = workings[layer].candidates[index];
    var cell = cell_of(tile.level, tile.row, tile.column);
    loop {
        let noted = atomicLoad(&cells[cell]) - 1u;
        if is_same_tile(workings[layer].candidates[noted], tile) {
            return noted == index;
        }
        cell = (cell + 1u) % CELLS;
    }
    return false;
}

// Returns how many are wanted. No more than there are slots; level 0 is the first, and before the first
// selection, when all its words are 0, the only one.
fn list_wanted(layer: u32, lane: u32) -> u32 {
    let count = clamp(selected[0], 1u, MOST_SLOTS);
    for (var i = lane; i < count; i += LANES) {
        workings[layer].candidates[i] = candidate(layer, i);
    }
    clear_cells(lane);
    storageBarrier();
    for (var i = lane; i < count; i += LANES) {
        note_candidate(layer, i, workings[layer].candidates[i]);
    }
    workgroupBarrier();
    var wanted = 0u;
    for (var base = 0u; base < count; base += LANES) {
        let i = base + lane;
        var is_first = false;
        if i < count {
            is_first = is_first_of_its_kind(layer, i);
        }
        let firsts = sum_of_lanes(lane, u32(is_first));
        if is_first {
            workings[layer].wanted[wanted + firsts.before] = workings[layer].candidates[i];
        }
        wanted += firsts.total;
    }
    storageBarrier();
    return min(wanted, layers[layer].slot_count);
}

// 3. Slots of tiles.

fn index_slots(layer: u32, lane: u32) {
    clear_cells(lane);
    for (var slot = lane; slot < layers[layer].slot_count; slot += LANES) {
        let state = slots[layer][slot].state;
        if state == EMPTY {
            continue;
        }
        if state == RESIDENT {
            atomicAdd(&resident_count, 1u);
        }
        let tile = tile_of_slot(layer, slot);
        var cell = cell_of(tile.level, tile.row, tile.column);
        // No tile has two slots.
        loop {
            let old = atomicCompareExchangeWeak(&cells[cell], 0u, slot + 1u);
            if old.exchanged {
                break;
            }
            if old.old_value != 0u {
                cell = (cell + 1u) % CELLS;
            }
        }
    }
    workgroupBarrier();
}

// The slot of a tile when the slots were indexed, if it still has it.
fn slot_of(layer: u32, tile: TileInSlot) -> u32 {
    var cell = cell_of(tile.level, tile.row, tile.column);
    loop {
        let slot = atomicLoad(&cells[cell]) - 1u;
        if slot == NONE || is_same_tile(tile_of_slot(layer, slot), tile) {
            return slot;
        }
        cell = (cell + 1u) % CELLS;
    }
    return NONE;
}

fn touch_wanted(layer: u32, lane: u32, wanted: u32) {
    for (var i = lane; i < wanted; i += LANES) {
        let slot = slot_of(layer, workings[layer].wanted[i]);
        workings[layer].wanted[i].slot = slot;
        if slot == NONE {
            atomicAdd(&absent_count, 1u);
            atomicAdd(&missing_count, 1u);
        } else {
            slots[layer][slot].last_wanted = deliveries.frame;
            if slots[layer][slot].state == RESERVED {
                atomicAdd(&reserved_count, 1u);
                atomicAdd(&missing_count, 1u);
            }
        }
    }
    storageBarrier();
}

// 4. Slots for what has none.

// Whether slot a makes way before slot b: free ones first, then those that hold nothing yet, then the
// least recently wanted; of equally old ones the last in the order of tiles.
fn makes_way_before(layer: u32, a: u32, b: u32) -> bool {
    let first = slots[layer][a];
    let second = slots[layer][b];
    let first_kind = (first.state + 1u) / 2u;
    let second_kind = (second.state + 1u) / 2u;
    if first_kind != second_kind {
        return first_kind < second_kind;
    }
    if first_kind != 0u {
        if first.last_wanted != second.last_wanted {
            return first.last_wanted < second.last_wanted;
        }
        if first.level != second.level {
            return first.level > second.level;
        }
        if first.row != second.row {
            return first.row > second.row;
        }
        if first.column != second.column {
            return first.column > second.column;
        }
    }
    return a < b;
}

// Whether the slot may be given to another tile.
fn may_make_way(layer: u32, slot: u32) -> bool {
    let held = slots[layer][slot];
    return held.state == EMPTY || (held.level != 0u && held.last_wanted != deliveries.frame);
}

// Finds the first slots to make way, as many as may be asked for.
fn choose_victims(layer: u32, lane: u32) {
    if lane < MOST_ASKED {
        victims[lane] = NONE;
    }
    workgroupBarrier();
    if atomicLoad(&absent_count) != 0u {
        for (var slot = lane; slot < layers[layer].slot_count; slot += LANES) {
            if !may_make_way(layer, slot) {
                continue;
            }
            var before = 0u;
            for (var other = 0u; other < layers[layer].slot_count && before < MOST_ASKED; other++) {
                before += u32(may_make_way(layer, other) && makes_way_before(layer, other, slot));
            }
            if before < MOST_ASKED {
                victims[before] = slot;
            }
        }
    }
    workgroupBarrier();
}

// Gives slots to absent tiles and lists what has a slot and is still to come, both in order of urgency.
fn reserve_and_list(layer: u32, lane: u32, wanted: u32) {
    let room = MOST_ASKED - min(atomicLoad(&reserved_count), MOST_ASKED);
    var absent = 0u;
    var listed = 0u;
    for (var base = 0u; base < wanted; base += LANES) {
        let i = base + lane;
        var tile = TileInSlot(0u, 0u, 0u, NONE);
        if i < wanted {
            tile = workings[layer].wanted[i];
        }
        let is_absent = i < wanted && tile.slot == NONE;
        let absents = sum_of_lanes(lane, u32(is_absent));
        let rank = absent + absents.before;
        absent += absents.total;
        if is_absent && rank < room {
            tile.slot = victims[rank];
            if tile.slot != NONE {
                if slots[layer][tile.slot].state == RESIDENT {
                    atomicSub(&resident_count, 1u);
                }
                slots[layer][tile.slot] = Slot(tile.level, tile.row, tile.column, RESERVED, deliveries.frame);
            }
        }
        var is_to_come = false;
        if tile.slot != NONE {
            is_to_come = slots[layer][tile.slot].state == RESERVED;
        }
        let to_come = sum_of_lanes(lane, u32(is_to_come));
        let place = listed + to_come.before;
        listed += to_come.total;
        if is_to_come && place < MOST_ASKED {
            report.asked[layer][place] = pack_tile(tile);
        }
    }
    if lane == 0u {
        let missing = atomicLoad(&missing_count);
        report.layers[layer] = missing | (min(listed, MOST_ASKED) << 11u) | (atomicLoad(&resident_count) << 17u);
        if layer == 0u {
            report.selected = selected[0] | (selected[4] << 16u);
            report.hidden = selected[5];
        }
    }
    storageBarrier();
}

// 5. What is shown: of each wanted tile itself or, until it is resident, its finest resident ancestor.
// Other tiles that happen to be resident are left out, so that the picture does not depend on the way
// to the view.

fn mark_shown(layer: u32, lane: u32, wanted: u32) {
    for (var i = lane; i < wanted; i += LANES) {
        var tile = workings[layer].wanted[i];
        loop {
            let slot = slot_of(layer, tile);
            if slot != NONE {
                if slots[layer][slot].state == RESIDENT {
                    atomicOr(&shown_slots[slot / 32u], 1u << (slot % 32u));
                    break;
                }
            }
            if tile.level == 0u {
                break;
            }
            tile = TileInSlot(tile.level - 1u, tile.row >> 1u, tile.column >> 1u, NONE);
        }
    }
    workgroupBarrier();
}

fn list_shown(layer: u32, lane: u32) {
    var count = 0u;
    for (var base = 0u; base < layers[layer].slot_count; base += LANES) {
        let slot = base + lane;
        var is_shown = false;
        if slot < layers[layer].slot_count {
            is_shown = (atomicLoad(&shown_slots[slot / 32u]) >> (slot % 32u) & 1u) != 0u;
        }
        let places = sum_of_lanes(lane, u32(is_shown));
        if is_shown {
            shown[layer].tiles[count + places.before] = tile_of_slot(layer, slot);
        }
        count += places.total;
    }
    if lane == 0u {
        shown[layer].count = count;
    }
}

@compute @workgroup_size(256)
fn manage_tiles(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let layer = group.x;
    take_deliveries(layer, lane);
    let wanted = list_wanted(layer, lane);
    index_slots(layer, lane);
    touch_wanted(layer, lane, wanted);
    choose_victims(layer, lane);
    reserve_and_list(layer, lane, wanted);
    mark_shown(layer, lane, wanted);
    list_shown(layer, lane);
}
