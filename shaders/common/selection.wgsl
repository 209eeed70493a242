// What tiles are selected by: the eye in units of the root, the squared distances below which tiles
// are split, and the ground last seen. The twins are `EyeUnits` and `GroundUnits` in the library.
// needs whole_numbers.wgsl

struct SelectionParams {
    // East and south of the root's north-west corner, and up.
    eye: vec3<i32>,
    // How often the unit was doubled so that it reaches the eye.
    doublings: u32,
    // For offsets of the coordinate image: the root's point nearest to where they count from.
    anchor: vec2<i32>,
    anchor_from_origin_m: vec2<f32>,
    // The unit below or next to the eye, in units that were not doubled.
    eye_ground: vec2<i32>,
    // The finest level of the heights and of the colours.
    layer_finest: vec2<u32>,
    units_per_m: f32,
    max_tiles: u32,
    height_levels: u32,
    // Whether only what pixels saw counts as visible, and not all of the box round it.
    is_exact: u32,
    // Whether tiles of the least error are merged, and not the farthest.
    is_by_error: u32,
    padding: u32,
    split_below: array<vec2<u32>, 27>,
}

@group(0) @binding(0) var<storage, read> params: SelectionParams;
// The lowest and the highest ground of the coarse tiles in units, level by level.
@group(0) @binding(1) var<storage, read> height_units: array<vec2<i32>>;

fn tile_heights(level: u32, row: u32, column: u32) -> vec2<i32> {
    if params.height_levels == 0u {
        return vec2<i32>(-1073741824, 1073741824);
    }
    let known = min(level, params.height_levels - 1u);
    let up = level - known;
    let first = ((1u << (2u * known)) - 1u) / 3u;
    return height_units[first + ((row >> up) << known) + (column >> up)];
}

fn squared_gap(eye: i32, low: i32, high: i32) -> vec2<u32> {
    // Up to 2^31, which only numbers without a sign hold.
    var gap = 0u;
    if eye < low {
        gap = bitcast<u32>(low) - bitcast<u32>(eye);
    } else if eye > high {
        gap = bitcast<u32>(eye) - bitcast<u32>(high);
    }
    return square(gap);
}

fn squared_gap_beside(eye: i32, index: u32, side: u32) -> vec2<u32> {
    let round_up = (1u << params.doublings) - 1u;
    let low = (index << side) >> params.doublings;
    let high = (((index + 1u) << side) + round_up) >> params.doublings;
    return squared_gap(eye, i32(low), i32(high));
}

fn squared_distance(level: u32, row: u32, column: u32) -> vec2<u32> {
    let side = 30u - level;
    let heights = tile_heights(level, row, column);
    let beside = sum(
        squared_gap_beside(params.eye.x, column, side),
        squared_gap_beside(params.eye.y, row, side),
    );
    return sum(beside, squared_gap(params.eye.z, heights.x, heights.y));
}

// Offsets in metres east and north as units from the anchor, not yet whole.
fn units_from_anchor(offset_m: vec2<f32>) -> vec2<f32> {
    let from_anchor_m = offset_m - params.anchor_from_origin_m;
    let units = vec2<f32>(from_anchor_m.x, -from_anchor_m.y) * params.units_per_m;
    return clamp(units, vec2<f32>(-1073741760.0), vec2<f32>(1073741760.0));
}
