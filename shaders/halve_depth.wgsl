// The farthest depth of a scene, mip by mip, in a buffer: of each two by two places of a mip the farthest is the next
// mip's. Depth runs in reverse, so the farthest is the least. Of an odd number the last one belongs to the outermost
// place.

// The scene's own depth.
@group(0) @binding(0) var scene_depth: texture_2d<f32>;
// The mips one after the other, row by row.
@group(0) @binding(1) var<storage, read_write> farthest_depth: array<f32>;

struct Mip {
    // Where it begins, and how large it is.
    start: u32,
    width: u32,
    height: u32,
    padding: u32,
    finer_start: u32,
    finer_width: u32,
    finer_height: u32,
    finer_padding: u32,
}

@group(0) @binding(2) var<uniform> mip: Mip;

@compute @workgroup_size(8, 8)
fn copy_depth(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= mip.width || id.y >= mip.height {
        return;
    }
    farthest_depth[mip.start + id.y * mip.width + id.x] = textureLoad(scene_depth, id.xy, 0).x;
}

@compute @workgroup_size(8, 8)
fn halve_depth(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = vec2<u32>(mip.width, mip.height);
    if any(id.xy >= size) {
        return;
    }
    let first = id.xy * 2u;
    let end = select(first + 2u, vec2<u32>(mip.finer_width, mip.finer_height), id.xy + 1u == size);
    var farthest = 1.0;
    for (var y = first.y; y < end.y; y++) {
        for (var x = first.x; x < end.x; x++) {
            farthest = min(farthest, farthest_depth[mip.finer_start + y * mip.finer_width + x]);
        }
    }
    farthest_depth[mip.start + id.y * size.x + id.x] = farthest;
}
