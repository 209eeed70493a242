use std::mem::offset_of;

use encase::ShaderType;

use super::globe::{GlobeProbeAnswer, GlobeProbePoint};
use super::page_table::{PageProbeAnswer, PageProbePoint};
use crate::RendererSettings;
use crate::dataset::HeightSamples;
use crate::gpu::build_tile_table_pass::{BuildTileTablePass, TableSpace};
use crate::gpu::clipmap::{ClipBindings, ClipFrame, ClipHeightJob, ClipLevel, ClipSlopeJob};
use crate::gpu::derive_heights_pass::DecodeJob;
use crate::gpu::limit_surface_pass::{CastPixel, LimitUniforms};
use crate::gpu::manage_tiles_pass::{DeliveriesHead, ManageTilesPass, ManagedLayer, Slot};
use crate::gpu::mesh_buffers::MeshBuffers;
use crate::gpu::objects::{ObjectBuffers, ObjectMaterial};
use crate::gpu::page_table::{GatherPagesPass, PageMarks, SamplePagesPass, TinPlace};
use crate::gpu::place_tiles_pass::{Ground, PlacedLayer};
use crate::gpu::precision_probe::{Answer, Operands, Outcome, Results, Trial};
use crate::gpu::seen_ground_buffer::SeenGroundBuffer;
use crate::gpu::select_tiles_pass::SelectTilesPass;
use crate::gpu::shader_library::{
    ALL, BUILD_TILE_TABLE, CLIPMAP, CLIPMAP_HEIGHTS, DERIVE_HEIGHTS, DISPLACE, GATHER_PAGES,
    GLOBE_PROBE, HALVE_DEPTH, LIMIT_SURFACE, MANAGE_TILES, MAP_GROUND, MARK_SEEN_TILES,
    MERGE_TILES, OBJECTS, PAGE_PROBE, PAGE_TERRAIN, PAGE_TIN, PLACE_TILES, PRECISION_ENCODINGS,
    PRECISION_FLOATS, PRECISION_SPAN, REDUCE_REGION, SAMPLE_PAGES, SUBDIVIDE_TILES, Shader,
    TERRAIN, WITH_OTHER_FLOATS,
};
use crate::gpu::tile_report::TileReport;
use crate::gpu::{
    CoordinatePass, FrameUniforms, GlobeUniforms, MipRange, PageGround, PageTableUniforms,
    TableRange, TextureMapUniforms, TileEntry, TilePlace,
};
use crate::precision::encodings::{Decoded, EncodedPoint};
use crate::residency::page_table::PageRequest;
use crate::selection::{LISTED_AT_MOST, SeenTiles, SelectionParams};
use crate::surface::globe::SplitPlace;
use crate::surface::models::WrapMode;
use crate::surface::{ClipBlock, MeshVertex};

fn parse(shader: &Shader) -> naga::Module {
    naga::front::wgsl::parse_str(&shader.source()).unwrap_or_else(|error| {
        panic!("{}: {}", shader.name, error.emit_to_string(&shader.source()))
    })
}

/// Names and offsets of a WGSL struct's members, and its size.
fn wgsl_layout(shader: &Shader, name: &str) -> (Vec<(String, u32)>, u32) {
    let module = parse(shader);
    for (_, found) in module.types.iter() {
        if found.name.as_deref() != Some(name) {
            continue;
        }
        if let naga::TypeInner::Struct { members, span } = &found.inner {
            let member = |m: &naga::StructMember| (m.name.clone().unwrap_or_default(), m.offset);
            return (members.iter().map(member).collect(), *span);
        }
    }
    panic!("{} has no struct {name}", shader.name);
}

/// The value of a WGSL constant as written.
fn wgsl_constant(shader: &Shader, name: &str) -> naga::Literal {
    let module = parse(shader);
    let constant = module.constants.iter().find(|(_, found)| found.name.as_deref() == Some(name));
    let init = constant.map(|(_, found)| &module.global_expressions[found.init]);
    match init {
        Some(naga::Expression::Literal(literal)) => *literal,
        _ => panic!("{} has no constant {name}", shader.name),
    }
}

