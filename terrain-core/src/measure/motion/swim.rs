use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::drawn_surface::DrawnSurface;
use crate::CameraView;
use crate::measure::error::{SizeMismatch, distance_px};

/// Swim: how many pixels the points of a surface move by themselves from one frame to the next, while
/// the camera moves and the data do not change.
///
/// `before` and `after` hold the point that each pixel of either frame shows, not a number where there
/// is sky; both frames have the size of `view_after`, the later frame's camera. Each point of the
/// earlier frame is looked up in the later one by its x and y; the result is the distance between the
/// pixel positions of its old and its new height, both seen by the later camera. Points that the later
/// frame does not show, because they have left it or lie behind a ridge now, are left out, so the list
/// may be shorter than the picture.
///
/// # Errors
/// [`SizeMismatch`] where a list has not the pixels of the view.
pub fn swim_px(
    view_after: &CameraView,
    before: &[DVec3],
    after: &[DVec3],
) -> Result<Vec<f64>, SizeMismatch> {
    SizeMismatch::check(view_after.viewport_px, before.len())?;
    SizeMismatch::check(view_after.viewport_px, after.len())?;
    let surface = DrawnSurface { view: view_after, points: after };
    let moved_px = |point: &DVec3| {
        let near_px = DVec2::from(view_after.pixel_from_world(*point)?);
        let height_m = surface.height_m(point.truncate(), near_px)?;
        distance_px(view_after, *point, point.truncate().extend(height_m))
    };
    Ok(before.par_iter().filter(|point| !point.is_nan()).filter_map(moved_px).collect())
}

#[cfg(test)]
mod tests {
    use glam::dvec3;

    use super::*;

    const SIZE_PX: [u32; 2] = [48, 32];

    fn view(east_m: f64) -> CameraView {
        CameraView {
            eye: dvec3(east_m, 0.0, 1_000.0),
            heading_deg: 20.0,
            pitch_deg: -40.0,
            fov_y_deg: 45.0,
            viewport_px: SIZE_PX,
        }
    }

    /// What the camera sees of the plane `z = height_m + slope * x`.
    fn seen(view: &CameraView, height_m: f64, slope: f64) -> Vec<DVec3> {
        let [width, height] = SIZE_PX;
        let pixel = |index: u32| {
            let (x, y) = (f64::from(index % width) + 0.5, f64::from(index / width) + 0.5);
            let ray = view.ray_direction(x, y);
            let way = (height_m + slope * view.eye.x - view.eye.z) / (ray.z - slope * ray.x);
            view.eye + ray * way
        };
        (0..width * height).map(pixel).collect()
    }

    #[test]
    fn a_plane_that_stays_does_not_swim_however_the_camera_moves() {
        let (before, after) = (seen(&view(0.0), 10.0, 0.2), seen(&view(30.0), 10.0, 0.2));
        let swim = swim_px(&view(30.0), &before, &after).unwrap();
        assert!(swim.len() > 1_000, "{} of 1536 points found", swim.len());
        assert!(
            swim.iter().all(|px| *px < 1.0e-6),
            "{:?}",
            swim.iter().copied().fold(0.0, f64::max)
        );
    }

    #[test]
    fn ground_that_rises_swims_by_the_pixels_between_its_heights() {
        let later = view(30.0);
        let (before, after) = (seen(&view(0.0), 0.0, 0.0), seen(&later, 2.0, 0.0));
        let swim = swim_px(&later, &before, &after).unwrap();
        let expected =
            |point: &DVec3| distance_px(&later, *point, *point + 2.0 * DVec3::Z).unwrap();
        let (least, most) = before
            .iter()
            .map(expected)
            .fold((f64::INFINITY, 0.0_f64), |(least, most), px| (least.min(px), most.max(px)));
        assert!(swim.len() > 1_000 && least > 0.0);
        assert!(swim.iter().all(|px| (least - 1.0e-9..most + 1.0e-9).contains(px)));
    }

    #[test]
    fn sky_and_what_has_left_the_picture_are_left_out() {
        let here = view(0.0);
        let points = seen(&here, 0.0, 0.0);
        let turned = CameraView { heading_deg: 200.0, ..here };
        assert_eq!(swim_px(&turned, &points, &seen(&turned, 0.0, 0.0)), Ok(Vec::new()));
        let sky = vec![DVec3::NAN; points.len()];
        assert_eq!(swim_px(&here, &points, &sky), Ok(Vec::new()));
        assert_eq!(swim_px(&here, &sky, &points), Ok(Vec::new()));
        assert!(swim_px(&here, &points[1..], &points).is_err());
    }
}
