// Displaces the visible blocks of the circular mesh: the mesh is flat and centred under the eye,
// and each vertex takes its height from the finest cached tile that holds it. Done once a vertex in
// a compute pass: a vertex shader would repeat it for every triangle that shares the vertex.
// needs: common/frame.wgsl common/tile_lookup.wgsl common/height_sample.wgsl

struct MeshVertex {
    // Normalised by the mesh scale: east, north, and the spacing of the mesh here.
    east: f32,
    north: f32,
    spacing: f32,
}

struct MeshBlock {
    vertex_start: u32,
    vertex_count: u32,
}

@group(2) @binding(0) var<storage, read> mesh_vertices: array<MeshVertex>;
@group(2) @binding(1) var<storage, read> mesh_blocks: array<MeshBlock>;
@group(2) @binding(2) var<storage, read> visible_blocks: array<u32>;
struct DisplacedVertex {
    x: f32,
    y: f32,
    z: f32,
    // The cached tiles that hold the vertex; see pack_hints.
    tile_hints: u32,
}

@group(2) @binding(3) var<storage, read_write> displaced_vertices: array<DisplacedVertex>;

fn displaced(vertex: MeshVertex) -> DisplacedVertex {
    var offset_m = vec2<f32>(vertex.east, vertex.north) * frame.mesh_scale_m;
    // Beyond the data the mesh folds onto its border, so that the outermost triangles end exactly there.
    offset_m = clamp(offset_m, frame.data_min_from_eye_m, frame.data_max_from_eye_m);
    let position = fixed_from_offset(offset_m);
    let height_tile = find_tile(frame.height_table, position);
    var colour_tile = 0u;
    if frame.has_colours != 0u {
        colour_tile = find_tile(frame.colour_table, position);
    }
    let entry = tile_entries[height_tile];
    let sample = sample_height(entry, texel_in_tile(entry, offset_m), vertex.spacing * frame.mesh_scale_m);
    let lowest_m = frame.height_min_m - frame.eye_height_coarse_m;
    let above_coarse_m = select(lowest_m, sample.x, sample.y > 0.0);
    let z = (above_coarse_m - frame.eye_height_rest_m) * frame.vertical_exaggeration;
    return DisplacedVertex(offset_m.x, offset_m.y, z, pack_hints(height_tile, colour_tile));
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
