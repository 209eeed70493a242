// Heights between the four texels round a place.

// Of the heights of the north-western, north-eastern, south-western and south-eastern texel, and the
// place's part of the way to the east and to the south: x is the height weighted by the data under the
// four, y that weight.
fn bilinear_of(heights: vec4<f32>, part: vec2<f32>) -> vec2<f32> {
    if all(heights > vec4<f32>(NO_DATA_M)) {
        let north = heights.x + (heights.y - heights.x) * part.x;
        let south = heights.z + (heights.w - heights.z) * part.x;
        return vec2<f32>(north + (south - north) * part.y, 1.0);
    }
    let rest = 1.0 - part;
    var weights = vec4<f32>(rest.x * rest.y, part.x * rest.y, rest.x * part.y, part.x * part.y);
    weights = select(vec4<f32>(0.0), weights, heights > vec4<f32>(NO_DATA_M));
    let weight = weights.x + weights.y + weights.z + weights.w;
    let sum = dot(weights, select(vec4<f32>(0.0), heights, heights > vec4<f32>(NO_DATA_M)));
    return vec2<f32>(select(0.0, sum / weight, weight > 0.0), weight);
}
