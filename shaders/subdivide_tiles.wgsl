// Step 2 of tile scheduling's selection, quadtree subdivision by distance: fills the arena from the
// root on. The twin is `subdivide` in the library, node for node. One workgroup.
// needs: common/whole_numbers.wgsl common/selection.wgsl common/seen_ground.wgsl common/tile_arena.wgsl common/tile_presence.wgsl common/workgroup_scan.wgsl

@group(0) @binding(2) var<storage, read> seen: array<u32>;

// Nodes beyond which nothing more is split.
const LISTED_AT_MOST: u32 = 65536u;
const LEVEL_BEGINS: u32 = 28u;
// A child that is on the list, and one in the box that is not.
const SEEN_CHILD: u32 = 1u;
const HIDDEN_CHILD: u32 = 2u;

var<workgroup> box_min: vec2<i32>;
var<workgroup> box_max: vec2<i32>;
var<workgroup> node_count: atomic<u32>;
var<workgroup> is_nothing_seen: u32;
var<workgroup> nodes_so_far: u32;
var<workgroup> hidden_count: atomic<u32>;

fn find_box() {
    let min_m = vec2<f32>(-from_ordered(seen[SEEN_WEST]), -from_ordered(seen[SEEN_SOUTH]));
    let max_m = vec2<f32>(from_ordered(seen[SEEN_EAST]), from_ordered(seen[SEEN_NORTH]));
    // North is up in offsets and down in units.
    let north_west = units_from_anchor(vec2<f32>(min_m.x, max_m.y));
    let south_east = units_from_anchor(vec2<f32>(max_m.x, min_m.y));
    box_min = params.anchor + vec2<i32>(floor(north_west));
    box_max = params.anchor + vec2<i32>(ceil(south_east));
    is_nothing_seen = select(0u, 1u, seen[SEEN_PIXELS] == 0u);
}

fn touches_box(level: u32, row: u32, column: u32) -> bool {
    let side = 30u - level;
    let first = vec2<i32>(vec2<u32>(column, row) << vec2<u32>(side));
    let last = vec2<i32>((vec2<u32>(column, row) + 1u) << vec2<u32>(side));
    return all(first <= box_max) && all(box_min <= last);
}

fn goes_by_box() -> bool {
    return params.is_exact == 0u || seen[SEEN_OVERFLOW] != 0u;
}

fn was_seen(level: u32, row: u32, column: u32) -> bool {
    if goes_by_box() {
        return true;
    }
    let key = tile_key(level, row, column, params.eye_ground);
    if key == 0u {
        return false;
    }
    var slot = first_slot(key);
    // At least half of the table is empty.
    while seen[SEEN_HEADER + slot] != 0u {
        if seen[SEEN_HEADER + slot] == key {
            return true;
        }
        slot = next_slot(slot);
    }
    return false;
}

fn exists(level: u32, row: u32, column: u32) -> bool {
    return is_present(0u, level, row, column) || is_present(1u, level, row, column);
}

// Whether the layer holds nothing there at any level.
fn is_empty_in(layer: u32, level: u32, row: u32, column: u32) -> bool {
    let finest = params.layer_finest[layer];
    let up = level - min(level, finest);
    return !is_present(layer, level - up, row >> up, column >> up);
}

fn child_kind(node: TileNode, quadrant: u32) -> u32 {
    let level = node.level + 1u;
    let row = 2u * node.row + quadrant / 2u;
    let column = 2u * node.column + quadrant % 2u;
    if !exists(level, row, column) {
        let is_empty = is_empty_in(0u, level, row, column) && is_empty_in(1u, level, row, column);
        return select(UNKNOWN_CHILD, EMPTY_CHILD, is_empty);
    }
    if !touches_box(level, row, column) {
        return OUT_OF_VIEW;
    }
    let is_hidden = (node.state & HIDDEN) != 0u || !was_seen(level, row, column);
    return select(SEEN_CHILD, HIDDEN_CHILD, is_hidden);
}

