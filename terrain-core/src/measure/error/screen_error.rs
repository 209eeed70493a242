use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::SizeMismatch;
use super::distance_transform::distances_px;
use crate::CameraView;

/// Screen-space error of each pixel: how many pixels lie between where the surface is drawn and where
/// it truly is.
///
/// - Where ground is drawn whose true height is known, the distance between the pixel positions of the
///   drawn point (x, y, z drawn) and of the true one (x, y, true z).
/// - Where ground is drawn beside the exact surface, the distance to the nearest pixel in which the
///   exact picture shows ground.
/// - Where sky is drawn before true ground, the distance to the nearest pixel in which ground is drawn.
/// - Where both have sky, not a number.
///
/// No error is greater than the picture's diagonal, which stands for points behind the eye and ground
/// that is nowhere. `drawn` and `exact` hold the point of each pixel of either picture, not a number
/// where there is sky; `true_z_m` the height of the exact surface, as drawn, at the x and y of
/// `drawn`, not a number where it has none.
///
/// # Errors
/// [`SizeMismatch`] where a list has not the pixels of the view.
pub fn screen_errors_px(
    view: &CameraView,
    drawn: &[DVec3],
    exact: &[DVec3],
    true_z_m: &[f64],
) -> Result<Vec<f64>, SizeMismatch> {
    for found in [drawn.len(), exact.len(), true_z_m.len()] {
        SizeMismatch::check(view.viewport_px, found)?;
    }
    let [width, height] = view.viewport_px.map(f64::from);
    let diagonal_px = width.hypot(height);
    let [to_drawn, to_exact] = [drawn, exact].map(|ground| distances_to_ground_px(ground, view));
    let error_px = |pixel: usize| {
        let (point, true_z_m) = (drawn[pixel], true_z_m[pixel]);
        let error_px = match (point.is_nan(), exact[pixel].is_nan()) {
            (true, true) => return f64::NAN,
            (true, false) => to_drawn[pixel],
            (false, _) if true_z_m.is_nan() => to_exact[pixel],
            (false, _) => {
                distance_px(view, point, point.truncate().extend(true_z_m)).unwrap_or(diagonal_px)
            }
        };
        error_px.min(diagonal_px)
    };
    Ok((0..drawn.len()).into_par_iter().map(error_px).collect())
}

fn distances_to_ground_px(ground: &[DVec3], view: &CameraView) -> Vec<f64> {
    let marked = ground.iter().map(|point| !point.is_nan()).collect::<Vec<_>>();
    distances_px(&marked, view.viewport_px.map(|side| side as usize))
}

/// Pixels between two points; `None` where one is behind the eye.
pub(crate) fn distance_px(view: &CameraView, a: DVec3, b: DVec3) -> Option<f64> {
    let [a, b] = [view.pixel_from_world(a)?, view.pixel_from_world(b)?].map(DVec2::from);
    Some(a.distance(b))
}

#[cfg(test)]
mod tests {
    use glam::dvec3;

    use super::*;

    /// Looks north from 100 m above the origin, level.
    fn view(viewport_px: [u32; 2]) -> CameraView {
        CameraView {
            eye: dvec3(0.0, 0.0, 100.0),
            heading_deg: 0.0,
            pitch_deg: 0.0,
            fov_y_deg: 90.0,
            viewport_px,
        }
    }

    #[test]
    fn a_metre_too_high_is_its_angle_in_pixels() {
        // 90 degrees over 200 pixels: at 50 m ahead one metre is two pixels.
        let view = view([1, 200]);
        let drawn = vec![dvec3(0.0, 50.0, 80.0); 200];
        let errors = screen_errors_px(&view, &drawn, &drawn, &[79.0; 200]).unwrap();
        assert!(errors.iter().all(|error| (error - 2.0).abs() < 1.0e-9), "{}", errors[0]);
    }

    #[test]
    fn sky_before_ground_is_as_far_off_as_the_nearest_ground_drawn() {
        let view = view([4, 2]);
        let point = dvec3(0.0, 50.0, 80.0);
        let sky = DVec3::NAN;
        let drawn = [sky, sky, sky, sky, sky, sky, sky, point];
        let exact = [sky, sky, point, point, point, point, point, point];
        let mut true_z_m = [f64::NAN; 8];
        true_z_m[7] = 80.0;
        let errors = screen_errors_px(&view, &drawn, &exact, &true_z_m).unwrap();
        assert!(errors[0].is_nan() && errors[1].is_nan());
        assert_eq!(errors[2..], [2.0_f64.sqrt(), 1.0, 3.0, 2.0, 1.0, 0.0]);
    }

    #[test]
    fn ground_beside_the_exact_surface_and_points_behind_the_eye_are_far_off() {
        let view = view([4, 3]);
        let point = dvec3(0.0, 50.0, 80.0);
        let errors = screen_errors_px(&view, &[point; 12], &[DVec3::NAN; 12], &[f64::NAN; 12]);
        assert!(errors.unwrap().iter().all(|&error| error == 5.0), "no ground anywhere");
        let behind = screen_errors_px(
            &CameraView { pitch_deg: -90.0, ..view },
            &[point; 12],
            &[point; 12],
            &[150.0; 12],
        );
        assert!(behind.unwrap().iter().all(|&error| error == 5.0), "the true point is behind");
    }

    #[test]
    fn lists_of_other_lengths_are_refused() {
        assert!(
            screen_errors_px(&view([2, 2]), &[DVec3::ZERO; 4], &[DVec3::ZERO; 3], &[0.0; 4])
                .is_err()
        );
    }
}
