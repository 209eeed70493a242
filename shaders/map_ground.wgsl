// The displaced mesh as triangles for the texture map.
// needs: common/frame.wgsl common/tile_lookup.wgsl common/mesh.wgsl common/page_table.wgsl common/page_request.wgsl common/page_marks.wgsl common/page_ground.wgsl common/texture_map.wgsl common/map_triangles.wgsl

@group(3) @binding(1) var<storage, read> displaced_vertices: array<DisplacedVertex>;
@group(3) @binding(2) var<storage, read> indices: array<u32>;
@group(3) @binding(3) var<storage, read> mesh_blocks: array<MeshBlock>;
@group(3) @binding(4) var<storage, read> visible_blocks: array<u32>;

fn map_corner(vertex: u32) -> MapCorner {
    let displaced = displaced_vertices[vertex];
    let relative_m = vec3<f32>(displaced.x, displaced.y, displaced.z);
    return MapCorner(relative_m, ground_texels(relative_m.xy - page_ground.anchor_from_eye_m));
}

// A triangle by its number in the mesh's list.
fn map_triangle(number: u32) -> MapTriangle {
    let first = number * 3u;
    return MapTriangle(
        page_ground.anchor_texel,
        map_corner(indices[first]),
        map_corner(indices[first + 1u]),
        map_corner(indices[first + 2u]),
        false,
        vec2<f32>(0.0),
        f32(pages.coarsest_level),
        false,
    );
}

// The triangle that is at a place of a range of triangles, or NO_TRIANGLE beyond its end. The ranges are the visible
// blocks.
fn triangle_in_range(place: u32, range: u32) -> u32 {
    let block = mesh_blocks[visible_blocks[range]];
    return select(NO_TRIANGLE, block.index_start / 3u + place, place * 3u < block.index_count);
}