fn new_node(level: u32, row: u32, column: u32, parent: u32, nearest: vec2<u32>, state: u32) -> TileNode {
    var node: TileNode;
    node.level = level;
    node.row = row;
    node.column = column;
    node.parent = parent;
    node.distance = squared_distance(level, row, column);
    // The parent's ground holds the tile's.
    if is_less(node.distance, nearest) {
        node.distance = nearest;
    }
    node.state = state;
    node.children = vec4<u32>(UNKNOWN_CHILD);
    return node;
}

fn add_children(index: u32, kinds: vec4<u32>, first: u32) {
    let node = arena.nodes[index];
    var children = kinds;
    var next = first;
    for (var quadrant = 0u; quadrant < 4u; quadrant++) {
        let kind = kinds[quadrant];
        if kind != SEEN_CHILD && kind != HIDDEN_CHILD { continue; }
        let row = 2u * node.row + quadrant / 2u;
        let column = 2u * node.column + quadrant % 2u;
        let state = select(0u, HIDDEN, kind == HIDDEN_CHILD);
        arena.nodes[next] = new_node(node.level + 1u, row, column, index, node.distance, state);
        children[quadrant] = next;
        if kind == HIDDEN_CHILD {
            atomicAdd(&hidden_count, 1u);
        }
        next++;
    }
    arena.nodes[index].children = children;
    atomicMax(&node_count, next);
}

fn find_levels(lane: u32, nodes: u32) {
    if lane < LEVEL_BEGINS {
        arena.level_begin[lane] = nodes;
    }
    storageBarrier();
    for (var index = lane; index < nodes; index += LANES) {
        let level = arena.nodes[index].level;
        if index == 0u || arena.nodes[index - 1u].level != level {
            arena.level_begin[level] = index;
        }
    }
}

@compute @workgroup_size(256)
fn subdivide_tiles(@builtin(local_invocation_index) lane: u32) {
    if lane == 0u {
        find_box();
        arena.nodes[0] = new_node(0u, 0u, 0u, ROOT, vec2<u32>(0u), 0u);
        atomicStore(&node_count, 1u);
    }
    storageBarrier();
    let is_empty_view = workgroupUniformLoad(&is_nothing_seen) == 1u;
    // Nodes are appended in order, so going through them in order is going level by level.
    var first = 0u;
    var end = select(1u, 0u, is_empty_view);
    while first < end && end < LISTED_AT_MOST {
        let last = min(first + LANES, end);
        let index = first + lane;
        var kinds = vec4<u32>(UNKNOWN_CHILD);
        if index < last {
            let node = arena.nodes[index];
            if is_less(node.distance, params.split_below[node.level]) {
                for (var quadrant = 0u; quadrant < 4u; quadrant++) {
                    kinds[quadrant] = child_kind(node, quadrant);
                }
            }
        }
        let are_nodes = (kinds == vec4<u32>(SEEN_CHILD)) | (kinds == vec4<u32>(HIDDEN_CHILD));
        let added = select(vec4<u32>(0u), vec4<u32>(1u), are_nodes);
        let sums = sum_of_lanes(lane, added.x + added.y + added.z + added.w);
        if index < last && end + sums.before < LISTED_AT_MOST {
            add_children(index, kinds, end + sums.before);
        }
        storageBarrier();
        workgroupBarrier();
        if lane == 0u {
            nodes_so_far = atomicLoad(&node_count);
        }
        first = last;
        end = workgroupUniformLoad(&nodes_so_far);
    }
    if lane == 0u {
        nodes_so_far = atomicLoad(&node_count);
        let hidden = atomicLoad(&hidden_count);
        arena.node_count = nodes_so_far;
        selected_tiles[1] = nodes_so_far - hidden;
        selected_tiles[5] = hidden;
        selected_tiles[6] = select(0u, 1u, params.is_exact == 1u && goes_by_box());
    }
    find_levels(lane, workgroupUniformLoad(&nodes_so_far));
}
