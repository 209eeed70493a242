// A virtual texture cut into pages, and places in it: nothing here knows what it is drawn on. Levels count
// from the finest, 0. The twins are `PageLayout`, `TexturePlace` and `Footprint` in the library.

struct PageTable {
    // Pages of level 0; of every further level half as many a side, rounded up.
    columns: u32,
    rows: u32,
    // Texels along a page's side without its gutter, and of the gutter.
    tile_texels: u32,
    gutter_texels: u32,
    coarsest_level: u32,
    // From this level on all pages are always resident.
    first_resident_level: u32,
    // Texels of level 0 once round, where what leaves the texture in the east comes back in the west; 0 where it ends.
    round_texels: i32,
    padding: u32,
    // First texel of level 0 that holds data, and the one after the last.
    data_first: vec2<i32>,
    data_end: vec2<i32>,
    // Parts of the atlas's sides that a texel is wide and high.
    uv_per_texel: vec2<f32>,
    // Levels that pixels ask for beside those of their footprints, and that they are drawn from.
    request_bias: f32,
    lookup_bias: f32,
    // Where each level begins in tables over all pages, four to a vector.
    level_starts: array<vec4<u32>, 7>,
}

@group(2) @binding(0) var<uniform> pages: PageTable;

// Most taps along the longer axis of a pixel's footprint; 1 filters isotropically.
override ANISOTROPY: u32 = 4u;

// Where a page stands in a table over all pages.
fn page_address(level: u32, page: vec2<u32>) -> u32 {
    let columns = (pages.columns + (1u << level) - 1u) >> level;
    return pages.level_starts[level / 4u][level % 4u] + page.y * columns + page.x;
}

// A place in the texture: a texel of level 0, and the part of the way across it.
struct TexturePlace {
    texel: vec2<i32>,
    part: vec2<f32>,
}

// The texel that stands for this one: where the texture goes round, the same in its own turn.
fn turned(texel: vec2<i32>) -> vec2<i32> {
    let round = pages.round_texels;
    if round == 0 {
        return texel;
    }
    // A quotient in floats is one off at the most, which saves a division of integers: those are dear.
    var x = texel.x - i32(floor(f32(texel.x) / f32(round))) * round;
    x += select(0, round, x < 0);
    x -= select(0, round, x >= round);
    return vec2<i32>(x, texel.y);
}

// The place so many texels of level 0 from a texel's north-west corner; where the texture goes round, in its own
// turn.
fn place_from(texel: vec2<i32>, offset_texels: vec2<f32>) -> TexturePlace {
    let whole = floor(offset_texels);
    return TexturePlace(turned(texel + vec2<i32>(whole)), offset_texels - whole);
}

// The place at texture coordinates (s, t), both from 0 to 1 over all that holds data.
fn place_at(st: vec2<f32>) -> TexturePlace {
    return place_from(pages.data_first, st * vec2<f32>(pages.data_end - pages.data_first));
}

// The page of level 0 (column, row) that holds the place. Places beyond the texture belong to its outermost
// pages, so that s = 1 and t = 1 have one.
fn finest_page(place: TexturePlace) -> vec2<u32> {
    let texel = max(place.texel, vec2<i32>(0));
    let tile = i32(pages.tile_texels);
    // One off at the most, as in `turned`.
    var page = vec2<i32>(vec2<f32>(texel) / f32(tile));
    page -= select(vec2<i32>(0), vec2<i32>(1), page * tile > texel);
    page += select(vec2<i32>(0), vec2<i32>(1), (page + 1) * tile <= texel);
    return min(vec2<u32>(page), vec2<u32>(pages.columns, pages.rows) - 1u);
}

// Texels of a level to one of level 0: exactly 2^-level.
fn level_scale(level: u32) -> f32 {
    return bitcast<f32>((127u - level) << 23u);
}

// North-west corner of a page, in texels of level 0.
fn page_corner(level: u32, page: vec2<u32>) -> vec2<i32> {
    return vec2<i32>(page * (pages.tile_texels << level));
}

// Where a place lies in a page that holds it, in texels of the page's level from its north-west corner.
fn place_in_page(place: TexturePlace, level: u32, page: vec2<u32>) -> vec2<f32> {
    let whole = vec2<f32>(place.texel - page_corner(level, page));
    return (whole + place.part) * level_scale(level);
}

// What of the texture lies under a pixel.
struct PageFootprint {
    // The level whose texels are as large as a tap; below 0 where texels are magnified.
    level: f32,
    taps: f32,
    // The longer side, along which the taps lie.
    axis: vec2<f32>,
}

// The footprint of a pixel whose sides are so many texels of level 0 long.
fn page_footprint(span_x: vec2<f32>, span_y: vec2<f32>) -> PageFootprint {
    let square_x = dot(span_x, span_x);
    let square_y = dot(span_y, span_y);
    let major = max(max(square_x, square_y), 1.0e-12);
    var taps = 1.0;
    if ANISOTROPY > 1u {
        // Taps closer than a texel find nothing new.
        let minor = max(min(square_x, square_y), 1.0);
        taps = clamp(ceil(sqrt(major / minor)), 1.0, f32(ANISOTROPY));
    }
    let axis = select(span_y, span_x, square_x > square_y);
    return PageFootprint(0.5 * log2(major) - log2(taps), taps, axis);
}
