use crate::measure::error::{DEFAULT_PIXELS_PER_DEGREE, SizeMismatch, Spread, flip_errors};

/// Popping: the FLIP errors between the picture drawn with the tiles there were and the picture drawn
/// with those that have arrived, both of the same camera, so that the camera's motion has no part in
/// it. `None` of pictures without pixels.
///
/// # Errors
/// [`SizeMismatch`] where a picture has not the pixels of its size.
pub fn popping(
    before: &[[u8; 4]],
    after: &[[u8; 4]],
    size_px: [u32; 2],
) -> Result<Option<Spread>, SizeMismatch> {
    let errors = flip_errors(before, after, size_px, DEFAULT_PIXELS_PER_DEGREE)?;
    Ok(Spread::of(errors.into_iter().map(f64::from)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_that_stays_does_not_pop_and_one_that_changes_does() {
        let before = (0..64).map(|i| [i as u8, 90, 120, 255]).collect::<Vec<_>>();
        let mut after = before.clone();
        assert_eq!(popping(&before, &after, [8, 8]).unwrap(), Some(Spread::default()));
        after[9] = [255; 4];
        let popped = popping(&before, &after, [8, 8]).unwrap().unwrap();
        assert!(popped.max > popped.mean && popped.mean > 0.0);
        assert_eq!(popping(&[], &[], [0, 0]).unwrap(), None);
    }
}
