//! Seeded noise of whole-number hashes: the same on every machine, whatever the order of evaluation.

use glam::{DVec2, DVec3, Vec2, vec2};

/// A well mixed number of a lattice place.
///
/// The finaliser is `lowbias32` of C. Wellons, "Prospecting for Hash Functions", 2018.
pub fn hash(x: i32, y: i32, seed: u32) -> u32 {
    let column = mix(seed ^ (x as u32).wrapping_mul(0x9e37_79b1));
    mix(column ^ (y as u32).wrapping_mul(0x85eb_ca77))
}

fn mix(mut bits: u32) -> u32 {
    bits = (bits ^ (bits >> 16)).wrapping_mul(0x7feb_352d);
    bits = (bits ^ (bits >> 15)).wrapping_mul(0x846c_a68b);
    bits ^ (bits >> 16)
}

/// A seed for one of several uses of another seed.
pub fn derived_seed(seed: u32, purpose: u32) -> u32 {
    mix(mix(seed).wrapping_add(purpose.wrapping_mul(0x9e37_79b9)))
}

/// 0 up to 1, from the upper bits of a hash.
pub fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// Two numbers of 0 up to 1, from all bits of a hash.
pub fn unit_pair(bits: u32) -> Vec2 {
    vec2((bits & 0xffff) as f32, (bits >> 16) as f32) * (1.0 / 65_536.0)
}

/// The lattice cell that holds a point, and the place in it, 0 up to 1.
pub fn cell_of(point: DVec2) -> (i32, i32, Vec2) {
    // Not `floor`, which plain x86-64 has to call a function for.
    let below = |value: f64| value as i32 - i32::from(value < f64::from(value as i32));
    let (x, y) = (below(point.x), below(point.y));
    (x, y, (point - DVec2::new(f64::from(x), f64::from(y))).as_vec2())
}

/// Gradient noise with a period of a lattice cell: about -1 to 1, smooth, 0 on the lattice.
///
/// K. Perlin, "Improving Noise", 2002, with gradients of all directions.
pub fn gradient_noise(point: DVec2, seed: u32) -> f32 {
    let (x, y, at) = cell_of(point);
    let corner = |dx: i32, dy: i32| {
        let gradient = 2.0 * unit_pair(hash(x + dx, y + dy, seed)) - 1.0;
        gradient.dot(at - vec2(dx as f32, dy as f32))
    };
    let weight = at * at * at * (at * (at * 6.0 - 15.0) + 10.0);
    let north = mixed(corner(0, 0), corner(1, 0), weight.x);
    let south = mixed(corner(0, 1), corner(1, 1), weight.x);
    1.5 * mixed(north, south, weight.y)
}

/// [`gradient_noise`] in space: a lattice of cubes.
pub fn gradient_noise_3d(point: DVec3, seed: u32) -> f32 {
    let (x, y, at) = cell_of(point.truncate());
    let (z, _, depth) = cell_of(DVec2::new(point.z, 0.0));
    let at = [at.x, at.y, depth.x];
    let weight = at.map(|t| t * t * t * (t * (t * 6.0 - 15.0) + 10.0));
    // Steps of the lattice's three axes in the numbers that are mixed.
    const STEPS: [u32; 3] = [0x9e37_79b1, 0x85eb_ca77, 0xc2b2_ae3d];
    let first = [x, y, z]
        .iter()
        .zip(STEPS)
        .fold(seed, |sum, (place, step)| sum.wrapping_add((*place as u32).wrapping_mul(step)));
    let corner = |dx: u8, dy: u8, dz: u8| {
        let steps = [dx, dy, dz].map(u32::from);
        let [x, y, z] = [0, 1, 2].map(|axis| steps[axis].wrapping_mul(STEPS[axis]));
        let bits = mix(first.wrapping_add(x).wrapping_add(y).wrapping_add(z));
        // Ten bits a direction, -1 to 1.
        let part = |shift: u32| (bits >> shift & 0x3ff) as i32 as f32 - 511.5;
        let dot = part(0) * (at[0] - f32::from(dx))
            + part(10) * (at[1] - f32::from(dy))
            + part(20) * (at[2] - f32::from(dz));
        dot * (1.5 / 511.5)
    };
    let along_x = |dy, dz| mixed(corner(0, dy, dz), corner(1, dy, dz), weight[0]);
    let near = mixed(along_x(0, 0), along_x(1, 0), weight[1]);
    let far = mixed(along_x(0, 1), along_x(1, 1), weight[1]);
    mixed(near, far, weight[2])
}