#[test]
fn what_is_no_height_is_the_same_on_both_sides() {
    let word = u32::from(HeightSamples::NO_DATA_WORD);
    assert_eq!(wgsl_constant(&DERIVE_HEIGHTS, "NO_DATA_WORD"), naga::Literal::U32(word));
    let most = HeightSamples::MOST_HEIGHT_M;
    assert_eq!(wgsl_constant(&DERIVE_HEIGHTS, "MOST_HEIGHT_M"), naga::Literal::F32(most));
}

fn named(pairs: &[(&str, usize)]) -> Vec<(String, u32)> {
    pairs.iter().map(|&(name, offset)| (name.to_owned(), offset as u32)).collect()
}

#[test]
fn every_shader_is_valid() {
    use naga::valid::Capabilities;
    let plain = ALL.map(|shader| (shader, Capabilities::empty()));
    let floats = Capabilities::FLOAT64 | Capabilities::SHADER_FLOAT16;
    for (shader, features) in plain.into_iter().chain(WITH_OTHER_FLOATS.map(|s| (s, floats))) {
        let module = parse(shader);
        let mut validator =
            naga::valid::Validator::new(naga::valid::ValidationFlags::all(), features);
        let outcome = validator.validate(&module);
        assert!(outcome.is_ok(), "{}: {:?}", shader.name, outcome.err());
    }
}

#[test]
fn every_shader_names_the_parts_it_is_put_together_from() {
    for shader in ALL {
        let own = shader.source();
        let needs = own.lines().find_map(|line| line.strip_prefix("// needs: ")).unwrap_or("");
        let parts = shader.part_names().map(|part| format!("common/{part}.wgsl"));
        assert_eq!(needs, parts.collect::<Vec<_>>().join(" "), "{}", shader.name);
    }
}

macro_rules! offsets {
    ($type:ty: $($member:ident),+ $(,)?) => {
        named(&[$((stringify!($member), offset_of!($type, $member))),+])
    };
}

#[test]
fn plain_structs_have_the_same_members_offsets_and_sizes() {
    let place = offsets!(TilePlace: origin_from_eye_m, texels_per_m, atlas_texel);
    assert_eq!(wgsl_layout(&TERRAIN, "TilePlace"), (place, size_of::<TilePlace>() as u32));
    let entry = offsets!(TileEntry: place, level, column, row, padding);
    assert_eq!(wgsl_layout(&TERRAIN, "TileEntry"), (entry, size_of::<TileEntry>() as u32));
    let job = offsets!(DecodeJob: atlas_x, atlas_y, first_word, is_float, base_steps, step_m, texel_size_m, stored_size);
    assert_eq!(wgsl_layout(&DERIVE_HEIGHTS, "DecodeJob"), (job, size_of::<DecodeJob>() as u32));
    // The mesh's pair of floats is two members in WGSL, whose vec2 would be aligned to 8 bytes.
    let vertex = named(&[
        ("east", offset_of!(MeshVertex, offset)),
        ("north", offset_of!(MeshVertex, offset) + 4),
        ("spacing", offset_of!(MeshVertex, spacing)),
    ]);
    assert_eq!(wgsl_layout(&DISPLACE, "MeshVertex"), (vertex, size_of::<MeshVertex>() as u32));
    let displaced = wgsl_layout(&DISPLACE, "DisplacedVertex");
    assert_eq!(u64::from(displaced.1), MeshBuffers::VERTEX_BYTES);
    let members = displaced.0.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>();
    assert_eq!(members, ["height_tile", "colour_tile", "cells", "x", "y", "z"]);
    let offset = |name| displaced.0[members.iter().position(|&member| member == name).unwrap()].1;
    let texel = std::mem::offset_of!(TilePlace, atlas_texel) as u32;
    let (height, colour) = (offset("height_tile"), offset("colour_tile"));
    let read = [offset("x"), height, height + texel, colour, colour + texel].map(u64::from);
    assert_eq!(MeshBuffers::ATTRIBUTES.map(|attribute| attribute.offset), read);
}

