// Triangles laid into a texture map: rasterised at their texture coordinates instead of their places in the picture,
// so that what the map's texels mark is what of the texture is needed. After the paper on texture maps (rendering
// of virtual textures with back faces dropped before rasterisation).
//
// A map texel, here a *cell*, is a page or a part of one. The map has mips: each triangle goes into that whose cells
// are no larger than the finest pages it may show. What the picture's rasterisation does is emulated for a triangle's
// part in a cell, by bounds that are never too narrow: so the pages marked contain those that pixels need.
// needs frame.wgsl page_table.wgsl

struct TextureMap {
    // Cells of the finest mip.
    cells: vec2<u32>,
    // Texels of level 0 along a side of its cells, and how often a page's side is halved for it.
    cell_texels: u32,
    cells_per_page_log2: u32,
    viewport_px: vec2<f32>,
    // Ranges of triangles.
    ranges: u32,
    padding: u32,
}

@group(3) @binding(5) var<uniform> map: TextureMap;
// The farthest depth of the scene, mip by mip; see halve_depth.wgsl.
@group(3) @binding(6) var<storage, read> farthest_depth: array<f32>;

const NO_TRIANGLE: u32 = 0xffffffffu;
// Places closer to the eye's plane than this part of the distance to it have no place in the picture to speak of.
const LEAST_W: f32 = 1.0e-4;
// Rasterisation rounds places in the picture to 1/256 of a pixel.
const THINNEST_PX: f32 = 0.00390625;

struct MapCorner {
    relative_m: vec3<f32>,
    // From the triangle's anchor.
    texels: vec2<f32>,
}

struct MapTriangle {
    // A texel of level 0.
    anchor: vec2<i32>,
    a: MapCorner,
    b: MapCorner,
    c: MapCorner,
    // Whether it shows parts of the texture that do not lie together: any of so many texels from the anchor.
    is_scattered: bool,
    scattered_over: vec2<f32>,
    // Pixels that are coarser by a level or more ask for nothing.
    coarsest_level: f32,
    // Whether its back shows as well.
    is_two_sided: bool,
}

// A rectangle of the texture, in texels from a triangle's anchor.
struct TexelRect {
    low: vec2<f32>,
    high: vec2<f32>,
}

// What of the picture a part of a triangle may cover.
struct PictureBounds {
    // Pixels from the upper left.
    low_px: vec2<f32>,
    high_px: vec2<f32>,
    // Distances along the view, in metres.
    near_w: f32,
    far_w: f32,
    nearest_depth: f32,
    // Whether it reaches behind the eye, so that there are no bounds.
    is_open: bool,
}

// The paper's test: the eye, the origin here, lies on the side of the triangle that its corners run round to the left
// on. No length is needed. Nearly edge-on counts as seen, since rasterisation rounds.
fn faces_eye(t: MapTriangle) -> bool {
    if t.is_two_sided {
        return true;
    }
    let normal = cross(t.b.relative_m - t.a.relative_m, t.c.relative_m - t.a.relative_m);
    let towards = -dot(t.a.relative_m, normal);
    return towards >= -1.0e-5 * length(t.a.relative_m) * length(normal);
}

fn clip_of(relative_m: vec3<f32>) -> vec4<f32> {
    return frame.clip_from_relative * vec4<f32>(relative_m, 1.0);
}

fn is_before_eye(clip: vec4<f32>) -> bool {
    return clip.w > LEAST_W * length(clip.xyw);
}

fn pixel_of(clip: vec4<f32>) -> vec2<f32> {
    return (vec2<f32>(clip.x, -clip.y) / clip.w * 0.5 + 0.5) * map.viewport_px;
}

// Whether a triangle in the picture is thinner than rasterisation tells places apart, such as those that a mesh is
// closed with along the border of its data. It covers no pixels, and what its footprints are floats do not tell.
fn is_line(a: vec4<f32>, b: vec4<f32>, c: vec4<f32>) -> bool {
    if !(is_before_eye(a) && is_before_eye(b) && is_before_eye(c)) {
        return false;
    }
    let first = pixel_of(b) - pixel_of(a);
    let second = pixel_of(c) - pixel_of(a);
    let longest = max(length(first), max(length(second), length(second - first)));
    return abs(first.x * second.y - first.y * second.x) <= THINNEST_PX * longest;
}

// Whether all of a triangle lies beyond one side of the picture, or it is none.
fn is_out_of_picture(a: vec4<f32>, b: vec4<f32>, c: vec4<f32>) -> bool {
    return is_outside(a, b, c) || is_line(a, b, c);
}

