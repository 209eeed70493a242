// Sorts the triangles of the visible blocks into those that lie within one tile of each layer and
// those across a border. Each kind has a list as long as the mesh's own, in which the other kind's
// triangles shrink to a point: so nothing needs counting, and both lists keep the order from near
// to far and the ranges of the blocks.
// needs: common/frame.wgsl common/tile_lookup.wgsl common/mesh.wgsl

@group(2) @binding(0) var<storage, read> mesh_blocks: array<MeshBlock>;
@group(2) @binding(1) var<storage, read> visible_blocks: array<u32>;
@group(2) @binding(2) var<storage, read> displaced_vertices: array<DisplacedVertex>;
@group(2) @binding(3) var<storage, read> indices: array<u32>;
@group(2) @binding(4) var<storage, read_write> indices_within: array<u32>;
@group(2) @binding(5) var<storage, read_write> indices_across: array<u32>;

@compute @workgroup_size(64)
fn sort_triangles(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let block = mesh_blocks[visible_blocks[group.y]];
    let index = (group.x * 64u + lane) * 3u;
    if index >= block.index_count {
        return;
    }
    let first = block.index_start + index;
    let a = indices[first];
    let b = indices[first + 1u];
    let c = indices[first + 2u];
    let cells = displaced_vertices[a].cells;
    let is_within = cells.x != NO_CELL
        && all(displaced_vertices[b].cells == cells)
        && all(displaced_vertices[c].cells == cells);
    indices_within[first] = a;
    indices_within[first + 1u] = select(a, b, is_within);
    indices_within[first + 2u] = select(a, c, is_within);
    indices_across[first] = a;
    indices_across[first + 1u] = select(b, a, is_within);
    indices_across[first + 2u] = select(c, a, is_within);
}
