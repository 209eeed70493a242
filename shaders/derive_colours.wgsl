// Decodes an uploaded colour tile into the atlas, and halves it into the coarser mips of its slot. The
// target is a whole mip; a scissor rectangle keeps the draw to the slot. Texels are read and written
// as linear light.

@group(0) @binding(0) var source: texture_2d<f32>;

@vertex
fn cover(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    let corner = vec2<f32>(f32((index << 1u) & 2u), f32(index & 2u)) * 2.0 - 1.0;
    return vec4<f32>(corner, 0.0, 1.0);
}

@fragment
fn decode_colours(@builtin(position) pixel: vec4<f32>) -> @location(0) vec4<f32> {
    return textureLoad(source, vec2<u32>(pixel.xy), 0);
}

// Colours are weighted by their coverage: texels without imagery do not darken the mean.
@fragment
fn halve_colours(@builtin(position) pixel: vec4<f32>) -> @location(0) vec4<f32> {
    let corner = vec2<u32>(pixel.xy) * 2u;
    var sum = vec4<f32>(0.0);
    for (var i = 0u; i < 4u; i++) {
        let texel = textureLoad(source, corner + vec2<u32>(i & 1u, i >> 1u), 0);
        sum += vec4<f32>(texel.rgb * texel.a, texel.a);
    }
    return vec4<f32>(sum.rgb / max(sum.a, 1.0e-6), sum.a * 0.25);
}
