// What the GPU makes of an uploaded height tile, without a byte over the bus: heights in metres, the
// slopes for shading, and two coarser mips of both. Gutters are filtered along with the tile, and
// what is beyond them goes into no texel that is sampled, so every mip meets its neighbours exactly as
// the tile itself does.
// needs: common/stored_heights.wgsl

struct DecodeJob {
    // North-west texel of the slot (gutter included).
    atlas_x: u32,
    atlas_y: u32,
    // Index of the first u32 of the tile's samples in the payload.
    first_word: u32,
    // 1: float32 samples; 0: 16-bit steps, two a u32, low half first.
    is_float: u32,
    base_steps: i32,
    step_m: f32,
    // Side of a height texel in metres.
    texel_size_m: f32,
    // Side of the slot in texels.
    stored_size: u32,
}

@group(0) @binding(0) var<storage, read> jobs: array<DecodeJob>;
@group(0) @binding(2) var heights_out: texture_storage_2d<r32float, write>;

@compute @workgroup_size(8, 8)
fn decode(@builtin(global_invocation_id) id: vec3<u32>) {
    let job = jobs[id.z];
    if any(id.xy >= vec2<u32>(job.stored_size)) {
        return;
    }
    let samples = StoredSamples(job.first_word, job.is_float, job.base_steps, job.step_m);
    let height_m = stored_height(samples, id.y * job.stored_size + id.x);
    textureStore(heights_out, vec2<u32>(job.atlas_x, job.atlas_y) + id.xy, vec4<f32>(height_m, 0.0, 0.0, 0.0));
}

@group(1) @binding(0) var heights_in: texture_2d<f32>;
@group(1) @binding(1) var coarser_heights_out: texture_storage_2d<r32float, write>;

override SOURCE_MIP: u32 = 0u;

// The mean of the texels that hold data, as when preparing: 2 x 2 box filter.
@compute @workgroup_size(8, 8)
fn halve_heights(@builtin(global_invocation_id) id: vec3<u32>) {
    let job = jobs[id.z];
    if any(id.xy >= vec2<u32>(job.stored_size >> (SOURCE_MIP + 1u))) {
        return;
    }
    let corner = (vec2<u32>(job.atlas_x, job.atlas_y) >> vec2<u32>(SOURCE_MIP)) + id.xy * 2u;
    var sum = 0.0;
    var count = 0.0;
    for (var i = 0u; i < 4u; i++) {
        let height_m = textureLoad(heights_in, corner + vec2<u32>(i & 1u, i >> 1u), 0).x;
        if height_m > NO_DATA_M {
            sum += height_m;
            count += 1.0;
        }
    }
    let mean_m = select(NO_DATA_M, sum / max(count, 1.0), count > 0.0);
    let target_texel = (vec2<u32>(job.atlas_x, job.atlas_y) >> vec2<u32>(SOURCE_MIP + 1u)) + id.xy;
    textureStore(coarser_heights_out, target_texel, vec4<f32>(mean_m, 0.0, 0.0, 0.0));
}

@group(1) @binding(2) var all_heights: texture_2d<f32>;
@group(1) @binding(3) var slopes_out: texture_storage_2d<rgba16float, write>;

fn neighbour_height(job: DecodeJob, at: vec2<i32>) -> f32 {
    if any(at < vec2<i32>(0)) || any(at >= vec2<i32>(i32(job.stored_size))) {
        return NO_DATA_M;
    }
    return textureLoad(all_heights, vec2<i32>(i32(job.atlas_x), i32(job.atlas_y)) + at, 0).x;
}

