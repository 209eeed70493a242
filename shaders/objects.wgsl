// Draws models with their textures through a page table, lit by their normals, seen through haze.
// needs: common/frame.wgsl common/page_table.wgsl common/page_colour.wgsl common/object.wgsl common/atmosphere.wgsl common/ground_light.wgsl common/page_debug.wgsl

// Whether any material leaves parts out.
override HAS_CUTOUTS: bool = true;

struct ObjectPoint {
    @builtin(position) clip: vec4<f32>,
    @location(0) relative_m: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) uv: vec2<f32>,
    @location(3) @interpolate(flat) material: u32,
}

@vertex
fn object_vertex(corner: ObjectCorner) -> ObjectPoint {
    let relative_m = object_relative_m(corner);
    let clip = frame.clip_from_relative * vec4<f32>(relative_m, 1.0);
    return ObjectPoint(clip, relative_m, object_normal(corner), corner.uv, corner.material);
}

// The page that shows at a place.
fn shown_page(place: TexturePlace, footprint: PageFootprint) -> FoundPage {
    let wanted = floor(footprint.level + pages.lookup_bias);
    return find_page(place, u32(clamp(wanted, 0.0, f32(pages.coarsest_level))));
}

// A surface's own colour and coverage: from the texture, from the image's mean where all that there is of it is so
// coarse that its neighbours in the texture would show, or one for all.
fn object_colour(material: ObjectMaterial, place: TexturePlace, footprint: PageFootprint) -> vec4<f32> {
    if material.coarsest_level < 0.0 {
        return material.colour;
    }
    let level = max(footprint.level, f32(shown_page(place, footprint).level));
    let by_itself = clamp(material.coarsest_level + 1.0 - level, 0.0, 1.0);
    var texture = material.mean;
    if by_itself > 0.0 {
        texture = mix(texture, page_colour(place, footprint), by_itself);
    }
    return texture * material.colour;
}

@fragment
fn object_fragment(in: ObjectPoint, @builtin(front_facing) is_front: bool) -> @location(0) vec4<f32> {
    let material = object_materials[in.material];
    let footprint = object_footprint(material, dpdx(in.uv), dpdy(in.uv));
    let place = object_place(material, in.uv);
    let colour = object_colour(material, place, footprint);
    if HAS_CUTOUTS {
        if colour.a < material.alpha_cutoff {
            discard;
        }
    }
    let lit = light_on(normalize(select(-in.normal, in.normal, is_front)));
    let clear = transmittance(in.relative_m);
    if DEBUG_VIEW == DEBUG_OFF {
        return vec4<f32>(mix(frame.haze_colour, colour.rgb * lit, clear), 1.0);
    }
    if DEBUG_VIEW == DEBUG_SLOPES {
        return vec4<f32>(mix(frame.haze_colour, vec3<f32>(lit * 0.6), clear), 1.0);
    }
    // What has no texture stays as it is.
    if material.coarsest_level < 0.0 {
        return vec4<f32>(colour.rgb * lit, 1.0);
    }
    return vec4<f32>(with_pages(colour.rgb * lit, place, footprint, vec2<f32>(exp2(footprint.level))), 1.0);
}
