//! Points and eyes that leave nothing out and are the same in every run.

/// Parts of a metre by which eyes stand beside whole coordinates, so that none is representable by luck.
pub const EYE_FRACTIONS: [f64; 2] = [0.371_937, 0.728_311];

/// Element `index` of a sequence that fills 0..1 evenly: steps of an irrational `rate`.
pub fn spread(index: usize, rate: f64) -> f64 {
    (index as f64 * rate).fract()
}
