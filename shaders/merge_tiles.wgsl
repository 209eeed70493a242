// Steps 3 and 4 of tile scheduling's selection: regularisation, and merging the farthest tile until
// the list is short enough. The twins are `regularize` and `merge_farthest` in the library, with the
// same outcome, merge for merge. One workgroup.
//
// Merging takes one tile after the other, but what it does can be told without doing it. A tile's
// children are never nearer than it and finer, so tiles fall due by rank, from the highest down: a rank
// is a time, later the lower it is. When a tile is due, all of its descendants have been merged away;
// so it is merged then (an *event* of its parent's group) unless it has left the list for good. It
// leaves the list when a sibling is merged, and comes back when a child is. All of that is known from
// the events of its children and siblings, level by level from the finest; what each event takes off the
// list as well, and so does the first one after which the list is short enough.
// needs: common/whole_numbers.wgsl common/selection.wgsl common/tile_arena.wgsl common/workgroup_scan.wgsl

// Before all times.
const EARLIEST: u32 = 0xffffffffu;
const LEVELS: u32 = 25u;

var<workgroup> kept_count: atomic<u32>;
var<workgroup> merge_count: atomic<u32>;
var<workgroup> node_count: u32;
var<workgroup> kept: u32;
// The time after whose event the list is short enough.
var<workgroup> last_merge: u32;

fn is_covered_by_children(index: u32) -> bool {
    let children = arena.nodes[index].children;
    var nodes = 0u;
    for (var quadrant = 0u; quadrant < 4u; quadrant++) {
        let child = children[quadrant];
        if is_seen(child) {
            nodes++;
        } else if child != EMPTY_CHILD && !(params.is_by_error == 1u && is_unseen(child)) {
            return false;
        }
    }
    return nodes > 0u;
}

fn is_seen(child: u32) -> bool {
    return is_node(child) && !has_state(child, HIDDEN);
}

fn is_unseen(child: u32) -> bool {
    return child == OUT_OF_VIEW || is_node(child) && has_state(child, HIDDEN);
}

fn seen_children(index: u32) -> u32 {
    let children = arena.nodes[index].children;
    var seen = 0u;
    for (var quadrant = 0u; quadrant < 4u; quadrant++) {
        seen += select(0u, 1u, is_seen(children[quadrant]));
    }
    return seen;
}

// Regularisation by the list as it came in: every node that is not hidden.
fn regularize(index: u32) {
    if !has_state(index, HIDDEN) && (index == ROOT || !is_covered_by_children(index)) {
        arena.nodes[index].state |= KEPT;
        atomicAdd(&kept_count, 1u);
    }
    var first_event = 0u;
    let children = arena.nodes[index].children;
    for (var quadrant = 0u; quadrant < 4u; quadrant++) {
        if is_seen(children[quadrant]) {
            first_event = max(first_event, arena.nodes[children[quadrant]].rank);
        }
    }
    arena.nodes[index].first_event = first_event;
}

// By error all of a tile's children are merged at the tile's own time, and its descendants before.
fn plan_merges_by_error(lane: u32, nodes: u32) {
    for (var index = lane; index < nodes; index += LANES) {
        let seen = seen_children(index);
        var shorter = 0u;
        if seen > 0u && !has_state(index, HIDDEN) {
            arena.nodes[index].state |= EVENT;
            shorter = seen - select(1u, 0u, has_state(index, KEPT));
        }
        lists.work[arena.nodes[index].rank] = shorter;
    }
    storageBarrier();
}

// Whether a tile's children are merged into it, with the last merge at a time.
fn is_merged_by_error(index: u32, last: u32) -> bool {
    return has_state(index, EVENT) && arena.nodes[index].rank >= last;
}

// The latest of the events among a node's children before a time.
fn latest_event_before(parent: u32, time: u32) -> u32 {
    var latest = EARLIEST;
    let children = arena.nodes[parent].children;
    for (var quadrant = 0u; quadrant < 4u; quadrant++) {
        let child = children[quadrant];
        if is_node(child) && has_state(child, EVENT) && arena.nodes[child].rank > time {
            latest = min(latest, arena.nodes[child].rank);
        }
    }
    return latest;
}

// Whether a node was on the list to begin with and has not become redundant before the time.
fn stayed_until(index: u32, time: u32) -> bool {
    return has_state(index, KEPT) && arena.nodes[index].redundant_at <= time;
}

// Whether a node is on the list just before what happens at the time.
fn is_listed_before(index: u32, time: u32) -> bool {
    if index == ROOT {
        return true;
    }
    let taken_off = latest_event_before(arena.nodes[index].parent, time);
    let put_on = latest_event_before(index, time);
    if put_on != EARLIEST {
        return put_on < taken_off;
    }
    return taken_off == EARLIEST && stayed_until(index, time);
}

// Whether a child is on the list just after the time of a sibling's first event, before any of their
// own group.
fn is_listed_beside(child: u32, time: u32) -> bool {
    return arena.nodes[child].first_event > time || stayed_until(child, time);
}

