// Colours of a virtual texture through its page table: any geometry that knows its place in the texture and
// how it changes from pixel to pixel draws with these.
// needs page_table.wgsl

// A word a page: 0 where it is not there, else the column of its slot (8 bits), the row (8 bits) and how many of
// PARTS parts of it show, 1 at least.
@group(2) @binding(1) var<storage, read> page_entries: array<u32>;
// A slot has two mips of its own.
@group(2) @binding(2) var page_atlas: texture_2d<f32>;
@group(2) @binding(3) var page_sampler: sampler;

const PAGE_COARSEST_MIP: f32 = 2.0;
const PARTS: f32 = 4.0;

// Whether some pages may show in part only: a second sample for every tap. Fixed when the pipeline is built, since
// software renderers run both sides of a branch.
override FADES: bool = true;

struct FoundPage {
    level: u32,
    page: vec2<u32>,
    word: u32,
}

// The page that stands for a place at a level: the finest one there that is no finer. The coarsest page is
// always there.
fn find_page(place: TexturePlace, finest_level: u32) -> FoundPage {
    let finest = finest_page(place);
    var level = finest_level;
    var word = 0u;
    loop {
        word = page_entries[page_address(level, finest >> vec2<u32>(level))];
        if word != 0u || level >= pages.coarsest_level { break; }
        level += 1u;
    }
    return FoundPage(level, finest >> vec2<u32>(level), word);
}

// A filtered sample of a page at a level, a fraction: trilinear over the slot's mips, the first of which is
// the page itself and the next like the level above it.
fn sample_page(found: FoundPage, place: TexturePlace, level: f32) -> vec4<f32> {
    let mip = clamp(level - f32(found.level), 0.0, PAGE_COARSEST_MIP);
    let gutter = f32(pages.gutter_texels);
    let size = f32(pages.tile_texels);
    // Half a texel of the coarsest mip stays inside the gutter, and half a texel of the page inside the data,
    // whose outermost texels go on to the very edge. Where the texture goes round, the gutter holds what comes next.
    let margin = gutter - 0.5 * exp2(ceil(mip));
    let corner = page_corner(found.level, found.page);
    let scale = level_scale(found.level);
    let data_first = vec2<f32>(pages.data_first - corner) * scale + 0.5;
    let data_end = vec2<f32>(pages.data_end - corner) * scale - 0.5;
    let is_bounded = vec2<bool>(pages.round_texels == 0, true);
    let outer_first = vec2<f32>(-margin);
    let outer_end = vec2<f32>(size + margin);
    let first = select(outer_first, max(outer_first, data_first), is_bounded);
    let end = max(select(outer_end, min(outer_end, data_end), is_bounded), first);
    let inside = clamp(place_in_page(place, found.level, found.page), first, end);
    let slot = vec2<f32>(vec2<u32>(found.word & 0xffu, (found.word >> 8u) & 0xffu));
    let texel = slot * (size + 2.0 * gutter) + gutter + inside;
    return textureSampleLevel(page_atlas, page_sampler, texel * pages.uv_per_texel, mip);
}

// A tap at a place: of what is there, and as long as that has not come to show as a whole, of what is there
// besides.
fn page_tap(place: TexturePlace, finest_level: u32, level: f32) -> vec4<f32> {
    let found = find_page(place, finest_level);
    let colour = sample_page(found, place, level);
    if !FADES {
        return colour;
    }
    let part = f32(found.word >> 16u) / PARTS;
    if part >= 1.0 || found.level >= pages.coarsest_level {
        return colour;
    }
    return mix(sample_page(find_page(place, found.level + 1u), place, level), colour, part);
}

// The texture's colour under a pixel at a place: taps along the longer axis of its footprint, each filtered to
// the shorter one (after the usual definition of anisotropic filtering, as in
// EXT_texture_filter_anisotropic). Taps look their pages up each by itself, so that nothing changes at borders.
fn page_colour(place: TexturePlace, footprint: PageFootprint) -> vec4<f32> {
    let wanted = floor(footprint.level + pages.lookup_bias);
    let finest_level = u32(clamp(wanted, 0.0, f32(pages.coarsest_level)));
    // Whatever the page, it is filtered to the footprint: a coarser one than that asks for shows as sharp as it is.
    let level = footprint.level;
    if ANISOTROPY == 1u {
        return page_tap(place, finest_level, level);
    }
    var sum = vec4<f32>(0.0);
    for (var i = 0.0; i < footprint.taps; i += 1.0) {
        let offset = footprint.axis * ((i + 0.5) / footprint.taps - 0.5);
        sum += page_tap(place_from(place.texel, place.part + offset), finest_level, level);
    }
    return sum / footprint.taps;
}
