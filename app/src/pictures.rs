//! Where pictures and flights are saved.

use std::path::{Path, PathBuf};

use anyhow::Context;

/// The first name of the form `STEM-0001.EXTENSION` in the current folder that is not taken.
pub fn free_name(stem: &str, extension: &str) -> PathBuf {
    (1..)
        .map(|number: u32| PathBuf::from(format!("{stem}-{number:04}.{extension}")))
        .find(|path| !path.exists())
        .unwrap_or_else(|| PathBuf::from(format!("{stem}.{extension}")))
}

/// Writes a picture as PNG: RGBA, 8 bits a channel, first row on top.
///
/// # Errors
/// Where the file cannot be written; the error names it.
pub fn write_png(path: &Path, size_px: [u32; 2], rgba: &[u8]) -> anyhow::Result<()> {
    std::fs::write(path, png_bytes(size_px, rgba)?)
        .with_context(|| format!("{}: cannot write the picture", path.display()))
}

/// A picture as a PNG file in memory: RGBA, 8 bits a channel, first row on top.
///
/// # Errors
/// Where there are not four bytes a pixel.
pub fn png_bytes([width, height]: [u32; 2], rgba: &[u8]) -> anyhow::Result<Vec<u8>> {
    use image::ImageEncoder;
    let mut png = Vec::new();
    image::codecs::png::PngEncoder::new(&mut png)
        .write_image(rgba, width, height, image::ExtendedColorType::Rgba8)
        .context("cannot encode the picture")?;
    Ok(png)
}
