// The part of the quadtree that a selection is chosen from: a node a tile, ancestors before their
// descendants, levels one after the other. The twin is `TileList` in the library.

struct TileNode {
    level: u32,
    row: u32,
    column: u32,
    // The root's own for the root.
    parent: u32,
    // Squared, in units.
    distance: vec2<u32>,
    state: u32,
    // Place among all nodes in the order of merging, from 1; the first to be merged has the highest.
    rank: u32,
    // In the order north-west, north-east, south-west, south-east.
    children: vec4<u32>,
    // When merging: the highest rank of its children, and the time it became redundant; 0 for never.
    first_event: u32,
    redundant_at: u32,
    padding: vec2<u32>,
}

struct TileArena {
    node_count: u32,
    padding: vec3<u32>,
    // Of each level the first node, and behind the finest level that has any the number of nodes.
    level_begin: array<u32, 28>,
    nodes: array<TileNode>,
}

@group(0) @binding(3) var<storage, read_write> arena: TileArena;

const ROOT: u32 = 0u;
// Instead of a child's node: there is no data there in any layer at any level; never considered; and
// outside the region.
const EMPTY_CHILD: u32 = 0xfffffffeu;
const UNKNOWN_CHILD: u32 = 0xffffffffu;
const OUT_OF_VIEW: u32 = 0xfffffffdu;

// In the box round what was seen, but not seen itself.
const HIDDEN: u32 = 1u;
// On the list when it had been subdivided and regularised.
const KEPT: u32 = 2u;
// Merged away into its parent, as the farthest of the list, if merging goes on for long enough.
const EVENT: u32 = 4u;
// Selected.
const SELECTED: u32 = 8u;

fn has_state(index: u32, state: u32) -> bool {
    return (arena.nodes[index].state & state) != 0u;
}

fn is_node(child: u32) -> bool {
    return child < OUT_OF_VIEW;
}

const LANES: u32 = 256u;

@group(0) @binding(4) var<storage, read_write> lists: TileLists;

struct TileLists {
    // Indices of nodes by rank.
    order: array<u32, 131072>,
    // Work space: how much shorter the list gets by rank; keys of the selected tiles.
    work: array<u32, 131080>,
}

// Count, tiles subdivision listed, tiles the first regularisation took off, merges, finest level, tiles
// hidden, and whether the box stood in for the tiles seen; from word 8 on four words a tile: level, row, column.
@group(0) @binding(5) var<storage, read_write> selected_tiles: array<u32>;
