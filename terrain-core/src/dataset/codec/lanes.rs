//! Arithmetic on the 16 texels of a block at a time, written so that the compiler uses vector
//! registers: loops of fixed length without branches, and sums that need no fixed order.

/// One number of each texel of a block.
pub(super) type Lanes = [f32; 16];

/// Lanes that are added up side by side.
const WIDTH: usize = 4;

/// Each lane changed. A loop, since `array::map` keeps the compiler from using vectors.
#[inline]
pub(super) fn mapped(lanes: &Lanes, with: impl Fn(f32) -> f32) -> Lanes {
    let mut out = *lanes;
    for lane in &mut out {
        *lane = with(*lane);
    }
    out
}

/// Both lanes of each texel put together.
#[inline]
pub(super) fn zipped(a: &Lanes, b: &Lanes, with: impl Fn(f32, f32) -> f32) -> Lanes {
    let mut out = *a;
    for (lane, &other) in out.iter_mut().zip(b) {
        *lane = with(*lane, other);
    }
    out
}

/// All lanes put together by an operation whose order does not matter.
#[inline]
fn folded(lanes: &Lanes, with: impl Fn(f32, f32) -> f32) -> f32 {
    let (groups, _) = lanes.as_chunks::<WIDTH>();
    let mut sums = groups[0];
    for group in &groups[1..] {
        for (sum, &part) in sums.iter_mut().zip(group) {
            *sum = with(*sum, part);
        }
    }
    with(with(sums[0], sums[1]), with(sums[2], sums[3]))
}

#[inline]
pub(super) fn sum(lanes: &Lanes) -> f32 {
    folded(lanes, |a, b| a + b)
}

#[inline]
pub(super) fn smallest(lanes: &Lanes) -> f32 {
    folded(lanes, |a, b| if a < b { a } else { b })
}

#[inline]
pub(super) fn largest(lanes: &Lanes) -> f32 {
    folded(lanes, |a, b| if a > b { a } else { b })
}

/// Sum of the products lane by lane.
#[inline]
pub(super) fn product_sum(a: &Lanes, b: &Lanes) -> f32 {
    sum(&zipped(a, b, |a, b| a * b))
}

/// From here on an f32 has no digits below one, and its lowest bits are those of an integer.
const WHOLE_ONLY: f32 = (1_u32 << 23) as f32;

/// The nearest whole number of a value from 0 to 2^22, without the branches of [`f32::round`].
#[inline]
pub(super) fn rounded(value: f32) -> f32 {
    (value + WHOLE_ONLY) - WHOLE_ONLY
}

/// Whole numbers from 0 to 255 as integers, without the checks of a cast.
#[inline]
pub(super) fn small_integers(lanes: &Lanes) -> [u8; 16] {
    let mut out = [0; 16];
    for (out, lane) in out.iter_mut().zip(lanes) {
        *out = (lane + WHOLE_ONLY).to_bits() as u8;
    }
    out
}
