// The texture coordinate under a ray, computed in the float format of `real` without any rounding of
// our own: the quotient of the dot products of the normalised ray.
// needs: common/real_f32.wgsl

@group(2) @binding(0) var<storage, read> rays: array<vec2<f32>>;
// The quotient as the sum of two floats, which hold all but the last bits of an f64.
@group(2) @binding(1) var<storage, read_write> quotients: array<vec2<f32>>;

@compute @workgroup_size(64)
fn divide(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&rays) {
        return;
    }
    let along = real(rays[id.x].x);
    let across = real(rays[id.x].y);
    let down = real(1.0);
    let length = sqrt(along * along + across * across + down * down);
    let axis_dot = along / length;
    let normal_dot = down / length;
    let quotient = axis_dot / normal_dot;
    let high = f32(quotient);
    quotients[id.x] = vec2<f32>(high, f32(quotient - real(high)));
}
