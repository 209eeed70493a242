// Draws the globe with imagery through a page table, lit by its slopes as maps are, seen through the air.
// needs: common/frame.wgsl common/globe.wgsl common/page_table.wgsl common/page_colour.wgsl common/globe_place.wgsl common/globe_air.wgsl common/atmosphere.wgsl common/ground_light.wgsl common/page_debug.wgsl

override HAS_COLOURS: bool = true;

struct GroundVertex {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(perspective, centroid) relative_m: vec3<f32>,
    @location(1) @interpolate(perspective, centroid) height_m: f32,
    @location(2) @interpolate(perspective, centroid) slope: vec2<f32>,
    // At the pixel's middle, beside a triangle as well: llvmpipe (Mesa 22.3) divides centroids by the depth there.
    @location(3) clear: vec3<f32>,
}

@vertex
fn globe_vertex(vertex: GlobeVertex) -> GroundVertex {
    let relative_m = relative_place(vertex);
    let clip = frame.clip_from_relative * vec4<f32>(relative_m, 1.0);
    return GroundVertex(clip, relative_m, vertex.height_m, vertex.slope, globe_clear(relative_m));
}

@fragment
fn globe_fragment(in: GroundVertex) -> @location(0) vec4<f32> {
    let step_x_m = bounded_step(dpdx(in.relative_m), in.relative_m);
    let step_y_m = bounded_step(dpdy(in.relative_m), in.relative_m);
    let point = globe_point(in.relative_m, in.height_m);
    let footprint = globe_footprint(point, step_x_m, step_y_m);
    var bare = tint_by_height(in.height_m - globe.eye_height_m);
    if HAS_COLOURS {
        let imagery = page_colour(point.place, footprint);
        bare = mix(bare, imagery.rgb, imagery.a);
    }
    // Not from the fragment's own place: from space a ten-thousandth of the way is a kilometre of height, an eighth
    // of the air.
    let clear = clamp(in.clear, vec3<f32>(0.0), vec3<f32>(1.0));
    let lit = light(in.slope);
    if DEBUG_VIEW == DEBUG_OFF {
        return vec4<f32>(mix(frame.haze_colour, bare * lit, clear), 1.0);
    }
    if DEBUG_VIEW == DEBUG_SLOPES {
        return vec4<f32>(mix(frame.haze_colour, vec3<f32>(lit * 0.6), clear), 1.0);
    }
    let span = abs(row_span(point, ground_span(point, step_x_m))) + abs(row_span(point, ground_span(point, step_y_m)));
    return vec4<f32>(with_pages(bare * lit, point.place, footprint, span), 1.0);
}
