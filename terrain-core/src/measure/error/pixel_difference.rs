use image::GrayImage;
use image_compare::{Algorithm, gray_similarity_structure};

use super::SizeMismatch;

/// Peak signal-to-noise ratio of the sRGB-encoded red, green and blue in decibels: infinite of equal
/// pictures. Not a number where there are no pixels.
///
/// # Errors
/// [`SizeMismatch`] where the lists differ in length.
pub fn psnr_db(reference: &[[u8; 4]], test: &[[u8; 4]]) -> Result<f64, SizeMismatch> {
    SizeMismatch::check([reference.len() as u32, 1], test.len())?;
    let squares = reference.iter().zip(test).map(|(a, b)| {
        let square = |channel: usize| u64::from(a[channel].abs_diff(b[channel])).pow(2);
        square(0) + square(1) + square(2)
    });
    let mean_square = squares.sum::<u64>() as f64 / (3 * reference.len()) as f64;
    Ok(10.0 * (255.0_f64.powi(2) / mean_square).log10())
}

/// Structural similarity (Zhou Wang, Alan Bovik, Hamid Sheikh and Eero Simoncelli, "Image Quality
/// Assessment: From Error Visibility to Structural Similarity", 2004) of the luma: 1 of equal
/// pictures.
///
/// As the crate image-compare has it: the mean over blocks of 8 x 8 pixels, whose variances are sums
/// of squares instead of means, so that it tells fine noise from flat colour more sharply than the
/// paper's. Not a number where there are no pixels.
///
/// # Errors
/// [`SizeMismatch`] where a picture has not the pixels of its size.
pub fn ssim(
    reference: &[[u8; 4]],
    test: &[[u8; 4]],
    size_px: [u32; 2],
) -> Result<f64, SizeMismatch> {
    let [reference, test] = [luma(reference, size_px)?, luma(test, size_px)?];
    if size_px.contains(&0) {
        return Ok(f64::NAN);
    }
    let similarity = gray_similarity_structure(&Algorithm::MSSIMSimple, &reference, &test);
    // It fails for pictures of two sizes alone, which these are not.
    Ok(similarity.map_or(f64::NAN, |similarity| similarity.score))
}

/// ITU-R BT.709 luma of the sRGB-encoded values.
fn luma(rgba: &[[u8; 4]], size_px: [u32; 2]) -> Result<GrayImage, SizeMismatch> {
    let luma = |&[red, green, blue, _]: &[u8; 4]| {
        let [red, green, blue] = [red, green, blue].map(f32::from);
        (0.2126 * red + 0.7152 * green + 0.0722 * blue).round() as u8
    };
    SizeMismatch::check(size_px, rgba.len())?;
    GrayImage::from_raw(size_px[0], size_px[1], rgba.iter().map(luma).collect())
        .ok_or(SizeMismatch { size_px, found: rgba.len() })
}

#[cfg(test)]
mod tests {
    use super::*;

    const GREY: [u8; 4] = [100, 100, 100, 255];

    #[test]
    fn psnr_is_that_of_the_formula() {
        let other = [[110, 100, 100, 0], GREY];
        // One of six values is off by 10: a mean square of 100 / 6.
        let expected = 10.0 * (65_025.0_f64 * 6.0 / 100.0).log10();
        assert!((psnr_db(&[GREY, GREY], &other).unwrap() - expected).abs() < 1.0e-12);
        assert_eq!(psnr_db(&other, &other).unwrap(), f64::INFINITY);
        assert!(psnr_db(&[GREY], &other).is_err());
        assert!(psnr_db(&[], &[]).unwrap().is_nan());
    }

    #[test]
    fn ssim_is_one_of_equal_pictures_and_falls_with_structure_lost() {
        let checks = (0..256).map(|i| if (i + i / 16) % 2 == 0 { GREY } else { [140; 4] });
        let checks = checks.collect::<Vec<_>>();
        let flat = vec![[120; 4]; 256];
        let shifted = checks.iter().map(|c| c.map(|v| v.saturating_add(5))).collect::<Vec<_>>();
        assert!((ssim(&checks, &checks, [16, 16]).unwrap() - 1.0).abs() < 1.0e-12);
        let (lost, kept) =
            (ssim(&checks, &flat, [16, 16]).unwrap(), ssim(&checks, &shifted, [16, 16]).unwrap());
        assert!(lost < 0.05 && kept > 0.95, "{lost} {kept}");
        assert!(ssim(&checks, &flat, [16, 17]).is_err());
        assert!(ssim(&[], &[], [0, 5]).unwrap().is_nan());
    }
}
