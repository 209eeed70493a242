// Draws the displaced mesh with imagery through a page table, lit by the slopes of the finest cached tile, seen
// through haze.
// needs: common/frame.wgsl common/tile_lookup.wgsl common/surface_sample.wgsl common/page_table.wgsl common/page_colour.wgsl common/page_ground.wgsl common/atmosphere.wgsl common/ground_light.wgsl common/ground_slopes.wgsl common/page_debug.wgsl

override HAS_COLOURS: bool = true;
// Whether there is ground without data, to be left out.
override HAS_VOIDS: bool = true;

// A triangle that lies in one height tile as a whole: the tile comes with its first vertex.
struct WithinVertex {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(perspective, centroid) relative_m: vec3<f32>,
    @location(1) clear: f32,
    @location(2) @interpolate(flat) height_ground: vec3<f32>,
    @location(3) @interpolate(flat) height_texel: u32,
}

@vertex
fn page_vertex_within(
    @location(0) relative_m: vec3<f32>,
    @location(1) height_ground: vec3<f32>,
    @location(2) height_texel: u32,
) -> WithinVertex {
    let clip = frame.clip_from_relative * vec4<f32>(relative_m, 1.0);
    return WithinVertex(clip, relative_m, transmittance(relative_m), height_ground, height_texel);
}

// A triangle across the border of height tiles: each fragment looks its own up.
struct AcrossVertex {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(perspective, centroid) relative_m: vec3<f32>,
    @location(1) clear: f32,
}

@vertex
fn page_vertex_across(@location(0) relative_m: vec3<f32>) -> AcrossVertex {
    let clip = frame.clip_from_relative * vec4<f32>(relative_m, 1.0);
    return AcrossVertex(clip, relative_m, transmittance(relative_m));
}

fn footprint_of(pixel: Footprint) -> PageFootprint {
    return page_footprint(ground_texels(pixel.step_x_m), ground_texels(pixel.step_y_m));
}

// The ground's own colour.
fn bare_ground(pixel: Footprint, relative_z_m: f32) -> vec3<f32> {
    let bare = tint_by_height(relative_z_m);
    if !HAS_COLOURS {
        return bare;
    }
    let imagery = page_colour(ground_place(pixel.offset_m), footprint_of(pixel));
    return mix(bare, imagery.rgb, imagery.a);
}

@fragment
fn page_fragment_within(in: WithinVertex) -> @location(0) vec4<f32> {
    let offset_m = in.relative_m.xy;
    let pixel = Footprint(offset_m, dpdxFine(offset_m), dpdyFine(offset_m));
    let height_tile = TilePlace(in.height_ground.xy, in.height_ground.z, in.height_texel);
    let surface = surface_within(height_tile, pixel);
    if HAS_VOIDS {
        if surface.z < 0.5 {
            discard;
        }
    }
    return ground_colour(bare_ground(pixel, in.relative_m.z), surface.xy, clear_at(in.relative_m, in.clear));
}

@fragment
fn page_fragment_across(in: AcrossVertex) -> @location(0) vec4<f32> {
    let offset_m = in.relative_m.xy;
    let pixel = Footprint(offset_m, dpdxFine(offset_m), dpdyFine(offset_m));
    let height_tile = tile_entries[find_tile(frame.height_table, fixed_from_offset(offset_m))].place;
    let surface = surface_under(height_tile, pixel);
    if HAS_VOIDS {
        if surface.z < 0.5 {
            discard;
        }
    }
    let bare = bare_ground(pixel, in.relative_m.z);
    let clear = clear_at(in.relative_m, in.clear);
    if DEBUG_VIEW == DEBUG_OFF {
        return ground_colour(bare, surface.xy, clear);
    }
    return debug_colour(bare, light(surface.xy), pixel, clear);
}

// The picture with what the debug view shows. Where borders of pages are drawn there is no haze over them.
fn debug_colour(bare: vec3<f32>, lit: f32, pixel: Footprint, clear: f32) -> vec4<f32> {
    if DEBUG_VIEW == DEBUG_SLOPES {
        return vec4<f32>(mix(frame.haze_colour, vec3<f32>(lit * 0.6), clear), 1.0);
    }
    let pixel_texels = (abs(pixel.step_x_m) + abs(pixel.step_y_m)) * page_ground.texels_per_m;
    let place = ground_place(pixel.offset_m);
    return vec4<f32>(with_pages(bare * lit, place, footprint_of(pixel), pixel_texels), 1.0);
}
