// Ground made of triangles with imagery through a page table: its picture, what its pixels ask for, and where they
// look.
// needs: common/frame.wgsl common/page_table.wgsl common/page_colour.wgsl common/page_request.wgsl common/page_ground.wgsl common/atmosphere.wgsl common/ground_light.wgsl common/page_debug.wgsl

override HAS_COLOURS: bool = true;

struct TinPlace {
    // The ground's origin, metres east, north and up of the eye, heights exaggerated.
    origin_from_eye_m: vec3<f32>,
    padding: f32,
}

@group(1) @binding(0) var<uniform> tin_place: TinPlace;

struct TinPoint {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(perspective, centroid) relative_m: vec3<f32>,
    @location(1) clear: f32,
    @location(2) slope: vec2<f32>,
}

@vertex
fn tin_vertex(@location(0) position_m: vec3<f32>, @location(1) slope: vec2<f32>) -> TinPoint {
    let raised_m = vec3<f32>(position_m.xy, position_m.z * frame.vertical_exaggeration);
    let relative_m = tin_place.origin_from_eye_m + raised_m;
    let clip = frame.clip_from_relative * vec4<f32>(relative_m, 1.0);
    return TinPoint(clip, relative_m, transmittance(relative_m), slope);
}

@fragment
fn tin_fragment(in: TinPoint) -> @location(0) vec4<f32> {
    let offset_m = in.relative_m.xy;
    let step_x = ground_texels(dpdx(offset_m));
    let step_y = ground_texels(dpdy(offset_m));
    let place = ground_place(offset_m);
    let footprint = page_footprint(step_x, step_y);
    var bare = tint_by_height(in.relative_m.z);
    if HAS_COLOURS {
        let imagery = page_colour(place, footprint);
        bare = mix(bare, imagery.rgb, imagery.a);
    }
    let clear = clear_at(in.relative_m, in.clear);
    if DEBUG_VIEW == DEBUG_OFF {
        return ground_colour(bare, in.slope, clear);
    }
    if DEBUG_VIEW == DEBUG_SLOPES {
        return ground_colour(vec3<f32>(0.6), in.slope, clear);
    }
    return vec4<f32>(with_pages(bare * light(in.slope), place, footprint, abs(step_x) + abs(step_y)), 1.0);
}

@fragment
fn tin_request_fragment(in: TinPoint) -> @location(0) vec2<u32> {
    let offset_m = in.relative_m.xy;
    let footprint = page_footprint(ground_texels(dpdx(offset_m)), ground_texels(dpdy(offset_m)));
    return page_request(ground_place(offset_m), footprint);
}

@fragment
fn tin_coordinate_fragment(in: TinPoint) -> @location(0) vec4<f32> {
    return vec4<f32>(in.relative_m, 1.0);
}
