// Draws the displaced mesh: imagery of the finest cached tile, lit by the slopes, seen through haze.
// needs: common/frame.wgsl common/tile_lookup.wgsl common/surface_sample.wgsl common/colour_sample.wgsl common/atmosphere.wgsl common/ground_light.wgsl common/ground_slopes.wgsl common/tile_ground.wgsl

// A triangle that lies in one tile of each layer as a whole: the tiles come with its first vertex,
// and its fragments look nothing up.
struct WithinVertex {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(perspective, centroid) relative_m: vec3<f32>,
    // Part of the ground's light that comes through the air; see clear_at.
    @location(1) clear: f32,
    @location(2) @interpolate(flat) height_ground: vec3<f32>,
    @location(3) @interpolate(flat) colour_ground: vec3<f32>,
    @location(4) @interpolate(flat) atlas_texels: vec2<u32>,
}

@vertex
fn vertex_within(
    @location(0) relative_m: vec3<f32>,
    @location(1) height_ground: vec3<f32>,
    @location(2) height_texel: u32,
    @location(3) colour_ground: vec3<f32>,
    @location(4) colour_texel: u32,
) -> WithinVertex {
    let clip = frame.clip_from_relative * vec4<f32>(relative_m, 1.0);
    let texels = vec2<u32>(height_texel, colour_texel);
    return WithinVertex(clip, relative_m, transmittance(relative_m), height_ground, colour_ground, texels);
}

// A triangle across the border of tiles: each fragment looks its own tiles up.
struct AcrossVertex {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(perspective, centroid) relative_m: vec3<f32>,
    @location(1) clear: f32,
}

@vertex
fn vertex_across(@location(0) relative_m: vec3<f32>) -> AcrossVertex {
    let clip = frame.clip_from_relative * vec4<f32>(relative_m, 1.0);
    return AcrossVertex(clip, relative_m, transmittance(relative_m));
}

// As surface_within has it.
fn imagery_within(tile: TilePlace, pixel: Footprint) -> vec4<f32> {
    if ANISOTROPY == 1u {
        let place = texel_in_tile(tile, pixel.offset_m);
        return textureSample(colour_atlas, atlas_sampler, atlas_uv(tile, place, frame.colour_uv_per_texel));
    }
    return imagery_under(tile, pixel);
}

@fragment
fn fragment_within(in: WithinVertex) -> @location(0) vec4<f32> {
    let offset_m = in.relative_m.xy;
    let pixel = Footprint(offset_m, dpdx(offset_m), dpdy(offset_m));
    let height_tile = TilePlace(in.height_ground.xy, in.height_ground.z, in.atlas_texels.x);
    let surface = surface_within(height_tile, pixel);
    if HAS_VOIDS {
        if surface.z < 0.5 {
            discard;
        }
    }
    var bare = tint_by_height(in.relative_m.z);
    if HAS_COLOURS {
        let colour_tile = TilePlace(in.colour_ground.xy, in.colour_ground.z, in.atlas_texels.y);
        let imagery = imagery_within(colour_tile, pixel);
        bare = mix(bare, imagery.rgb, imagery.a);
    }
    return ground_colour(bare, surface.xy, clear_at(in.relative_m, in.clear));
}

@fragment
fn fragment_across(in: AcrossVertex) -> @location(0) vec4<f32> {
    let offset_m = in.relative_m.xy;
    var pixel = Footprint(offset_m, dpdx(offset_m), dpdy(offset_m));
    let position = fixed_from_offset(offset_m);

    let height_entry = tile_entries[find_tile(frame.height_table, position)];
    let surface = surface_under(height_entry.place, pixel);
    if HAS_VOIDS {
        if surface.z < 0.5 {
            discard;
        }
    }

    var bare = tint_by_height(in.relative_m.z);
    var shown = height_entry;
    var size = frame.height_tile_texels;
    if HAS_COLOURS {
        shown = tile_entries[find_tile(frame.colour_table, position)];
        size = frame.colour_tile_texels;
        pixel.offset_m = imaged_offset_m(shown.place, offset_m);
        let imagery = imagery_under(shown.place, pixel);
        bare = mix(bare, imagery.rgb, imagery.a);
    }
    let clear = clear_at(in.relative_m, in.clear);
    if DEBUG_VIEW == DEBUG_OFF {
        return ground_colour(bare, surface.xy, clear);
    }
    return debug_colour(bare, light(surface.xy), shown, pixel, size, clear);
}
