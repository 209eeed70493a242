// The coordinate pass's image as the passes that look through it see it.
// needs seen_ground.wgsl

@group(1) @binding(0) var coordinates: texture_2d<f32>;
@group(1) @binding(1) var<storage, read_write> seen: array<atomic<u32>>;

// What a pixel without ground holds, and more.
const SKY: f32 = 3.0e38;

struct GroundPixel {
    // Metres east and north.
    offset_m: vec2<f32>,
    is_ground: bool,
}

fn is_finite(value: f32) -> bool {
    return (bitcast<u32>(value) & 0x7f800000u) != 0x7f800000u;
}

// Sky outside the image.
fn pixel_at(pixel: vec2<u32>) -> GroundPixel {
    if any(pixel >= textureDimensions(coordinates)) {
        return GroundPixel(vec2<f32>(0.0), false);
    }
    let offset_m = textureLoad(coordinates, vec2<i32>(pixel), 0).xy;
    let is_ground = is_finite(offset_m.x) && is_finite(offset_m.y) && offset_m.x < SKY;
    return GroundPixel(offset_m, is_ground);
}