#[test]
fn structs_of_the_clipmap_have_the_same_members_offsets_and_sizes() {
    let level = offsets!(ClipLevel: origin_from_eye_m, texels_per_m, texel_m, shown, whole,
        texture_texel, padding);
    assert_eq!(wgsl_layout(&CLIPMAP, "ClipLevel"), (level, size_of::<ClipLevel>() as u32));
    let frame = offsets!(ClipFrame: reference_from_eye_m, unit_m, ring_cells, patch_columns,
        mesh_level, height_levels, colour_levels, height_fade_texels, colour_fade_texels);
    assert_eq!(wgsl_layout(&CLIPMAP, "ClipFrame"), (frame, size_of::<ClipFrame>() as u32));
    let block = offsets!(ClipBlock: corner, cells, ring_and_flags);
    assert_eq!(wgsl_layout(&CLIPMAP, "ClipBlock"), (block, size_of::<ClipBlock>() as u32));
    let job = offsets!(ClipHeightJob: target_x, target_y, layer, width, height, first_group,
        first_word, form, base_steps, step_m);
    let size = size_of::<ClipHeightJob>() as u32;
    assert_eq!(wgsl_layout(&CLIPMAP_HEIGHTS, "ClipHeightJob"), (job, size));
    let job = offsets!(ClipSlopeJob: target_x, target_y, layer, width, height, first_group,
        known_west, known_north, known_east, known_south, texel_size_m);
    let size = size_of::<ClipSlopeJob>() as u32;
    assert_eq!(wgsl_layout(&CLIPMAP_HEIGHTS, "ClipSlopeJob"), (job, size));
    let most = naga::Literal::U32(ClipBindings::MOST_LEVELS as u32);
    assert_eq!(wgsl_constant(&CLIPMAP, "MOST_LEVELS"), most);
    for (name, flag) in [
        ("WEST", ClipBlock::WEST),
        ("NORTH", ClipBlock::NORTH),
        ("EAST", ClipBlock::EAST),
        ("SOUTH", ClipBlock::SOUTH),
        ("ODD_COLUMN", ClipBlock::ODD_COLUMN),
        ("ODD_ROW", ClipBlock::ODD_ROW),
        ("OUTERMOST", ClipBlock::OUTERMOST),
    ] {
        assert_eq!(wgsl_constant(&CLIPMAP, name), naga::Literal::U32(flag), "{name}");
    }
}

#[test]
fn structs_of_the_page_table_have_the_same_members_offsets_and_sizes() {
    let table = offsets!(PageTableUniforms: columns, rows, tile_texels, gutter_texels, coarsest_level,
        first_resident_level, round_texels, padding, data_first, data_end, uv_per_texel, request_bias,
        lookup_bias, level_starts);
    let size = size_of::<PageTableUniforms>() as u32;
    assert_eq!(wgsl_layout(&PAGE_TERRAIN, "PageTable"), (table, size));
    let ground = offsets!(PageGround: anchor_texel, anchor_from_eye_m, texels_per_m, padding);
    let size = size_of::<PageGround>() as u32;
    assert_eq!(wgsl_layout(&PAGE_TERRAIN, "PageGround"), (ground, size));
    let map = offsets!(TextureMapUniforms: cells, cell_texels, cells_per_page_log2, viewport_px,
        ranges, padding);
    let size = size_of::<TextureMapUniforms>() as u32;
    assert_eq!(wgsl_layout(&MAP_GROUND, "TextureMap"), (map, size));
    let size = 2 * size_of::<MipRange>() as u32;
    let (members, span) = wgsl_layout(&HALVE_DEPTH, "Mip");
    let names = ["start", "width", "height", "padding"];
    let finer = names.map(|name| format!("finer_{name}"));
    let named = names.map(str::to_owned).into_iter().chain(finer);
    assert_eq!((members, span), (named.zip((0..).step_by(4)).collect(), size));
    let point = offsets!(PageProbePoint: st, span_x, span_y, padding);
    let size = size_of::<PageProbePoint>() as u32;
    assert_eq!(wgsl_layout(&PAGE_PROBE, "PageProbePoint"), (point, size));
    let answer = offsets!(PageProbeAnswer: colour, texel, part, request, in_page, level, taps,
        found_level, found_word);
    let size = size_of::<PageProbeAnswer>() as u32;
    assert_eq!(wgsl_layout(&PAGE_PROBE, "PageProbeAnswer"), (answer, size));
    let list = wgsl_layout(&GATHER_PAGES, "PageList").0;
    let pages = ("pages".to_owned(), PageMarks::HEAD_BYTES as u32);
    assert_eq!(list.last(), Some(&pages));
    let most = naga::Literal::U32(PageMarks::MOST_LISTED);
    assert_eq!(wgsl_constant(&GATHER_PAGES, "MOST_LISTED"), most);
    let block = naga::Literal::U32(GatherPagesPass::BLOCK_PX);
    assert_eq!(wgsl_constant(&GATHER_PAGES, "BLOCK_PX"), block);
    let block = naga::Literal::U32(SamplePagesPass::BLOCK_PX);
    assert_eq!(wgsl_constant(&SAMPLE_PAGES, "BLOCK_PX"), block);
    for (name, steps) in [("STEPS", PageRequest::STEPS), ("STEPS_BELOW", PageRequest::STEPS_BELOW)]
    {
        assert_eq!(wgsl_constant(&PAGE_PROBE, name), naga::Literal::I32(steps), "{name}");
    }
}

