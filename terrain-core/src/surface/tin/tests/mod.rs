mod glb;
mod grids;
mod ground;
mod points;

/// Numbers from 0 up to 1 that look random and are the same everywhere.
pub fn noise(index: u64) -> f64 {
    let mut bits = index.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    bits = (bits ^ (bits >> 31)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    (bits >> 40) as f64 / (1_u64 << 24) as f64
}

/// Twice the signed area of a triangle seen from above.
pub fn doubled_area([a, b, c]: [[f64; 3]; 3]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// The triangle's height at a place in it, by barycentric coordinates; `None` outside.
pub fn height_in_m(corners: [[f64; 3]; 3], x: f64, y: f64) -> Option<f64> {
    let place = [x, y, 0.0];
    let [a, b, c] = corners;
    let shares = [[place, b, c], [a, place, c], [a, b, place]].map(doubled_area);
    let whole = doubled_area(corners);
    let inside = shares.iter().all(|share| *share >= -1e-9 * whole.abs());
    inside.then(|| (shares[0] * a[2] + shares[1] * b[2] + shares[2] * c[2]) / whole)
}
