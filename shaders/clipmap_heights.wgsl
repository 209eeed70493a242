// What the GPU makes of the height texels sent to a clipmap: heights in metres at the places where they
// wrap round to, and the slopes of all texels that now have another neighbour.
// needs: common/stored_heights.wgsl

struct ClipHeightJob {
    // North-west texel in the texture; a part that is sent does not wrap round.
    target_x: u32,
    target_y: u32,
    layer: u32,
    width: u32,
    height: u32,
    // Workgroups of all jobs before this one.
    first_group: u32,
    first_word: u32,
    // As in StoredSamples; 2: there is no data, and nothing is sent.
    form: u32,
    base_steps: i32,
    step_m: f32,
}

struct ClipSlopeJob {
    // North-west texel in the texture; from there on the job wraps round.
    target_x: u32,
    target_y: u32,
    layer: u32,
    width: u32,
    height: u32,
    first_group: u32,
    // Columns and rows from that texel on whose heights are known.
    known_west: i32,
    known_north: i32,
    known_east: i32,
    known_south: i32,
    texel_size_m: f32,
}

const FORM_EMPTY: u32 = 2u;
const GROUP: u32 = 64u;

@group(0) @binding(0) var<storage, read> height_jobs: array<ClipHeightJob>;
@group(0) @binding(2) var heights_out: texture_storage_2d_array<r32float, write>;

fn group_number(group: vec3<u32>, groups: vec3<u32>) -> u32 {
    return group.y * groups.x + group.x;
}

// The last job that begins at or before the group.
fn height_job_of(group: u32) -> u32 {
    var low = 0u;
    var high = arrayLength(&height_jobs);
    while high - low > 1u {
        let middle = (low + high) / 2u;
        if height_jobs[middle].first_group <= group { low = middle; } else { high = middle; }
    }
    return low;
}

@compute @workgroup_size(GROUP)
fn decode(
    @builtin(workgroup_id) group_id: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let group = group_number(group_id, groups);
    let job = height_jobs[height_job_of(group)];
    let index = (group - job.first_group) * GROUP + lane;
    if index >= job.width * job.height {
        return;
    }
    var height_m = NO_DATA_M;
    if job.form != FORM_EMPTY {
        height_m = stored_height(StoredSamples(job.first_word, job.form, job.base_steps, job.step_m), index);
    }
    let texel = vec2<u32>(job.target_x + index % job.width, job.target_y + index / job.width);
    textureStore(heights_out, texel, job.layer, vec4<f32>(height_m, 0.0, 0.0, 0.0));
}

@group(1) @binding(0) var<storage, read> slope_jobs: array<ClipSlopeJob>;
@group(1) @binding(1) var heights_in: texture_2d_array<f32>;
@group(1) @binding(2) var slopes_out: texture_storage_2d_array<rgba16float, write>;

fn slope_job_of(group: u32) -> u32 {
    var low = 0u;
    var high = arrayLength(&slope_jobs);
    while high - low > 1u {
        let middle = (low + high) / 2u;
        if slope_jobs[middle].first_group <= group { low = middle; } else { high = middle; }
    }
    return low;
}

fn wrapped(job: ClipSlopeJob, at: vec2<i32>) -> vec2<i32> {
    let side = vec2<i32>(i32(textureDimensions(heights_in).x));
    return (vec2<i32>(i32(job.target_x), i32(job.target_y)) + at + side) % side;
}

fn known_height(job: ClipSlopeJob, at: vec2<i32>) -> f32 {
    let is_west_or_north = any(at < vec2<i32>(job.known_west, job.known_north));
    if is_west_or_north || any(at >= vec2<i32>(job.known_east, job.known_south)) {
        return NO_DATA_M;
    }
    return textureLoad(heights_in, wrapped(job, at), job.layer, 0).x;
}

@compute @workgroup_size(GROUP)
fn slopes(
    @builtin(workgroup_id) group_id: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let group = group_number(group_id, groups);
    let job = slope_jobs[slope_job_of(group)];
    let index = (group - job.first_group) * GROUP + lane;
    if index >= job.width * job.height {
        return;
    }
    let at = vec2<i32>(i32(index % job.width), i32(index / job.width));
    let centre_m = known_height(job, at);
    var slope = vec4<f32>(0.0);
    if centre_m > NO_DATA_M {
        let west = known_height(job, at + vec2<i32>(-1, 0));
        let east = known_height(job, at + vec2<i32>(1, 0));
        let north = known_height(job, at + vec2<i32>(0, -1));
        let south = known_height(job, at + vec2<i32>(0, 1));
        slope = vec4<f32>(
            slope_along(centre_m, west, east, job.texel_size_m),
            slope_along(centre_m, south, north, job.texel_size_m),
            1.0, 0.0);
    }
    textureStore(slopes_out, wrapped(job, at), job.layer, slope);
}
