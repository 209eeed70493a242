// Writes the selected tiles out in order of priority: coarsest level first, within a level nearest
// first. The twin is `Selection::in_order` in the library. One workgroup.
// needs: common/tile_arena.wgsl

// A key holds level and rank, which no node has above 2^17.
const RANK_BITS: u32 = 17u;
const LAST_KEY: u32 = 0xffffffffu;
const HEADER_WORDS: u32 = 8u;

var<workgroup> selected_count: atomic<u32>;
var<workgroup> counts: vec2<u32>;

fn sort_pairs(lane: u32, count: u32, size: u32, stride: u32) {
    for (var pair = lane; pair < count / 2u; pair += LANES) {
        let low = 2u * pair - (pair & (stride - 1u));
        let a = lists.work[low];
        let b = lists.work[low + stride];
        let is_ascending = (low & size) == 0u;
        if (a > b) == is_ascending {
            lists.work[low] = b;
            lists.work[low + stride] = a;
        }
    }
}

@compute @workgroup_size(256)
fn list_tiles(@builtin(local_invocation_index) lane: u32) {
    let nodes = arena.node_count;
    for (var index = lane; index < nodes; index += LANES) {
        if has_state(index, SELECTED) {
            let place = atomicAdd(&selected_count, 1u);
            lists.work[place] = (arena.nodes[index].level << RANK_BITS) | arena.nodes[index].rank;
        }
    }
    storageBarrier();
    workgroupBarrier();
    if lane == 0u {
        let count = atomicLoad(&selected_count);
        let sorted = select(1u << (32u - countLeadingZeros(count - 1u)), 1u, count <= 1u);
        counts = vec2<u32>(count, sorted);
    }
    let all = workgroupUniformLoad(&counts);
    for (var place = all.x + lane; place < all.y; place += LANES) {
        lists.work[place] = LAST_KEY;
    }
    storageBarrier();
    for (var size = 2u; size <= all.y; size *= 2u) {
        for (var stride = size / 2u; stride > 0u; stride /= 2u) {
            sort_pairs(lane, all.y, size, stride);
            storageBarrier();
        }
    }
    let room = (arrayLength(&selected_tiles) - HEADER_WORDS) / 4u;
    for (var place = lane; place < min(all.x, room); place += LANES) {
        let rank = lists.work[place] & ((1u << RANK_BITS) - 1u);
        let index = lists.order[rank - 1u];
        let word = HEADER_WORDS + 4u * place;
        selected_tiles[word] = arena.nodes[index].level;
        selected_tiles[word + 1u] = arena.nodes[index].row;
        selected_tiles[word + 2u] = arena.nodes[index].column;
        selected_tiles[word + 3u] = 0u;
    }
    if lane == 0u {
        selected_tiles[0] = min(all.x, room);
        selected_tiles[4] = lists.work[all.x - 1u] >> RANK_BITS;
    }
}