fn is_outside(a: vec4<f32>, b: vec4<f32>, c: vec4<f32>) -> bool {
    let x = vec3<f32>(a.x, b.x, c.x);
    let y = vec3<f32>(a.y, b.y, c.y);
    let w = vec3<f32>(a.w, b.w, c.w);
    return all(w <= vec3<f32>(0.0)) || all(x > w) || all(-x > w) || all(y > w) || all(-y > w);
}

// What of the texture a triangle shows.
fn rect_of(t: MapTriangle) -> TexelRect {
    if t.is_scattered {
        return TexelRect(vec2<f32>(0.0), t.scattered_over);
    }
    return corner_rect(t);
}

fn corner_rect(t: MapTriangle) -> TexelRect {
    return TexelRect(
        min(t.a.texels, min(t.b.texels, t.c.texels)),
        max(t.a.texels, max(t.b.texels, t.c.texels)),
    );
}

fn bounds_of_none() -> PictureBounds {
    return PictureBounds(vec2<f32>(1.0e30), vec2<f32>(-1.0e30), 1.0e30, 0.0, 0.0, false);
}

fn with_point(bounds: PictureBounds, clip: vec4<f32>) -> PictureBounds {
    var out = bounds;
    if !is_before_eye(clip) {
        out.is_open = true;
        return out;
    }
    let pixel = pixel_of(clip);
    out.low_px = min(out.low_px, pixel);
    out.high_px = max(out.high_px, pixel);
    out.near_w = min(out.near_w, clip.w);
    out.far_w = max(out.far_w, clip.w);
    out.nearest_depth = max(out.nearest_depth, clip.z / clip.w);
    return out;
}

fn bounds_of(a: vec4<f32>, b: vec4<f32>, c: vec4<f32>) -> PictureBounds {
    return with_point(with_point(with_point(bounds_of_none(), a), b), c);
}

// How a triangle's place in the picture changes from texel to texel; zero where its corners lie on a line of the
// texture, so that nothing can be told from texels.
struct TexelAxes {
    x: vec3<f32>,
    y: vec3<f32>,
    is_known: bool,
}

fn texel_axes(t: MapTriangle) -> TexelAxes {
    let first = t.b.texels - t.a.texels;
    let second = t.c.texels - t.a.texels;
    let twice_area = first.x * second.y - first.y * second.x;
    let edge_1 = t.b.relative_m - t.a.relative_m;
    let edge_2 = t.c.relative_m - t.a.relative_m;
    // Thinner than this floats do not tell the axes.
    if abs(twice_area) <= 1.0e-4 * length(first) * length(second) {
        return TexelAxes(vec3<f32>(0.0), vec3<f32>(0.0), false);
    }
    return TexelAxes(
        (edge_1 * second.y - edge_2 * first.y) / twice_area,
        (edge_2 * first.x - edge_1 * second.x) / twice_area,
        true,
    );
}

// What of the picture the part of a triangle within a rectangle may cover: no more than the triangle does, and than
// its plane does over the rectangle.
fn bounds_in(t: MapTriangle, whole: PictureBounds, rect: TexelRect) -> PictureBounds {
    let axes = texel_axes(t);
    if !axes.is_known || t.is_scattered {
        return whole;
    }
    var part = bounds_of_none();
    for (var i = 0u; i < 4u; i++) {
        let corner = select(rect.low, rect.high, vec2<bool>((i & 1u) != 0u, (i & 2u) != 0u));
        let from_a = corner - t.a.texels;
        part = with_point(part, clip_of(t.a.relative_m + axes.x * from_a.x + axes.y * from_a.y));
    }
    if part.is_open { return whole; }
    if whole.is_open { return part; }
    return PictureBounds(
        max(part.low_px, whole.low_px),
        min(part.high_px, whole.high_px),
        max(part.near_w, whole.near_w),
        min(part.far_w, whole.far_w),
        min(part.nearest_depth, whole.nearest_depth),
        false,
    );
}