@compute @workgroup_size(8, 8)
fn slopes(@builtin(global_invocation_id) id: vec3<u32>) {
    let job = jobs[id.z];
    if any(id.xy >= vec2<u32>(job.stored_size)) {
        return;
    }
    let at = vec2<i32>(id.xy);
    let centre_m = neighbour_height(job, at);
    var slope = vec4<f32>(0.0);
    if centre_m > NO_DATA_M {
        let west = neighbour_height(job, at + vec2<i32>(-1, 0));
        let east = neighbour_height(job, at + vec2<i32>(1, 0));
        let north = neighbour_height(job, at + vec2<i32>(0, -1));
        let south = neighbour_height(job, at + vec2<i32>(0, 1));
        slope = vec4<f32>(
            slope_along(centre_m, west, east, job.texel_size_m),
            slope_along(centre_m, south, north, job.texel_size_m),
            1.0, 0.0);
    }
    textureStore(slopes_out, vec2<u32>(job.atlas_x, job.atlas_y) + id.xy, slope);
}

@group(1) @binding(4) var slopes_in: texture_2d<f32>;

// The first halving. Slopes are linear in the heights, so their mean is the slope of the mean; coverage
// weights it. The outermost texel of the gutter takes in one-sided differences; no filter reads it.
@compute @workgroup_size(8, 8)
fn halve_slopes(@builtin(global_invocation_id) id: vec3<u32>) {
    let job = jobs[id.z];
    if any(id.xy >= vec2<u32>(job.stored_size / 2u)) {
        return;
    }
    let corner = vec2<u32>(job.atlas_x, job.atlas_y) + id.xy * 2u;
    var sum = vec3<f32>(0.0);
    for (var i = 0u; i < 4u; i++) {
        let slope = textureLoad(slopes_in, corner + vec2<u32>(i & 1u, i >> 1u), 0).xyz;
        sum += vec3<f32>(slope.xy * slope.z, slope.z);
    }
    let mean = vec4<f32>(sum.xy / max(sum.z, 1.0e-6), sum.z * 0.25, 0.0);
    let target_texel = vec2<u32>(job.atlas_x, job.atlas_y) / 2u + id.xy;
    textureStore(slopes_out, target_texel, mean);
}

// Difference over the pairs of which both hold data, a mip-1 texel apart; level where there is none.
fn slope_of_pairs(low_m: vec2<f32>, high_m: vec2<f32>, texel_size_m: f32) -> f32 {
    let holds = (low_m > vec2<f32>(NO_DATA_M)) & (high_m > vec2<f32>(NO_DATA_M));
    let differences = select(vec2<f32>(0.0), high_m - low_m, holds);
    let pairs = f32(holds.x) + f32(holds.y);
    return (differences.x + differences.y) / (max(pairs, 1.0) * texel_size_m);
}

// The second halving, whose gutter is a single texel: its slopes come from the heights under the texel
// itself. A mean of the finer slopes would take in the outermost of the gutter, which know one side only.
@compute @workgroup_size(8, 8)
fn coarsest_slopes(@builtin(global_invocation_id) id: vec3<u32>) {
    let job = jobs[id.z];
    if any(id.xy >= vec2<u32>(job.stored_size / 4u)) {
        return;
    }
    let corner = vec2<u32>(job.atlas_x, job.atlas_y) / 2u + id.xy * 2u;
    var heights_m = vec4<f32>(0.0);
    var coverage = 0.0;
    for (var i = 0u; i < 4u; i++) {
        let texel = corner + vec2<u32>(i & 1u, i >> 1u);
        heights_m[i] = textureLoad(heights_in, texel, 0).x;
        coverage += 0.25 * textureLoad(slopes_in, texel, 0).z;
    }
    let finer_texel_m = 2.0 * job.texel_size_m;
    let slope = vec4<f32>(
        slope_of_pairs(heights_m.xz, heights_m.yw, finer_texel_m),
        slope_of_pairs(heights_m.zw, heights_m.xy, finer_texel_m),
        coverage, 0.0);
    let target_texel = vec2<u32>(job.atlas_x, job.atlas_y) / 4u + id.xy;
    textureStore(slopes_out, target_texel, slope);
}
