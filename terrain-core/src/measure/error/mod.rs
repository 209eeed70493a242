//! How far a drawn picture is from the exact one of the same camera. Every measure is a function of
//! lists of pixels, row by row from the top left; `docs/measures.md` has the formulas.

mod distance_transform;
mod flip;
mod height_error;
mod measured_errors;
mod percentile;
mod picture_deviation;
mod pixel_difference;
mod screen_error;
mod silhouette;
mod true_heights;

pub use flip::{DEFAULT_PIXELS_PER_DEGREE, flip_errors};
pub use height_error::{HeightError, height_error};
pub use measured_errors::MeasuredErrors;
pub use percentile::{Spread, percentile};
pub use picture_deviation::{DrawnPicture, PictureDeviation};
pub use pixel_difference::{psnr_db, ssim};
pub(super) use screen_error::distance_px;
pub use screen_error::screen_errors_px;
pub use silhouette::{SilhouetteError, silhouette, silhouette_error};
pub use true_heights::true_heights_m;

/// A list that has not the pixels of its size.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a list of {found} pixels for a picture of {} x {}", size_px[0], size_px[1])]
pub struct SizeMismatch {
    /// Width and height the list should have.
    pub size_px: [u32; 2],
    /// How many pixels it has.
    pub found: usize,
}

impl SizeMismatch {
    /// Ok where a list of `found` pixels fills the picture.
    ///
    /// # Errors
    /// Where it does not.
    pub(crate) fn check(size_px: [u32; 2], found: usize) -> Result<(), Self> {
        let [width, height] = size_px.map(u64::from);
        if width * height == found as u64 { Ok(()) } else { Err(Self { size_px, found }) }
    }
}