/// Octaves of [`gradient_noise`], each half as high and half as wide as the one before; about -1 to 1.
pub fn fractal_noise(point: DVec2, octaves: u32, seed: u32) -> f32 {
    let (mut sum, mut total, mut height, mut scale) = (0.0, 0.0, 1.0, 1.0);
    for octave in 0..octaves {
        // An offset of its own, or all octaves would be 0 at the origin.
        let shifted = point * scale + DVec2::new(17.3, 9.1) * f64::from(octave);
        sum += height * gradient_noise(shifted, derived_seed(seed, octave));
        total += height;
        height *= 0.5;
        scale *= 2.0;
    }
    1.4 * sum / total
}

/// `a` at 0, `b` at 1, a straight line between.
pub fn mixed(a: f32, b: f32, weight: f32) -> f32 {
    a + (b - a) * weight
}

/// 0 up to `low`, 1 from `high` on, smooth between; falls where `low` is the greater.
pub fn smooth_step(low: f32, high: f32, value: f32) -> f32 {
    let t = ((value - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Cosine and sine of an angle of less than a thousand turns, to 0.001.
///
/// Of sums and products alone, which every machine rounds in the same way; those of the system's
/// library differ in their last bits.
pub fn cos_sin_turns(turns: f32) -> Vec2 {
    let wave = |turns: f32| {
        // A parabola each half turn, and its square to correct it.
        let t = turns - ((turns + 1_000.5) as i32 - 1_000) as f32;
        let parabola = 8.0 * t * (1.0 - 2.0 * t.abs());
        parabola * (0.775 + 0.225 * parabola.abs())
    };
    vec2(wave(turns + 0.25), wave(turns))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hashes_depend_on_place_and_seed_and_fill_their_range() {
        let mean: f32 = (0..10_000).map(|i| unit(hash(i % 100, i / 100, 1))).sum::<f32>() / 1e4;
        assert!((mean - 0.5).abs() < 0.01, "{mean}");
        assert_ne!(hash(1, 2, 3), hash(2, 1, 3));
        assert_ne!(hash(1, 2, 3), hash(1, 2, 4));
        let highest = (0..10_000).map(|i| unit(hash(i, 0, 1))).fold(0.0, f32::max);
        assert!(highest < 1.0 && highest > 0.999, "{highest}");
    }

    #[test]
    fn noise_is_smooth_bounded_and_zero_in_the_mean() {
        let mut sum = 0.0;
        for index in 0..40_000 {
            let point = DVec2::new(f64::from(index % 200), f64::from(index / 200)) * 0.137;
            let value = gradient_noise(point, 7);
            let step = gradient_noise(point + DVec2::new(1e-4, 1e-4), 7) - value;
            assert!(value.abs() < 1.5 && step.abs() < 1e-3, "{value} {step} at {point}");
            sum += value;
        }
        assert!((sum / 40_000.0).abs() < 0.02, "{sum}");
    }

    #[test]
    fn noise_in_space_is_smooth_bounded_and_zero_in_the_mean() {
        let (mut sum, mut squares) = (0.0, 0.0);
        for index in 0..40_000 {
            let place = DVec2::new(f64::from(index % 200), f64::from(index / 200)) * 0.137;
            let point = DVec3::new(place.x, -place.y, 0.3 * place.x + 0.7 * place.y);
            let value = gradient_noise_3d(point, 7);
            let step = gradient_noise_3d(point + DVec3::splat(1e-4), 7) - value;
            assert!(value.abs() < 2.0 && step.abs() < 1e-3, "{value} {step} at {point}");
            sum += value;
            squares += value * value;
        }
        assert!((sum / 40_000.0).abs() < 0.02, "{sum}");
        assert!((0.1..0.6).contains(&(squares / 40_000.0).sqrt()), "{squares}");
    }

    #[test]
    fn cells_begin_at_their_north_west_corner() {
        for value in [-2.0, -1.25, -1.0, -1e-9, 0.0, 0.75, 1.0, 1.5, 1e6 + 0.5] {
            let (x, y, at) = cell_of(DVec2::new(value, -value));
            assert_eq!([x, y], [value.floor() as i32, (-value).floor() as i32]);
            assert!((f64::from(at.x) - (value - value.floor())).abs() < 1e-7);
        }
    }

    #[test]
    fn waves_are_those_of_trigonometry() {
        for index in -500..500 {
            let turns = index as f32 * 0.0173;
            let angle = std::f32::consts::TAU * turns;
            let error = cos_sin_turns(turns) - vec2(angle.cos(), angle.sin());
            assert!(error.abs().max_element() < 1.2e-3, "{error} at {turns}");
        }
    }
}