// Whether any pixel's centre may lie in the bounds, and in front of all that is drawn there.
fn may_show(bounds: PictureBounds) -> bool {
    if bounds.is_open {
        return true;
    }
    // Rasterisation rounds places to parts of a pixel.
    let low = bounds.low_px - 0.01;
    let high = bounds.high_px + 0.01;
    let first = ceil(low - 0.5);
    let last = floor(high - 0.5);
    if any(last < vec2<f32>(0.0)) || any(first >= map.viewport_px) || any(first > last) {
        return false;
    }
    let first_px = vec2<u32>(max(first, vec2<f32>(0.0)));
    let last_px = vec2<u32>(min(last, map.viewport_px - 1.0));
    let span = last_px - first_px;
    // Of this mip the pixels lie in two places a side at the most.
    let halvings = firstLeadingBit(max(max(span.x, span.y), 1u) * 2u - 1u);
    var size = vec2<u32>(map.viewport_px);
    var start = 0u;
    for (var i = 0u; i < halvings; i++) {
        start += size.x * size.y;
        size = max(size >> vec2<u32>(1u), vec2<u32>(1u));
    }
    // What is left over by halvings belongs to the outermost places.
    let low_place = min(first_px >> vec2<u32>(halvings), size - 1u);
    let high_place = min(last_px >> vec2<u32>(halvings), size - 1u);
    var farthest = 1.0;
    for (var y = low_place.y; y <= high_place.y; y++) {
        for (var x = low_place.x; x <= high_place.x; x++) {
            farthest = min(farthest, farthest_depth[start + y * size.x + x]);
        }
    }
    return bounds.nearest_depth * 1.0001 >= farthest;
}

// How the sides of pixels' footprints lie on a triangle's plane: each is w (axis - texel per_w), for a texel from the
// origin at w metres along the view. From homogeneous places in the picture, which need no clipping (after Olano and
// Greer, "Triangle Scan Conversion using 2D Homogeneous Coordinates", 1997).
struct FootprintField {
    axis_x: vec2<f32>,
    axis_y: vec2<f32>,
    per_w: vec2<f32>,
    // A texel from the triangle's anchor.
    origin: vec2<f32>,
    is_known: bool,
}

fn footprint_field(t: MapTriangle, origin: vec2<f32>) -> FootprintField {
    let clips = array<vec4<f32>, 3>(clip_of(t.a.relative_m), clip_of(t.b.relative_m), clip_of(t.c.relative_m));
    let scale = 0.5 * map.viewport_px;
    // Places in the picture from that of the first corner, so that small triangles far from the picture's centre
    // lose nothing.
    var centre = vec2<f32>(0.0);
    if is_before_eye(clips[0]) {
        centre = clips[0].xy / clips[0].w;
    }
    var places: array<vec3<f32>, 3>;
    for (var i = 0; i < 3; i++) {
        let clip = clips[i];
        places[i] = vec3<f32>((clip.x - centre.x * clip.w) * scale.x, (centre.y * clip.w - clip.y) * scale.y, clip.w);
    }
    let sides = array<vec3<f32>, 3>(
        cross(places[1], places[2]),
        cross(places[2], places[0]),
        cross(places[0], places[1]),
    );
    let determinant = dot(places[0], sides[0]);
    if abs(determinant) <= 0.0 {
        return FootprintField(vec2<f32>(0.0), vec2<f32>(0.0), vec2<f32>(0.0), origin, false);
    }
    let texels = array<vec2<f32>, 3>(t.a.texels - origin, t.b.texels - origin, t.c.texels - origin);
    let along_x = (texels[0].x * sides[0] + texels[1].x * sides[1] + texels[2].x * sides[2]) / determinant;
    let along_y = (texels[0].y * sides[0] + texels[1].y * sides[1] + texels[2].y * sides[2]) / determinant;
    let one = (sides[0] + sides[1] + sides[2]) / determinant;
    return FootprintField(
        vec2<f32>(along_x.x, along_y.x),
        vec2<f32>(along_x.y, along_y.y),
        one.xy,
        origin,
        true,
    );
}

// The finest and the coarsest level that a pixel may ask for whose centre lies in the rectangle.
fn level_bounds(field: FootprintField, bounds: PictureBounds, rect: TexelRect) -> vec2<f32> {
    let everything = vec2<f32>(-1.0e9, 1.0e9);
    if bounds.is_open || !field.is_known {
        return everything;
    }
    let centre = 0.5 * (rect.low + rect.high) - field.origin;
    let radius = 0.5 * length(rect.high - rect.low);
    let middle = vec2<f32>(
        length(field.axis_x - centre * field.per_w.x),
        length(field.axis_y - centre * field.per_w.y),
    );
    let reach = abs(field.per_w) * radius;
    // Pixels take the difference to their neighbour in the row or column instead of the derivative. It is the
    // neighbour's w times (axis - texel per_w), exactly.
    let near_w = 1.0 / (1.0 / bounds.near_w + abs(field.per_w));
    let far_w = 1.0 / max(1.0 / bounds.far_w - abs(field.per_w), vec2<f32>(1.0e-9));
    return levels_between(max(middle - reach, vec2<f32>(0.0)) * near_w * 0.999, (middle + reach) * far_w * 1.001);
}

