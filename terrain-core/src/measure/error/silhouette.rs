use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::SizeMismatch;
use super::distance_transform::distances_px;
use crate::CameraView;

/// The farther pixel's inverse depth is at most this part of the nearer's across a silhouette.
const FARTHER_PART: f64 = 0.9;
/// How many times the step across a silhouette exceeds the steps beside it.
const STEP_FACTOR: f64 = 3.0;

/// How far silhouettes are drawn from where they truly are.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SilhouetteError {
    /// Mean over the silhouette pixels of both pictures of the distance to the nearest of the other.
    pub mean_px: f64,
    /// The greatest of these distances.
    pub max_px: f64,
}

/// Which pixels lie on a silhouette: the edge of something nearer, against ground behind it or the
/// sky. `points` holds what each pixel shows, not a number where there is sky.
///
/// The edge runs between two neighbours of a row or column when one has sky and the other ground, or
/// when the inverse of the depth falls by more than a tenth from one to the other and by more than
/// three times as much as between either and its neighbour beyond. Inverse depths of a plane have
/// equal steps along every line of pixels, so no plane, however steep its view, has a silhouette. The
/// nearer pixel is the one marked.
///
/// # Errors
/// [`SizeMismatch`] where the list has not the pixels of the view.
pub fn silhouette(view: &CameraView, points: &[DVec3]) -> Result<Vec<bool>, SizeMismatch> {
    SizeMismatch::check(view.viewport_px, points.len())?;
    let [width, height] = view.viewport_px.map(|side| side as usize);
    let forward = view.forward();
    let inverse_depth = |point: &DVec3| {
        let depth_m = (*point - view.eye).dot(forward);
        // The sky is infinitely far.
        if depth_m.is_nan() { 0.0 } else { depth_m.max(f64::MIN_POSITIVE).recip() }
    };
    let nearness = points.iter().map(inverse_depth).collect::<Vec<_>>();
    let mut marked = vec![false; points.len()];
    for row in 0..height {
        mark_along(&nearness, &mut marked, (0..width).map(|column| row * width + column));
    }
    for column in 0..width {
        mark_along(&nearness, &mut marked, (0..height).map(|row| row * width + column));
    }
    Ok(marked)
}

fn mark_along(nearness: &[f64], marked: &mut [bool], line: impl Iterator<Item = usize>) {
    let line = line.collect::<Vec<_>>();
    let value =
        |place: Option<usize>| place.and_then(|p| line.get(p)).map(|&pixel| nearness[pixel]);
    let step = |a: Option<f64>, b: f64| a.map_or(0.0, |a| (a - b).abs());
    for (place, pair) in line.windows(2).enumerate() {
        let (a, b) = (nearness[pair[0]], nearness[pair[1]]);
        let (near, far) = (a.max(b), a.min(b));
        // A neighbour in the sky tells nothing about the slope of the ground.
        let beside = |place, here| step(value(place).filter(|&value| value > 0.0), here);
        let steps = beside(place.checked_sub(1), a).max(beside(Some(place + 2), b));
        let is_skyline = far == 0.0 && near > 0.0;
        if is_skyline || (far < FARTHER_PART * near && near - far > STEP_FACTOR * steps) {
            marked[if a > b { pair[0] } else { pair[1] }] = true;
        }
    }
}

/// How far apart the silhouettes of two pictures are; `None` where neither has one. Where one alone
/// has, the picture's diagonal stands for the distance.
///
/// # Errors
/// [`SizeMismatch`] where a list has not the pixels of its size.
pub fn silhouette_error(
    drawn: &[bool],
    exact: &[bool],
    size_px: [u32; 2],
) -> Result<Option<SilhouetteError>, SizeMismatch> {
    SizeMismatch::check(size_px, drawn.len())?;
    SizeMismatch::check(size_px, exact.len())?;
    let size = size_px.map(|side| side as usize);
    let diagonal_px = f64::from(size_px[0]).hypot(f64::from(size_px[1]));
    let away = |from: &[bool], to: &[bool]| {
        let distances = distances_px(to, size).into_iter().zip(from);
        let marked = distances.filter(|(_, marked)| **marked);
        marked.map(|(distance_px, _)| distance_px.min(diagonal_px)).collect::<Vec<_>>()
    };
    let distances = [away(drawn, exact), away(exact, drawn)].concat();
    let mean_px = distances.iter().sum::<f64>() / distances.len() as f64;
    let max_px = distances.iter().copied().fold(0.0, f64::max);
    Ok((!distances.is_empty()).then_some(SilhouetteError { mean_px, max_px }))
}