#[test]
fn structs_of_the_globe_have_the_same_members_offsets_and_sizes() {
    let point = offsets!(GlobeProbePoint: coarse, height_m, fine, padding);
    let size = size_of::<GlobeProbePoint>() as u32;
    assert_eq!(wgsl_layout(&GLOBE_PROBE, "GlobeProbePoint"), (point, size));
    let answer = offsets!(GlobeProbeAnswer: clip, relative_m, cos_latitude, texel, part, east,
        texels_per_m_east, north, texels_per_m_south, clear, padding, sky, padding_too);
    let size = size_of::<GlobeProbeAnswer>() as u32;
    assert_eq!(wgsl_layout(&GLOBE_PROBE, "GlobeProbeAnswer"), (answer, size));
    let (members, size) = wgsl_layout(&GLOBE_PROBE, "Globe");
    let names = members.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>();
    assert_eq!(names, GlobeUniforms::MEMBER_NAMES);
    for (index, (name, offset)) in members.iter().enumerate() {
        let here = GlobeUniforms::METADATA.offset(index);
        assert_eq!(u64::from(*offset), here, "{name}");
    }
    assert_eq!(u64::from(size), GlobeUniforms::BYTES);
    assert_eq!(
        wgsl_constant(&GLOBE_PROBE, "COARSE_M"),
        naga::Literal::F32(SplitPlace::COARSE_M as f32)
    );
    assert_eq!(
        wgsl_constant(&GLOBE_PROBE, "FINE_M"),
        naga::Literal::F32(SplitPlace::FINE_M as f32)
    );
}

#[test]
fn structs_of_the_models_have_the_same_members_offsets_and_sizes() {
    let material = offsets!(ObjectMaterial: colour, mean, first_texel, size_texels, wrap,
        coarsest_level, alpha_cutoff);
    let size = size_of::<ObjectMaterial>() as u32;
    assert_eq!(wgsl_layout(&OBJECTS, "ObjectMaterial"), (material, size));
    let place = offsets!(TinPlace: origin_from_eye_m, padding);
    assert_eq!(wgsl_layout(&PAGE_TIN, "TinPlace"), (place, size_of::<TinPlace>() as u32));
    for (name, mode) in [("WRAP_MIRROR", WrapMode::Mirror), ("WRAP_CLAMP", WrapMode::Clamp)] {
        assert_eq!(wgsl_constant(&OBJECTS, name), naga::Literal::U32(mode.code()), "{name}");
    }
    // Vertices and instances as who binds them as storage finds them.
    let [vertex, instance] = ObjectBuffers::vertex_layouts().map(Option::unwrap);
    let offsets = |layout: &wgpu::VertexBufferLayout<'_>| {
        layout.attributes.iter().map(|attribute| attribute.offset / 4).collect::<Vec<_>>()
    };
    assert_eq!((vertex.array_stride, offsets(&vertex)), (36, vec![0, 3, 6, 8]));
    assert_eq!((instance.array_stride, offsets(&instance)), (48, vec![0, 4, 8]));
}

