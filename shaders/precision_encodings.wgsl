// Decodes points in every encoding of places, so that the error is the device's own. The lookup and the
// place in the tile are the renderer's.
// needs: common/frame.wgsl common/tile_lookup.wgsl

// A point, the eye and the point's tile. Pairs are east and north, those of tiles and of fixed point east
// and south.
struct EncodedPoint {
    // World coordinates narrowed to f32, and what that left over.
    world: vec2<f32>,
    world_low: vec2<f32>,
    eye: vec2<f32>,
    eye_low: vec2<f32>,
    // The tile's north-west corner.
    corner: vec2<f32>,
    corner_low: vec2<f32>,
    // Differences from the eye, taken in f64.
    from_eye: vec2<f32>,
    corner_from_eye: vec2<f32>,
    // Likewise the corner of the tile that the renderer's lookup finds.
    shipped_corner_from_eye: vec2<f32>,
    // Part of the tile's side from its north-west corner.
    fraction: vec2<f32>,
    eye_fraction: vec2<f32>,
    tile: vec2<i32>,
    eye_tile: vec2<i32>,
    // 2^30 units to the root's side.
    fixed: vec2<i32>,
    eye_fixed: vec2<i32>,
    corner_fixed: vec2<i32>,
    tile_size_m: f32,
    texels_per_m: f32,
    tile_size_texels: f32,
    unit_m: f32,
    texels_per_unit: f32,
    padding: u32,
}

struct Decoded {
    // Metres east and north of the eye.
    relative_m: vec2<f32>,
    // Texels east and south of the tile's corner.
    place_texels: vec2<f32>,
}

// An answer for each encoding, in the order of `Encoding::ALL`, and where the renderer's lookup searches.
struct Answer {
    decoded: array<Decoded, 6>,
    position: vec2<i32>,
}

@group(2) @binding(0) var<storage, read> points: array<EncodedPoint>;
@group(2) @binding(1) var<storage, read_write> answers: array<Answer>;

// North turned to south, or the reverse.
const FLIP: vec2<f32> = vec2<f32>(1.0, -1.0);

fn absolute(p: EncodedPoint) -> Decoded {
    return Decoded(p.world - p.eye, FLIP * (p.world - p.corner) * p.texels_per_m);
}

fn relative(p: EncodedPoint, corner_from_eye: vec2<f32>) -> Decoded {
    let tile = TilePlace(corner_from_eye, p.texels_per_m, 0u);
    return Decoded(p.from_eye, texel_in_tile(tile, p.from_eye));
}

fn tile_relative(p: EncodedPoint) -> Decoded {
    let tiles = vec2<f32>(p.tile - p.eye_tile) + (p.fraction - p.eye_fraction);
    return Decoded(FLIP * tiles * p.tile_size_m, p.fraction * p.tile_size_texels);
}

fn split_pair(p: EncodedPoint) -> Decoded {
    let from_eye = (p.world - p.eye) + (p.world_low - p.eye_low);
    let from_corner = (p.world - p.corner) + (p.world_low - p.corner_low);
    return Decoded(from_eye, FLIP * from_corner * p.texels_per_m);
}

fn fixed_point(p: EncodedPoint) -> Decoded {
    let from_eye = vec2<f32>(p.fixed - p.eye_fixed) * p.unit_m;
    return Decoded(FLIP * from_eye, vec2<f32>(p.fixed - p.corner_fixed) * p.texels_per_unit);
}

@compute @workgroup_size(64)
fn decode(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&points) {
        return;
    }
    let p = points[id.x];
    answers[id.x] = Answer(
        array<Decoded, 6>(
            absolute(p), relative(p, p.corner_from_eye), tile_relative(p), split_pair(p), fixed_point(p),
            relative(p, p.shipped_corner_from_eye)),
        fixed_from_offset(p.from_eye));
}
