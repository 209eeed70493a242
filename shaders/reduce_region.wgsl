// Step 1 of tile scheduling's selection on the GPU: the smallest box round all ground in the coordinate
// image, and how many pixels see ground. The twin is `visible_region` in the library.
// needs: common/seen_ground.wgsl common/coordinate_image.wgsl

var<workgroup> of_group: array<atomic<u32>, 5>;

@compute @workgroup_size(16, 16)
fn reduce_region(
    @builtin(global_invocation_id) pixel: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let ground = pixel_at(pixel.xy);
    if ground.is_ground {
        atomicMax(&of_group[SEEN_WEST], ordered(-ground.offset_m.x));
        atomicMax(&of_group[SEEN_SOUTH], ordered(-ground.offset_m.y));
        atomicMax(&of_group[SEEN_EAST], ordered(ground.offset_m.x));
        atomicMax(&of_group[SEEN_NORTH], ordered(ground.offset_m.y));
        atomicAdd(&of_group[SEEN_PIXELS], 1u);
    }
    workgroupBarrier();
    if lane < SEEN_PIXELS {
        atomicMax(&seen[lane], atomicLoad(&of_group[lane]));
    } else if lane == SEEN_PIXELS {
        atomicAdd(&seen[lane], atomicLoad(&of_group[lane]));
    }
}
