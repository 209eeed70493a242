// What the device does with the operations that tricks for more precision rest on.

struct Operands {
    a: f32,
    b: f32,
    c: f32,
}

struct Results {
    // a * b + c as written, which a compiler may contract to one rounding.
    plain: f32,
    fused: f32,
    quotient: f32,
    // Exact error of the rounded sum a + b (Donald Knuth, "The Art of Computer Programming", 4.2.2).
    sum_error: f32,
    // Exact error of the rounded product a * b (T. J. Dekker, "A floating-point technique for extending
    // the available precision", 1971).
    product_error: f32,
}

@group(2) @binding(0) var<storage, read> operands: array<Operands>;
@group(2) @binding(1) var<storage, read_write> results: array<Results>;

fn sum_error(a: f32, b: f32) -> f32 {
    let sum = a + b;
    let b_part = sum - a;
    let a_part = sum - b_part;
    return (a - a_part) + (b - b_part);
}

// The upper 12 bits of a float's 24.
fn upper_half(a: f32) -> f32 {
    let shifted = 4097.0 * a;
    return shifted - (shifted - a);
}

fn product_error(a: f32, b: f32) -> f32 {
    let product = a * b;
    let a_high = upper_half(a);
    let a_low = a - a_high;
    let b_high = upper_half(b);
    let b_low = b - b_high;
    return ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low;
}

@compute @workgroup_size(64)
fn compute_floats(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&operands) {
        return;
    }
    let o = operands[id.x];
    results[id.x] = Results(
        o.a * o.b + o.c, fma(o.a, o.b, o.c), o.a / o.b,
        sum_error(o.a, o.b), product_error(o.a, o.b));
}