// When the tile becomes redundant, because merging puts the last of its children on the list beside it;
// 0 for never. Only before the first event among its children: what that takes off does not come back.
fn time_redundant(index: u32) -> u32 {
    let node = arena.nodes[index];
    if index == ROOT || !has_state(index, KEPT) {
        return 0u;
    }
    let earliest = max(node.first_event, arena.nodes[node.parent].first_event);
    var found = 0u;
    for (var last = 0u; last < 4u; last++) {
        let child = node.children[last];
        if !is_seen(child) { continue; }
        let time = arena.nodes[child].first_event;
        if time <= earliest || is_listed_beside(child, time) { continue; }
        var is_covered = true;
        for (var quadrant = 0u; quadrant < 4u; quadrant++) {
            let other = node.children[quadrant];
            if quadrant == last || other == EMPTY_CHILD { continue; }
            is_covered &= is_node(other) && is_listed_beside(other, time);
        }
        found = max(found, select(0u, time, is_covered));
    }
    return found;
}

// Tells which of a node's children are merged when they are due, from the farthest to the nearest.
fn find_events(index: u32) {
    let children = arena.nodes[index].children;
    var due = EARLIEST;
    var latest = EARLIEST;
    for (var turn = 0u; turn < 4u; turn++) {
        var next = 0u;
        var next_rank = 0u;
        for (var quadrant = 0u; quadrant < 4u; quadrant++) {
            let child = children[quadrant];
            if !is_seen(child) { continue; }
            let rank = arena.nodes[child].rank;
            if rank < due && rank > next_rank {
                next = child;
                next_rank = rank;
            }
        }
        if next_rank == 0u { break; }
        due = next_rank;
        if latest == EARLIEST || latest_event_before(next, 0u) < latest {
            arena.nodes[next].state |= EVENT;
            latest = next_rank;
        }
    }
}

// How much shorter the list gets by the event of a node.
fn shortening(index: u32) -> u32 {
    let time = arena.nodes[index].rank;
    let parent = arena.nodes[index].parent;
    let siblings = arena.nodes[parent].children;
    var taken_off = 0u;
    for (var quadrant = 0u; quadrant < 4u; quadrant++) {
        let sibling = siblings[quadrant];
        if is_node(sibling) && is_listed_before(sibling, time) {
            taken_off++;
        }
    }
    if is_listed_before(parent, time) {
        return taken_off;
    }
    let grandparent = arena.nodes[parent].parent;
    let is_redundant = arena.nodes[grandparent].redundant_at == time;
    return taken_off - 1u + select(0u, 1u, is_redundant);
}

fn find_last_merge(lane: u32, nodes: u32, wanted: u32) {
    var found = 0u;
    for (var passed = 0u; passed < nodes && found < wanted; passed += LANES) {
        let offset = passed + lane;
        let rank = nodes - min(offset, nodes);
        let shorter = lists.work[rank];
        let sums = sum_of_lanes(lane, shorter);
        let before = found + sums.before;
        if before < wanted && before + shorter >= wanted {
            last_merge = rank;
        }
        found += sums.total;
    }
}

// All that merging could do, level by level from the finest.
fn plan_merges(lane: u32, nodes: u32) {
    for (var down = 0u; down < LEVELS; down++) {
        let level = LEVELS - 1u - down;
        let end = arena.level_begin[level + 1u];
        for (var index = arena.level_begin[level] + lane; index < end; index += LANES) {
            arena.nodes[index].redundant_at = time_redundant(index);
            find_events(index);
        }
        storageBarrier();
    }
    for (var index = lane; index < nodes; index += LANES) {
        let rank = arena.nodes[index].rank;
        lists.work[rank] = 0u;
        if has_state(index, EVENT) {
            lists.work[rank] = shortening(index);
        }
    }
    storageBarrier();
}

fn is_selected(index: u32, merges: bool, last: u32) -> bool {
    if merges && params.is_by_error == 1u {
        let is_reached = index == ROOT || !is_merged_by_error(arena.nodes[index].parent, last);
        let is_left = has_state(index, KEPT) || is_merged_by_error(index, last);
        return !has_state(index, HIDDEN) && is_reached && is_left;
    }
    if merges {
        // Just after the last merge.
        return !has_state(index, HIDDEN) && is_listed_before(index, last - 1u);
    }
    return has_state(index, KEPT);
}

@compute @workgroup_size(256)
fn merge_tiles(@builtin(local_invocation_index) lane: u32) {
    if lane == 0u {
        node_count = arena.node_count;
        // What the rank behind all nodes takes off.
        lists.work[0] = 0u;
    }
    let nodes = workgroupUniformLoad(&node_count);
    for (var index = lane; index < nodes; index += LANES) {
        regularize(index);
    }
    storageBarrier();
    workgroupBarrier();
    if lane == 0u {
        kept = atomicLoad(&kept_count);
    }
    let listed = workgroupUniformLoad(&kept);
    let most = max(params.max_tiles, 1u);
    let merges = listed > most;
    if merges {
        if params.is_by_error == 1u {
            plan_merges_by_error(lane, nodes);
        } else {
            plan_merges(lane, nodes);
        }
        find_last_merge(lane, nodes, listed - most);
    }
    let last = workgroupUniformLoad(&last_merge);
    for (var index = lane; index < nodes; index += LANES) {
        if is_selected(index, merges, last) {
            arena.nodes[index].state |= SELECTED;
        }
        if merges && has_state(index, EVENT) && arena.nodes[index].rank >= last {
            atomicAdd(&merge_count, 1u);
        }
    }
    workgroupBarrier();
    if lane == 0u {
        selected_tiles[2] = selected_tiles[1] - listed;
        selected_tiles[3] = atomicLoad(&merge_count);
    }
}