#[test]
fn structs_of_the_tile_management_have_the_same_members_offsets_and_sizes() {
    let layer = offsets!(ManagedLayer: slot_count, finest_level, padding);
    let size = size_of::<ManagedLayer>() as u32;
    assert_eq!(wgsl_layout(&MANAGE_TILES, "ManagedLayer"), (layer, size));
    let slot = offsets!(Slot: level, row, column, state, last_wanted);
    assert_eq!(wgsl_layout(&MANAGE_TILES, "Slot"), (slot, size_of::<Slot>() as u32));
    let (mut deliveries, _) = wgsl_layout(&MANAGE_TILES, "Deliveries");
    let tiles = deliveries.pop();
    assert_eq!(deliveries, offsets!(DeliveriesHead: frame, padding, counts));
    assert_eq!(tiles, Some(("tiles".to_owned(), size_of::<DeliveriesHead>() as u32)));
    let (report, size) = wgsl_layout(&MANAGE_TILES, "Report");
    assert_eq!(report.last(), Some(&("asked".to_owned(), TileReport::HEAD_BYTES as u32)));
    assert_eq!(u64::from(size), ManageTilesPass::REPORT_BYTES);
    for (shader, name, value) in [
        (&MANAGE_TILES, "MOST_SLOTS", ManageTilesPass::MOST_SLOTS),
        (&MANAGE_TILES, "MOST_ASKED", ManageTilesPass::MOST_ASKED),
        (&BUILD_TILE_TABLE, "MOST_SLOTS", ManageTilesPass::MOST_SLOTS),
        (&PLACE_TILES, "MOST_SLOTS", ManageTilesPass::MOST_SLOTS),
    ] {
        assert_eq!(wgsl_constant(shader, name), naga::Literal::U32(value), "{name}");
    }
    let space = offsets!(TableSpace: entries, nodes);
    assert_eq!(wgsl_layout(&BUILD_TILE_TABLE, "TableSpace"), (space, 8));
    let (table, _) = wgsl_layout(&BUILD_TILE_TABLE, "ShownTiles");
    assert_eq!(table[1].1, BuildTileTablePass::RANGES_BYTES as u32);
    let layer = offsets!(PlacedLayer: columns, slot_texels, gutter_texels, texels_per_m, step_texels,
        step_bits, padding);
    let size = size_of::<PlacedLayer>() as u32;
    assert_eq!(wgsl_layout(&PLACE_TILES, "PlacedLayer"), (layer, size));
    let ground = offsets!(Ground: metres_mantissa, metres_exponent, padding, layers);
    assert_eq!(wgsl_layout(&PLACE_TILES, "Ground"), (ground, size_of::<Ground>() as u32));
    // Structs that several shaders name.
    for (name, one, other) in [
        ("TableRange", &PLACE_TILES, &TERRAIN),
        ("TableRange", &BUILD_TILE_TABLE, &TERRAIN),
        ("TilePlace", &PLACE_TILES, &TERRAIN),
        ("TileEntry", &PLACE_TILES, &TERRAIN),
        ("ShownSlots", &BUILD_TILE_TABLE, &MANAGE_TILES),
        ("ShownTiles", &BUILD_TILE_TABLE, &PLACE_TILES),
    ] {
        assert_eq!(wgsl_layout(one, name), wgsl_layout(other, name), "{name}");
    }
    let slots = RendererSettings::MOST_SLOTS_A_SIDE * RendererSettings::MOST_SLOTS_A_SIDE;
    assert!(slots <= ManageTilesPass::MOST_SLOTS);
}

#[test]
fn structs_of_the_limit_surface_have_the_same_members_offsets_and_sizes() {
    let uniforms = offsets!(
        LimitUniforms: ray_corner, cell_m, ray_per_column, lowest_m, ray_per_row, highest_m, eye,
        ray_angle, background, rays, eye_cell, grid_size, uv_origin, uv_per_cell, size_px, texel_m,
        top_level, levels
    );
    let size = size_of::<LimitUniforms>() as u32;
    assert_eq!(wgsl_layout(&LIMIT_SURFACE, "LimitUniforms"), (uniforms, size));
    let pixel = offsets!(CastPixel: linear, triangle, distance_m, hits, words, places);
    assert_eq!(wgsl_layout(&LIMIT_SURFACE, "CastPixel"), (pixel, size_of::<CastPixel>() as u32));
}

