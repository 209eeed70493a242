// Puts the arena's nodes in the order in which merging takes them: by distance, or by distance in their
// own texels, level, row and column. The twins are `FarthestOrder` and `distance_in_texels` in the
// library. One workgroup; a bitonic sort: K. E. Batcher, "Sorting Networks and Their Applications", 1968.
// needs: common/whole_numbers.wgsl common/selection.wgsl common/tile_arena.wgsl

// Behind all nodes, where their number is no power of two.
const NO_NODE: u32 = 0xffffffffu;

var<workgroup> sorted_count: u32;

// The squared distance, lowest word first; by error shifted up by two bits a level, since a texel is half
// as large: 112 bits at the most.
fn merging_distance(index: u32) -> vec4<u32> {
    let distance = arena.nodes[index].distance;
    if params.is_by_error == 0u {
        return vec4<u32>(distance, 0u, 0u);
    }
    let shift = 2u * arena.nodes[index].level;
    let within = shift % 32u;
    // A shift by all 32 bits is none at all.
    let carried = select(distance >> vec2<u32>((32u - within) % 32u), vec2<u32>(0u), within == 0u);
    let low = distance << vec2<u32>(within);
    let shifted = vec3<u32>(low.x, low.y | carried.x, carried.y);
    return select(vec4<u32>(shifted, 0u), vec4<u32>(0u, shifted), shift >= 32u);
}

fn comes_after(a: u32, b: u32) -> bool {
    if a == NO_NODE || b == NO_NODE {
        return a > b;
    }
    let distances = array<vec4<u32>, 2>(merging_distance(a), merging_distance(b));
    if any(distances[0].zw != distances[1].zw) {
        return is_less(distances[1].zw, distances[0].zw);
    }
    if any(distances[0].xy != distances[1].xy) {
        return is_less(distances[1].xy, distances[0].xy);
    }
    let levels = vec2<u32>(arena.nodes[a].level, arena.nodes[b].level);
    if levels.x != levels.y {
        return levels.x > levels.y;
    }
    let rows = vec2<u32>(arena.nodes[a].row, arena.nodes[b].row);
    if rows.x != rows.y {
        return rows.x > rows.y;
    }
    return arena.nodes[a].column > arena.nodes[b].column;
}

fn sort_pairs(lane: u32, count: u32, size: u32, stride: u32) {
    for (var pair = lane; pair < count / 2u; pair += LANES) {
        let low = 2u * pair - (pair & (stride - 1u));
        let a = lists.order[low];
        let b = lists.order[low + stride];
        let is_ascending = (low & size) == 0u;
        if comes_after(a, b) == is_ascending {
            lists.order[low] = b;
            lists.order[low + stride] = a;
        }
    }
}

@compute @workgroup_size(256)
fn rank_tiles(@builtin(local_invocation_index) lane: u32) {
    let nodes = arena.node_count;
    if lane == 0u {
        // The next power of two.
        sorted_count = select(1u << (32u - countLeadingZeros(nodes - 1u)), 1u, nodes <= 1u);
    }
    let count = workgroupUniformLoad(&sorted_count);
    for (var index = lane; index < count; index += LANES) {
        lists.order[index] = select(NO_NODE, index, index < nodes);
    }
    storageBarrier();
    for (var size = 2u; size <= count; size *= 2u) {
        for (var stride = size / 2u; stride > 0u; stride /= 2u) {
            sort_pairs(lane, count, size, stride);
            storageBarrier();
        }
    }
    for (var place = lane; place < nodes; place += LANES) {
        arena.nodes[lists.order[place]].rank = place + 1u;
    }
}
