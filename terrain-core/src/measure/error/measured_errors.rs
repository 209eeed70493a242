use serde::{Deserialize, Serialize};

use super::{PictureDeviation, Spread};

/// What was measured of a frame against the exact picture and against the frames beside it: columns of
/// `frames.csv`. `None` where it was not measured or there was nothing to measure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MeasuredErrors {
    /// Mean FLIP error, 0 to 1.
    pub flip_mean: Option<f64>,
    /// FLIP error that 99 in a hundred pixels do not exceed.
    pub flip_p99: Option<f64>,
    /// Peak signal-to-noise ratio in decibels; infinite of equal pictures.
    pub psnr_db: Option<f64>,
    /// Structural similarity, at most 1.
    pub ssim: Option<f64>,
    /// Root mean square error of the heights drawn, metres.
    pub height_rmse_m: Option<f64>,
    /// Greatest error of the heights drawn, metres.
    pub height_max_m: Option<f64>,
    /// Screen-space error in pixels that half of the pixels do not exceed.
    pub screen_error_px_p50: Option<f64>,
    /// Screen-space error in pixels that 99 in a hundred pixels do not exceed.
    pub screen_error_px_p99: Option<f64>,
    /// Greatest screen-space error in pixels.
    pub screen_error_px_max: Option<f64>,
    /// Mean distance between the silhouettes of both pictures, pixels.
    pub silhouette_error_px: Option<f64>,
    /// Swim towards the next frame in pixels that half of the points do not exceed.
    pub swim_px_p50: Option<f64>,
    /// Swim towards the next frame in pixels that 99 in a hundred points do not exceed.
    pub swim_px_p99: Option<f64>,
    /// Mean FLIP error between the frame without and with the tiles that arrived in it.
    pub popping_flip_mean: Option<f64>,
}

impl MeasuredErrors {
    /// What a picture's deviation, the swim and the popping come to.
    pub fn new(picture: &PictureDeviation, swim: Option<Spread>, popping: Option<Spread>) -> Self {
        let screen = picture.screen_error_px;
        Self {
            flip_mean: Some(picture.flip.mean),
            flip_p99: Some(picture.flip.p99),
            psnr_db: Some(picture.psnr_db.unwrap_or(f64::INFINITY)),
            ssim: Some(picture.ssim),
            height_rmse_m: picture.height.map(|error| error.rmse_m),
            height_max_m: picture.height.map(|error| error.max_m),
            screen_error_px_p50: screen.map(|spread| spread.p50),
            screen_error_px_p99: screen.map(|spread| spread.p99),
            screen_error_px_max: screen.map(|spread| spread.max),
            silhouette_error_px: picture.silhouette.map(|error| error.mean_px),
            swim_px_p50: swim.map(|spread| spread.p50),
            swim_px_p99: swim.map(|spread| spread.p99),
            popping_flip_mean: popping.map(|spread| spread.mean),
        }
    }

    /// Names of the columns and their values.
    pub fn columns(&self) -> [(&'static str, Option<f64>); 13] {
        [
            ("flip_mean", self.flip_mean),
            ("flip_p99", self.flip_p99),
            ("psnr_db", self.psnr_db),
            ("ssim", self.ssim),
            ("height_rmse_m", self.height_rmse_m),
            ("height_max_m", self.height_max_m),
            ("screen_error_px_p50", self.screen_error_px_p50),
            ("screen_error_px_p99", self.screen_error_px_p99),
            ("screen_error_px_max", self.screen_error_px_max),
            ("silhouette_error_px", self.silhouette_error_px),
            ("swim_px_p50", self.swim_px_p50),
            ("swim_px_p99", self.swim_px_p99),
            ("popping_flip_mean", self.popping_flip_mean),
        ]
    }
}
