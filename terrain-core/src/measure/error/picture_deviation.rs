use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::{
    DEFAULT_PIXELS_PER_DEGREE, HeightError, SilhouetteError, SizeMismatch, Spread, flip_errors,
    height_error, psnr_db, screen_errors_px, silhouette, silhouette_error, ssim,
};
use crate::CameraView;
use crate::reference::ReferencePicture;

/// A picture as it was drawn, row by row from the top left.
#[derive(Clone, Copy, Debug)]
pub struct DrawnPicture<'a> {
    /// sRGB-encoded colour and alpha.
    pub rgba: &'a [[u8; 4]],
    /// The point drawn at each pixel: x, y in metres of the CRS and z as drawn, not a number where
    /// there is sky.
    pub ground: &'a [DVec3],
}

/// How far a drawn picture is from the exact one of the same camera. `docs/measures.md` has the
/// formulas.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PictureDeviation {
    /// FLIP error of the pixels, 0 to 1.
    pub flip: Spread,
    /// Peak signal-to-noise ratio in decibels; `None` of equal pictures, whose ratio is infinite.
    pub psnr_db: Option<f64>,
    /// Structural similarity, at most 1.
    pub ssim: f64,
    /// Error of the drawn heights, exaggeration divided out; `None` where no ground is drawn.
    pub height: Option<HeightError>,
    /// Screen-space error of the pixels; `None` where both pictures are all sky.
    pub screen_error_px: Option<Spread>,
    /// Error of the silhouettes; `None` where neither picture has one.
    pub silhouette: Option<SilhouetteError>,
}

impl PictureDeviation {
    /// Measures the picture drawn for the view against the exact one. `true_z_m` holds the height of
    /// the exact surface, as drawn, at the x and y of each point of the drawn ground; not a number
    /// where it has none. Without it, as of a globe, neither is measured that goes by heights.
    ///
    /// # Errors
    /// [`SizeMismatch`] where a list has not the pixels of the view, or there are none.
    pub fn measure(
        view: &CameraView,
        vertical_exaggeration: f64,
        drawn: DrawnPicture<'_>,
        exact: &ReferencePicture,
        true_z_m: Option<&[f64]>,
    ) -> Result<Self, SizeMismatch> {
        let size_px = view.viewport_px;
        let (rgba, ppd) = (&exact.rgba, DEFAULT_PIXELS_PER_DEGREE);
        let flip = flip_errors(rgba, drawn.rgba, size_px, ppd)?.into_iter().map(f64::from);
        let flip = Spread::of(flip).ok_or(SizeMismatch { size_px, found: 0 })?;
        let psnr_db = Some(psnr_db(rgba, drawn.rgba)?).filter(|ratio| ratio.is_finite());
        let screen = match true_z_m {
            Some(true_z_m) => screen_errors_px(view, drawn.ground, &exact.coordinates, true_z_m)?,
            None => Vec::new(),
        };
        let height = match true_z_m {
            Some(true_z_m) => height_error(drawn.ground, true_z_m)?,
            None => None,
        };
        let height = height.map(|error| HeightError {
            rmse_m: error.rmse_m / vertical_exaggeration,
            max_m: error.max_m / vertical_exaggeration,
        });
        let drawn_edges = silhouette(view, drawn.ground)?;
        let exact_edges = silhouette(view, &exact.coordinates)?;
        Ok(Self {
            flip,
            psnr_db,
            ssim: ssim(rgba, drawn.rgba, size_px)?,
            height,
            screen_error_px: Spread::of(screen),
            silhouette: silhouette_error(&drawn_edges, &exact_edges, size_px)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use glam::dvec3;

    use super::*;

    #[test]
    fn a_picture_is_no_way_from_itself() {
        let view = CameraView {
            eye: dvec3(0.0, 0.0, 100.0),
            heading_deg: 0.0,
            pitch_deg: -10.0,
            fov_y_deg: 60.0,
            viewport_px: [16, 16],
        };
        let point = |index: u32| {
            let ray = view.ray_direction(f64::from(index % 16) + 0.5, f64::from(index / 16) + 0.5);
            if ray.z < 0.0 { view.eye + ray * (-80.0 / ray.z) } else { DVec3::NAN }
        };
        let ground = (0..256).map(point).collect::<Vec<_>>();
        let exact = ReferencePicture {
            size_px: [16, 16],
            rgba: (0..256).map(|i| [i as u8, 128, 255 - i as u8, 255]).collect(),
            distance_m: ground.iter().map(|point| point.distance(view.eye)).collect(),
            coordinates: ground.clone(),
            silhouette: vec![false; 256],
        };
        let true_z_m = ground.iter().map(|point| point.z).collect::<Vec<_>>();
        let drawn = DrawnPicture { rgba: &exact.rgba, ground: &ground };
        let same = PictureDeviation::measure(&view, 2.0, drawn, &exact, Some(&true_z_m)).unwrap();
        assert_eq!(same.flip, Spread::default());
        assert_eq!((same.psnr_db, same.screen_error_px), (None, Some(Spread::default())));
        assert_eq!(same.height, Some(HeightError { rmse_m: 0.0, max_m: 0.0 }));
        assert_eq!(same.silhouette, Some(SilhouetteError { mean_px: 0.0, max_px: 0.0 }));
        let higher = true_z_m.iter().map(|z| z + 3.0).collect::<Vec<_>>();
        let off = PictureDeviation::measure(&view, 2.0, drawn, &exact, Some(&higher)).unwrap();
        assert!((off.height.unwrap().rmse_m - 1.5).abs() < 1.0e-9, "exaggeration divided out");
    }
}
