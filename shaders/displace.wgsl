// Displaces the visible blocks of the circular mesh: the mesh is flat and centred under the eye,
// and each vertex takes its height from the finest cached tile that holds it. Done once a vertex in
// a compute pass: a vertex shader would repeat it for every triangle that shares the vertex.
// needs: common/frame.wgsl common/tile_lookup.wgsl common/bilinear_height.wgsl common/height_sample.wgsl common/mesh.wgsl

struct MeshVertex {
    // Normalised by the mesh scale: east, north, and the spacing of the mesh here.
    east: f32,
    north: f32,
    spacing: f32,
}

@group(2) @binding(0) var<storage, read> mesh_vertices: array<MeshVertex>;
@group(2) @binding(1) var<storage, read> mesh_blocks: array<MeshBlock>;
@group(2) @binding(2) var<storage, read> visible_blocks: array<u32>;
@group(2) @binding(3) var<storage, read_write> displaced_vertices: array<DisplacedVertex>;

fn find_tile_and_cell(table: TableRange, position: vec2<i32>) -> FoundTile {
    let found = descend(table, position);
    if LINEAR_LOOKUP {
        return FoundTile(find_tile_linear(table, position), found.cell);
    }
    return found;
}

fn displaced(vertex: MeshVertex) -> DisplacedVertex {
    var offset_m = vec2<f32>(vertex.east, vertex.north) * frame.mesh_scale_m;
    // Beyond the data the mesh folds onto its border, so that the outermost triangles end exactly there.
    offset_m = clamp(offset_m, frame.data_min_from_eye_m, frame.data_max_from_eye_m);
    let position = fixed_from_offset(offset_m);
    let height = find_tile_and_cell(frame.height_table, position);
    var colour = FoundTile(height.entry, 0u);
    if frame.has_colours != 0u {
        colour = find_tile_and_cell(frame.colour_table, position);
    }
    // Triangles at the border of the data are for the fragments to look up, which keep imagery inside.
    let is_at_border = any(offset_m == frame.data_min_from_eye_m) || any(offset_m == frame.data_max_from_eye_m);
    let cells = select(vec2<u32>(height.cell, colour.cell), vec2<u32>(NO_CELL), is_at_border);
    let tile = tile_entries[height.entry].place;
    let sample = sample_height(tile, texel_in_tile(tile, offset_m), vertex.spacing * frame.mesh_scale_m);
    let lowest_m = frame.height_min_m - frame.eye_height_coarse_m;
    let above_coarse_m = select(lowest_m, sample.x, sample.y > 0.0);
    let z = (above_coarse_m - frame.eye_height_rest_m) * frame.vertical_exaggeration;
    return DisplacedVertex(tile, tile_entries[colour.entry].place, cells, offset_m.x, offset_m.y, z);
}

@compute @workgroup_size(64)
fn displace(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let block = mesh_blocks[visible_blocks[group.y]];
    let index = group.x * 64u + lane;
    if index >= block.vertex_count {
        return;
    }
    let vertex = block.vertex_start + index;
    displaced_vertices[vertex] = displaced(mesh_vertices[vertex]);
}
