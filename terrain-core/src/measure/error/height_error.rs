use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::SizeMismatch;

/// How far drawn heights are from true ones, over the pixels that show ground whose true height is
/// known.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct HeightError {
    /// Root of the mean square, metres.
    pub rmse_m: f64,
    /// The greatest, metres.
    pub max_m: f64,
}

/// The error of the heights drawn: `ground` holds the point drawn at each pixel (not a number where
/// there is sky), `true_z_m` the height the exact surface has at that x and y (not a number where it
/// has none). `None` where no pixel has both. Both heights are as drawn; dividing by the vertical
/// exaggeration is the caller's.
///
/// # Errors
/// [`SizeMismatch`] where the lists differ in length.
pub fn height_error(
    ground: &[DVec3],
    true_z_m: &[f64],
) -> Result<Option<HeightError>, SizeMismatch> {
    SizeMismatch::check([ground.len() as u32, 1], true_z_m.len())?;
    let errors = ground.iter().zip(true_z_m).map(|(point, z_m)| (point.z - z_m).abs());
    let (mut squares, mut max_m, mut count) = (0.0, 0.0_f64, 0_u64);
    for error_m in errors.filter(|error_m| !error_m.is_nan()) {
        squares += error_m * error_m;
        max_m = max_m.max(error_m);
        count += 1;
    }
    let rmse_m = (squares / count as f64).sqrt();
    Ok((count > 0).then_some(HeightError { rmse_m, max_m }))
}

#[cfg(test)]
mod tests {
    use glam::dvec3;

    use super::*;

    #[test]
    fn sky_and_unknown_heights_do_not_count() {
        let ground =
            [dvec3(0.0, 0.0, 10.0), DVec3::NAN, dvec3(1.0, 0.0, 5.0), dvec3(2.0, 0.0, 1.0)];
        let error = height_error(&ground, &[7.0, 3.0, 9.0, f64::NAN]).unwrap().unwrap();
        assert_eq!(error, HeightError { rmse_m: 12.5_f64.sqrt(), max_m: 4.0 });
        assert_eq!(height_error(&[DVec3::NAN], &[1.0]), Ok(None));
        assert!(height_error(&[], &[1.0]).is_err());
    }
}
