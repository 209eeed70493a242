// The first stage of finding visible pages: what each pixel of the ground asks for. The target, the paper's
// texture U1, has the size of the frame.
// needs: common/frame.wgsl common/tile_lookup.wgsl common/surface_sample.wgsl common/page_table.wgsl common/page_request.wgsl common/page_ground.wgsl

override HAS_VOIDS: bool = true;

struct RequestVertex {
    @builtin(position) clip: vec4<f32>,
    @location(0) relative_m: vec3<f32>,
}

@vertex
fn request_vertex(@location(0) relative_m: vec3<f32>) -> RequestVertex {
    return RequestVertex(frame.clip_from_relative * vec4<f32>(relative_m, 1.0), relative_m);
}

@fragment
fn request_fragment(in: RequestVertex) -> @location(0) vec2<u32> {
    let offset_m = in.relative_m.xy;
    let footprint = page_footprint(ground_texels(dpdxFine(offset_m)), ground_texels(dpdyFine(offset_m)));
    if HAS_VOIDS {
        let entry = tile_entries[find_tile(frame.height_table, fixed_from_offset(offset_m))];
        if sample_slope(entry.place, texel_in_tile(entry.place, offset_m), 0.0).z < 0.5 {
            discard;
        }
    }
    return page_request(ground_place(offset_m), footprint);
}

// The depth alone, of all that asks.
@fragment
fn depth_fragment(in: RequestVertex) -> @location(0) f32 {
    if HAS_VOIDS {
        let entry = tile_entries[find_tile(frame.height_table, fixed_from_offset(in.relative_m.xy))];
        if sample_slope(entry.place, texel_in_tile(entry.place, in.relative_m.xy), 0.0).z < 0.5 {
            discard;
        }
    }
    return in.clip.z;
}
