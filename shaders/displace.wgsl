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
// x, y, z relative to the eye, three floats a vertex.
@group(2) @binding(3) var<storage, read_write> positions: array<f32>;

fn displaced(vertex: MeshVertex) -> vec3<f32> {
    var offset_m = vec2<f32>(vertex.east, vertex.north) * frame.mesh_scale_m;
    // Beyond the data the mesh folds onto its border, so that the outermost triangles end exactly there.
    offset_m = clamp(offset_m, frame.data_min_from_eye_m, frame.data_max_from_eye_m);
    let entry = tile_entries[find_tile(frame.height_table, fixed_from_offset(offset_m))];
    let sample = sample_height(entry, texel_in_tile(entry, offset_m), vertex.spacing * frame.mesh_scale_m);
    let lowest_m = frame.height_min_m - frame.eye_height_coarse_m;
    let above_coarse_m = select(lowest_m, sample.x, sample.y > 0.0);
    return vec3<f32>(offset_m, (above_coarse_m - frame.eye_height_rest_m) * frame.vertical_exaggeration);
}

@compute @workgroup_size(64)
fn displace(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let block = mesh_blocks[visible_blocks[group.y]];
    let index = group.x * 64u + lane;
    if index >= block.vertex_count {
        return;
    }
    let vertex = block.vertex_start + index;
    let position = displaced(mesh_vertices[vertex]);
    positions[vertex * 3u] = position.x;
    positions[vertex * 3u + 1u] = position.y;
    positions[vertex * 3u + 2u] = position.z;
}
