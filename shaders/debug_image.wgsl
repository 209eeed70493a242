// Pictures of the renderer's own textures, for people to look at. The source is stretched over the
// whole target; colours are written as they are to be seen (sRGB-encoded).

@group(0) @binding(0) var source: texture_2d<f32>;
// x, y: what is drawn darkest and brightest, metres; z, w: width and height of the target in pixels.
@group(0) @binding(1) var<uniform> range: vec4<f32>;

@vertex
fn cover(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    let corner = vec2<f32>(f32((index << 1u) & 2u), f32(index & 2u)) * 2.0 - 1.0;
    return vec4<f32>(corner, 0.0, 1.0);
}

fn load_source(pixel: vec4<f32>) -> vec4<f32> {
    let size = vec2<f32>(textureDimensions(source));
    return textureLoad(source, vec2<u32>(pixel.xy / range.zw * size), 0);
}

// Offsets from the eye in metres: east as red, north as green, both grey at 0; sky is blue.
@fragment
fn show_coordinates(@builtin(position) pixel: vec4<f32>) -> @location(0) vec4<f32> {
    let offset = load_source(pixel).xy;
    if any(abs(offset) > vec2<f32>(1.0e30)) {
        return vec4<f32>(0.15, 0.25, 0.55, 1.0);
    }
    let shown = 0.5 + 0.5 * offset / (abs(offset) + range.y);
    return vec4<f32>(shown, 0.2, 1.0);
}

// Heights from dark to bright; texels without data are red.
@fragment
fn show_heights(@builtin(position) pixel: vec4<f32>) -> @location(0) vec4<f32> {
    let height_m = load_source(pixel).x;
    if height_m < -1.0e29 {
        return vec4<f32>(0.4, 0.08, 0.08, 1.0);
    }
    let shown = clamp((height_m - range.x) / max(range.y - range.x, 1.0e-6), 0.0, 1.0);
    return vec4<f32>(vec3<f32>(shown), 1.0);
}

// Imagery, over dark grey where there is none.
@fragment
fn show_colours(@builtin(position) pixel: vec4<f32>) -> @location(0) vec4<f32> {
    let texel = load_source(pixel);
    let linear = mix(vec3<f32>(0.01), texel.rgb, texel.a);
    let encoded = select(
        1.055 * pow(linear, vec3<f32>(1.0 / 2.4)) - 0.055,
        12.92 * linear,
        linear <= vec3<f32>(0.0031308),
    );
    return vec4<f32>(encoded, 1.0);
}
