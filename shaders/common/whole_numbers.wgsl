// Whole numbers of 64 bits in two words, the low one first.

fn is_less(a: vec2<u32>, b: vec2<u32>) -> bool {
    return a.y < b.y || (a.y == b.y && a.x < b.x);
}

fn sum(a: vec2<u32>, b: vec2<u32>) -> vec2<u32> {
    let low = a.x + b.x;
    return vec2<u32>(low, a.y + b.y + select(0u, 1u, low < a.x));
}

// The square of a number up to 2^31, by halves: (2^16 h + l)^2 = 2^32 h h + 2^17 h l + l l.
fn square(number: u32) -> vec2<u32> {
    let high = number >> 16u;
    let low = number & 0xffffu;
    // Below 2^32: where h is 2^15, l is 0.
    let middle = 2u * high * low;
    return sum(vec2<u32>(low * low, high * high), vec2<u32>(middle << 16u, middle >> 16u));
}
