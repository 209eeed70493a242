// Draws a mesh that was made on the CPU for the view: imagery of the finest cached tile, lit by the
// slopes at the vertices, seen through haze.
// needs: common/frame.wgsl common/tile_lookup.wgsl common/surface_sample.wgsl common/colour_sample.wgsl common/atmosphere.wgsl common/ground_light.wgsl common/tile_ground.wgsl common/view_mesh_vertex.wgsl

struct GroundVertex {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(perspective, centroid) relative_m: vec3<f32>,
    // Part of the ground's light that comes through the air; see clear_at.
    @location(1) clear: f32,
    // Slopes, and the part of the ground that holds data.
    @location(2) @interpolate(perspective, centroid) surface: vec3<f32>,
}

@vertex
fn ground_vertex(vertex: SentVertex) -> GroundVertex {
    let relative_m = place_of(vertex);
    let clip = frame.clip_from_relative * vec4<f32>(relative_m, 1.0);
    let surface = vec3<f32>(vertex.slope, coverage_of(vertex));
    return GroundVertex(clip, relative_m, transmittance(relative_m), surface);
}

@fragment
fn ground_fragment(in: GroundVertex) -> @location(0) vec4<f32> {
    let offset_m = in.relative_m.xy;
    var pixel = Footprint(offset_m, dpdx(offset_m), dpdy(offset_m));
    if HAS_VOIDS {
        if in.surface.z < 0.5 {
            discard;
        }
    }
    let clear = clear_at(in.relative_m, in.clear);
    let tint = tint_by_height(in.relative_m.z);
    if !HAS_COLOURS {
        if DEBUG_VIEW == DEBUG_SLOPES {
            return vec4<f32>(mix(frame.haze_colour, vec3<f32>(light(in.surface.xy) * 0.6), clear), 1.0);
        }
        return ground_colour(tint, in.surface.xy, clear);
    }
    let shown = tile_entries[find_tile(frame.colour_table, fixed_from_offset(offset_m))];
    pixel.offset_m = imaged_offset_m(shown.place, offset_m);
    let imagery = imagery_under(shown.place, pixel);
    let bare = mix(tint, imagery.rgb, imagery.a);
    if DEBUG_VIEW == DEBUG_OFF {
        return ground_colour(bare, in.surface.xy, clear);
    }
    return debug_colour(bare, light(in.surface.xy), shown, pixel, frame.colour_tile_texels, clear);
}
