// Feedback as current engines do it, as a rival: of every block of pixels one, another each frame.

@group(0) @binding(0) var requests: texture_2d<u32>;
@group(0) @binding(1) var<storage, read_write> samples: array<vec2<u32>>;

struct Turn {
    // The pixel of every block.
    pixel: vec2<u32>,
    padding: vec2<u32>,
}

@group(0) @binding(2) var<uniform> turn: Turn;

const BLOCK_PX: u32 = 8u;

@compute @workgroup_size(8, 8)
fn sample_pages(@builtin(global_invocation_id) block: vec3<u32>) {
    let size = textureDimensions(requests);
    let blocks = (size + BLOCK_PX - 1u) / BLOCK_PX;
    if any(block.xy >= blocks) {
        return;
    }
    let pixel = block.xy * BLOCK_PX + turn.pixel;
    var request = vec2<u32>(0xffffffffu);
    if all(pixel < size) {
        request = textureLoad(requests, pixel, 0).xy;
    }
    samples[block.y * blocks.x + block.x] = request;
}
