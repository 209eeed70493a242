// What pages of their virtual texture the pixels of models ask for: the first stage of finding visible pages.
// needs: common/frame.wgsl common/page_table.wgsl common/page_request.wgsl common/object.wgsl

struct RequestPoint {
    @builtin(position) clip: vec4<f32>,
    @location(0) uv: vec2<f32>,
    @location(1) @interpolate(flat) material: u32,
}

@vertex
fn request_vertex(corner: ObjectCorner) -> RequestPoint {
    let clip = frame.clip_from_relative * vec4<f32>(object_relative_m(corner), 1.0);
    return RequestPoint(clip, corner.uv, corner.material);
}

@fragment
fn request_fragment(in: RequestPoint) -> @location(0) vec2<u32> {
    let material = object_materials[in.material];
    let footprint = object_footprint(material, dpdxFine(in.uv), dpdyFine(in.uv));
    // Through gaps other surfaces are seen, and where gaps are is not known before the pages are there: every
    // second pixel asks for what lies behind.
    if material.alpha_cutoff > 0.0 && (u32(in.clip.x) + u32(in.clip.y)) % 2u == 1u {
        discard;
    }
    if footprint.level >= material.coarsest_level + 1.0 {
        return vec2<u32>(NO_REQUEST);
    }
    return page_request(object_place(material, in.uv), footprint);
}

// The depth alone, of all that hides what lies behind it.
@fragment
fn depth_fragment(in: RequestPoint) -> @location(0) f32 {
    if object_materials[in.material].alpha_cutoff > 0.0 {
        discard;
    }
    return in.clip.z;
}