// The least and the greatest level of `page_footprint` for footprints whose sides lie within bounds.
fn levels_between(shortest: vec2<f32>, longest: vec2<f32>) -> vec2<f32> {
    let major = max(vec2<f32>(max(shortest.x, shortest.y), max(longest.x, longest.y)), vec2<f32>(1.0e-6));
    if ANISOTROPY == 1u {
        return log2(major);
    }
    let most = f32(ANISOTROPY);
    let minor = max(vec2<f32>(min(shortest.x, shortest.y), min(longest.x, longest.y)), vec2<f32>(1.0));
    // A tap is the longer side over the number of taps, so no longer than the shorter side but where taps run out; and
    // of k taps no shorter than k - 1 parts of k of it.
    let least_taps = ceil(major.x / minor.y);
    let most_taps = clamp(ceil(major.y / minor.x), 1.0, most);
    let fewest = max(floor(major.x / minor.y), 0.0);
    let shortest_tap = max(major.x / most_taps, minor.x * fewest / (fewest + 1.0));
    let longest_tap = min(major.y / clamp(least_taps, 1.0, most), max(minor.y, major.y / most));
    return log2(vec2<f32>(shortest_tap, longest_tap));
}

// A triangle laid into the map: the mip it goes into, and its cells there, first and last.
struct LaidTriangle {
    mip: u32,
    first: vec2<u32>,
    last: vec2<u32>,
    is_in_picture: bool,
}

fn cells_under(t: MapTriangle, rect: TexelRect, mip: u32) -> vec4<u32> {
    let size = i32(map.cell_texels << mip);
    let low = (t.anchor + vec2<i32>(floor(rect.low))) / size;
    let high = (t.anchor + vec2<i32>(floor(rect.high))) / size;
    let last = (vec2<i32>(map.cells) - 1) >> vec2<u32>(mip);
    return vec4<u32>(vec4<i32>(clamp(low, vec2<i32>(0), last), clamp(high, vec2<i32>(0), last)));
}

// Lays a triangle into the map, unless all of it lies outside of the picture.
fn lay(t: MapTriangle) -> LaidTriangle {
    let a = clip_of(t.a.relative_m);
    let b = clip_of(t.b.relative_m);
    let c = clip_of(t.c.relative_m);
    if is_out_of_picture(a, b, c) || t.coarsest_level < 0.0 {
        return LaidTriangle(0u, vec2<u32>(0u), vec2<u32>(0u), false);
    }
    let around = corner_rect(t);
    let field = footprint_field(t, 0.5 * (around.low + around.high));
    let finest = level_bounds(field, bounds_of(a, b, c), around).x + pages.request_bias;
    let mip = u32(clamp(finest, 0.0, f32(pages.coarsest_level)));
    let cells = cells_under(t, rect_of(t), mip);
    return LaidTriangle(mip, cells.xy, cells.zw, true);
}

// The part of the texture in a cell of a mip, from the triangle's anchor; the outermost cells go on for ever.
fn rect_of_cell(t: MapTriangle, cell: vec2<u32>, mip: u32) -> TexelRect {
    let size = i32(map.cell_texels << mip);
    let low = vec2<f32>(vec2<i32>(cell) * size - t.anchor);
    let last = (map.cells - 1u) >> vec2<u32>(mip);
    return TexelRect(
        select(low, vec2<f32>(-1.0e30), cell == vec2<u32>(0u)),
        select(low + f32(size), vec2<f32>(1.0e30), cell == last),
    );
}

// Whether a triangle reaches into a rectangle: whether no edge of either parts them. A triangle without area in
// the texture counts as its rectangle.
fn reaches_into(t: MapTriangle, rect: TexelRect) -> bool {
    if t.is_scattered {
        return true;
    }
    let corners = array<vec2<f32>, 3>(t.a.texels, t.b.texels, t.c.texels);
    let first = corners[1] - corners[0];
    let second = corners[2] - corners[0];
    let twice_area = first.x * second.y - first.y * second.x;
    let side = sign(twice_area);
    // Places round by a part of their distance from the anchor.
    let slack = 1.0 + 1.0e-5 * (abs(corners[0].x) + abs(corners[0].y));
    for (var i = 0u; i < 3u; i++) {
        let edge = corners[(i + 1u) % 3u] - corners[i];
        let inwards = vec2<f32>(-edge.y, edge.x) * side;
        let farthest = select(rect.low, rect.high, inwards > vec2<f32>(0.0)) - corners[i];
        if dot(farthest, inwards) < -slack * (abs(inwards.x) + abs(inwards.y)) {
            return false;
        }
    }
    return true;
}