#[cfg(test)]
mod tests {
    use glam::dvec3;

    use super::*;

    const SIZE_PX: [u32; 2] = [64, 48];

    fn view() -> CameraView {
        CameraView {
            eye: dvec3(0.0, 0.0, 100.0),
            heading_deg: 0.0,
            pitch_deg: -2.0,
            fov_y_deg: 60.0,
            viewport_px: SIZE_PX,
        }
    }

    /// What each pixel shows of a plain at height 0 with a wall across it, `wall_m` ahead and
    /// `top_m` high.
    fn plain_with_wall(wall_m: f64, top_m: f64) -> Vec<DVec3> {
        let view = view();
        let [width, height] = SIZE_PX;
        let pixel = |index: u32| {
            let (column, row) = (index % width, index / width);
            let ray = view.ray_direction(f64::from(column) + 0.5, f64::from(row) + 0.5);
            let at_wall = view.eye + ray * (wall_m / ray.y);
            if at_wall.z > 0.0 && at_wall.z < top_m {
                return at_wall;
            }
            let down = -view.eye.z / ray.z;
            if ray.z < 0.0 { view.eye + ray * down } else { DVec3::NAN }
        };
        (0..width * height).map(pixel).collect()
    }

    #[test]
    fn a_plain_to_the_horizon_has_the_skyline_alone() {
        let marked = silhouette(&view(), &plain_with_wall(1.0e9, 0.0)).unwrap();
        let rows = (0..48).filter(|row| marked[row * 64..(row + 1) * 64].contains(&true));
        let rows = rows.collect::<Vec<_>>();
        assert_eq!(rows.len(), 1, "rows {rows:?}");
        assert!(marked[rows[0] * 64..(rows[0] + 1) * 64].iter().all(|&marked| marked));
    }

    #[test]
    fn a_wall_before_the_plain_has_an_edge_and_it_moves_with_its_height() {
        let marked = |top_m: f64| silhouette(&view(), &plain_with_wall(500.0, top_m)).unwrap();
        let (low, high) = (marked(40.0), marked(70.0));
        let first_row = |marked: &[bool]| marked.iter().rposition(|&m| m).unwrap() / 64;
        let rows = first_row(&low) - first_row(&high);
        // 30 m at 500 m are 30 / 500 of a radian, and a pixel is 0.0241 of one: 2.5 rows.
        assert!((2..=3).contains(&rows), "{rows} rows");
        let error = silhouette_error(&high, &low, SIZE_PX).unwrap().unwrap();
        assert!(error.max_px == rows as f64 && error.mean_px < error.max_px, "{error:?}");
        assert_eq!(
            silhouette_error(&low, &low, SIZE_PX).unwrap(),
            Some(SilhouetteError { mean_px: 0.0, max_px: 0.0 })
        );
    }

    #[test]
    fn an_edge_that_one_picture_lacks_is_a_diagonal_off() {
        let mut edge = vec![false; 12];
        edge[5] = true;
        let error = silhouette_error(&[false; 12], &edge, [4, 3]).unwrap().unwrap();
        assert_eq!(error, SilhouetteError { mean_px: 5.0, max_px: 5.0 });
        assert_eq!(silhouette_error(&[false; 12], &[false; 12], [4, 3]), Ok(None));
        assert!(silhouette_error(&[false; 12], &edge, [4, 4]).is_err());
    }
}