#[test]
fn what_the_precision_probes_send_and_receive_has_the_same_layout() {
    let point = offsets!(EncodedPoint: world, world_low, eye, eye_low, corner, corner_low, from_eye,
        corner_from_eye, shipped_corner_from_eye, fraction, eye_fraction, tile, eye_tile, fixed,
        eye_fixed, corner_fixed, tile_size_m, texels_per_m, tile_size_texels, unit_m, texels_per_unit,
        padding);
    let layout = |name| wgsl_layout(&PRECISION_ENCODINGS, name);
    assert_eq!(layout("EncodedPoint"), (point, size_of::<EncodedPoint>() as u32));
    let decoded = offsets!(Decoded: relative_m, place_texels);
    assert_eq!(layout("Decoded"), (decoded, size_of::<Decoded>() as u32));
    let answer = offsets!(Answer: decoded, position);
    assert_eq!(layout("Answer"), (answer, size_of::<Answer>() as u32));
    let trial = offsets!(Trial: range, half_pixel_rad, texel_part, bits);
    assert_eq!(wgsl_layout(&PRECISION_SPAN, "Trial"), (trial, size_of::<Trial>() as u32));
    let outcome = offsets!(Outcome: moved, level, texture);
    assert_eq!(wgsl_layout(&PRECISION_SPAN, "Outcome"), (outcome, size_of::<Outcome>() as u32));
    let operands = offsets!(Operands: a, b, c);
    assert_eq!(
        wgsl_layout(&PRECISION_FLOATS, "Operands"),
        (operands, size_of::<Operands>() as u32)
    );
    let results = offsets!(Results: plain, fused, quotient, sum_error, product_error);
    assert_eq!(wgsl_layout(&PRECISION_FLOATS, "Results"), (results, size_of::<Results>() as u32));
}

#[test]
fn what_the_selection_goes_by_has_the_same_layout() {
    let params = offsets!(SelectionParams: eye, doublings, anchor, anchor_from_origin_m, eye_ground,
        layer_finest, units_per_m, max_tiles, height_levels, is_exact, is_by_error, padding,
        split_below);
    let size = size_of::<SelectionParams>() as u32;
    assert_eq!(wgsl_layout(&MARK_SEEN_TILES, "SelectionParams"), (params, size));
    let node_bytes = SelectTilesPass::NODE_BYTES as u32;
    assert_eq!(wgsl_layout(&MERGE_TILES, "TileNode").1, node_bytes);
    let arena = wgsl_layout(&MERGE_TILES, "TileArena");
    let nodes = ("nodes".to_owned(), SelectTilesPass::ARENA_HEAD_BYTES as u32);
    assert_eq!(arena.0.last(), Some(&nodes));
    let lists = wgsl_layout(&MERGE_TILES, "TileLists");
    assert_eq!(u64::from(lists.1), SelectTilesPass::LISTS_BYTES);
    let sky = naga::Literal::F32(CoordinatePass::SKY);
    assert_eq!(wgsl_constant(&REDUCE_REGION, "SKY"), sky);
    let pixels = wgsl_constant(&REDUCE_REGION, "SEEN_PIXELS");
    assert_eq!(pixels, naga::Literal::U32((SeenGroundBuffer::BOX_BYTES / 4) as u32 - 1));
    let header = wgsl_constant(&REDUCE_REGION, "SEEN_HEADER");
    assert_eq!(header, naga::Literal::U32((SeenGroundBuffer::HEADER_BYTES / 4) as u32));
    let across = naga::Literal::U32(SeenTiles::MOST_TILES_ACROSS);
    assert_eq!(wgsl_constant(&MARK_SEEN_TILES, "MOST_TILES_ACROSS"), across);
    let most = naga::Literal::U32(SeenTiles::MOST_TILES);
    assert_eq!(wgsl_constant(&MARK_SEEN_TILES, "MOST_SEEN_TILES"), most);
    let listed = naga::Literal::U32(LISTED_AT_MOST as u32);
    assert_eq!(wgsl_constant(&SUBDIVIDE_TILES, "LISTED_AT_MOST"), listed);
}

#[test]
fn the_uniforms_have_the_same_members_offsets_and_sizes() {
    let (members, size) = wgsl_layout(&TERRAIN, "FrameUniforms");
    let rust = FrameUniforms::MEMBER_NAMES
        .iter()
        .enumerate()
        .map(|(index, name)| ((*name).to_owned(), FrameUniforms::METADATA.offset(index) as u32))
        .collect::<Vec<_>>();
    assert_eq!(members, rust);
    assert_eq!(u64::from(size), FrameUniforms::BYTES);

    assert_eq!(
        FrameUniforms::METADATA.offset(members.len() - 2),
        FrameUniforms::TABLE_RANGES_OFFSET
    );

    let (members, size) = wgsl_layout(&TERRAIN, "TableRange");
    let names = ["first_entry", "entry_count", "first_node", "root_word"];
    let rust = (0..4).map(|i| (names[i].to_owned(), TableRange::METADATA.offset(i) as u32));
    assert_eq!((members, size), (rust.collect(), 16));
}
