use image::RgbaImage;
use image::imageops::{FilterType, resize};
use terrain_core::{CameraView, DebugView, RendererSettings};

use crate::headless::{Headless, Pace};
use crate::pictures::png_bytes;

/// Pictures of a strip.
const PICTURES: usize = 4;
/// Width of a picture in pixels.
const WIDTH_PX: u32 = 220;

/// A frame with the borders of the tiles it is drawn from.
pub struct StripPicture {
    /// Which of the frames drawn.
    pub index: usize,
    /// A PNG file.
    pub png: Vec<u8>,
}

/// Frames spread over the flight with the borders of their tiles, once nothing is missing. What has been
/// measured must be so before: this brings tiles of its own.
///
/// # Errors
/// Where the device fails.
pub fn film_strip(
    headless: &mut Headless,
    views: &[CameraView],
) -> anyhow::Result<Vec<StripPicture>> {
    let settings = *headless.settings();
    let with_borders = RendererSettings { debug_view: DebugView::TileBorders, ..settings };
    headless.set_settings(with_borders)?;
    let count = PICTURES.min(views.len());
    // Amid equal parts of the flight: its ends are often alike.
    let frames = (0..count).map(|number| (2 * number + 1) * views.len() / (2 * count));
    let mut strip = Vec::with_capacity(count);
    for index in frames {
        let [width, height] = views[index].viewport_px;
        headless.draw(&views[index], Pace::Settled)?;
        let picture = RgbaImage::from_raw(width, height, headless.picture()?);
        let shown = [WIDTH_PX, (height * WIDTH_PX / width).max(1)];
        if let Some(picture) = picture {
            let small = resize(&picture, shown[0], shown[1], FilterType::Triangle);
            strip.push(StripPicture { index, png: png_bytes(shown, &small)? });
        }
    }
    headless.set_settings(settings)?;
    Ok(strip)
}
