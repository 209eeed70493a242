use anyhow::Context;
use image::RgbaImage;
use image::imageops::{FilterType, replace, resize};
use terrain_core::measure::FrameRecord;
use terrain_core::measure::error::{DEFAULT_PIXELS_PER_DEGREE, flip_errors};
use terrain_core::reference::ReferencePicture;

use crate::pictures::png_bytes;

/// Width in pixels at which a page shows a panel.
const PAGE_PANEL_PX: u32 = 480;
/// Pixels between two panels.
const GAP_PX: u32 = 8;

/// A measured frame, its picture and the exact one.
pub struct WorstFrame {
    /// Number of the frame in the flight.
    pub frame: u64,
    /// Time in the flight, seconds.
    pub time_s: f64,
    /// Mean FLIP error.
    pub flip_mean: f64,
    size_px: [u32; 2],
    drawn: Vec<[u8; 4]>,
    exact: Vec<[u8; 4]>,
}

/// The measured frames with the greatest FLIP errors so far.
pub struct WorstFrames {
    kept: usize,
    frames: Vec<WorstFrame>,
}

impl WorstFrames {
    /// None yet, and of those to come so many.
    pub fn new(kept: usize) -> Self {
        Self { kept, frames: Vec::new() }
    }

    /// Keeps the frame if it is among the worst.
    pub fn consider(&mut self, frame: WorstFrame) {
        self.frames.push(frame);
        // Of equal frames the earlier comes first.
        self.frames.sort_by(|a, b| b.flip_mean.total_cmp(&a.flip_mean).then(a.frame.cmp(&b.frame)));
        self.frames.truncate(self.kept);
    }

    /// The frames, the worst first.
    pub fn into_frames(self) -> Vec<WorstFrame> {
        self.frames
    }
}

impl WorstFrame {
    /// A measured frame.
    pub fn new(
        record: &FrameRecord,
        size_px: [u32; 2],
        drawn: Vec<[u8; 4]>,
        exact: &ReferencePicture,
    ) -> Self {
        let flip_mean = record.errors.flip_mean.unwrap_or(0.0);
        let exact = exact.rgba.clone();
        Self { frame: record.frame, time_s: record.time_s, flip_mean, size_px, drawn, exact }
    }

    /// Picture, exact picture and FLIP errors.
    fn panels(&self) -> anyhow::Result<[RgbaImage; 3]> {
        let errors =
            flip_errors(&self.exact, &self.drawn, self.size_px, DEFAULT_PIXELS_PER_DEGREE)?;
        let errors = errors.into_iter().map(heat_colour).collect::<Vec<_>>();
        let [width, height] = self.size_px;
        let panel = |pixels: &[[u8; 4]]| {
            let picture = RgbaImage::from_raw(width, height, pixels.as_flattened().to_vec());
            picture.context("a picture has not the pixels of its size")
        };
        Ok([panel(&self.drawn)?, panel(&self.exact)?, panel(&errors)?])
    }

    /// The three panels side by side as one PNG file.
    ///
    /// # Errors
    /// Where the picture cannot be encoded.
    pub fn png(&self) -> anyhow::Result<Vec<u8>> {
        let [width, height] = self.size_px;
        let white = image::Rgba([255; 4]);
        let mut sheet = RgbaImage::from_pixel(3 * width + 2 * GAP_PX, height, white);
        for (panel, picture) in self.panels()?.iter().enumerate() {
            replace(&mut sheet, picture, panel as i64 * i64::from(width + GAP_PX), 0);
        }
        encode(&sheet)
    }

    /// The three panels as PNG files as large as a page shows them.
    ///
    /// # Errors
    /// Where a picture cannot be encoded.
    pub fn page_panels(&self) -> anyhow::Result<[Vec<u8>; 3]> {
        let [width, height] = self.size_px;
        let small = |panel: &RgbaImage| {
            if width <= PAGE_PANEL_PX {
                return encode(panel);
            }
            let shown_height = (height * PAGE_PANEL_PX / width).max(1);
            encode(&resize(panel, PAGE_PANEL_PX, shown_height, FilterType::Triangle))
        };
        let [drawn, exact, errors] = &self.panels()?;
        Ok([small(drawn)?, small(exact)?, small(errors)?])
    }
}

fn encode(picture: &RgbaImage) -> anyhow::Result<Vec<u8>> {
    png_bytes(picture.dimensions().into(), picture)
}

/// Black through purple and orange to pale yellow: an error from 0 to 1 in colours that grow steadily
/// lighter, so that they can be read without telling hues apart.
fn heat_colour(error: f32) -> [u8; 4] {
    const STOPS: [[f32; 3]; 6] = [
        [0.0, 0.0, 4.0],
        [59.0, 15.0, 112.0],
        [140.0, 41.0, 129.0],
        [222.0, 73.0, 104.0],
        [254.0, 159.0, 109.0],
        [252.0, 253.0, 191.0],
    ];
    let place = error.clamp(0.0, 1.0) * (STOPS.len() - 1) as f32;
    let low = (place as usize).min(STOPS.len() - 2);
    let part = place - low as f32;
    let channel = |c: usize| (STOPS[low][c] + part * (STOPS[low + 1][c] - STOPS[low][c])) as u8;
    [channel(0), channel(1), channel(2), 255]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn greater_errors_are_lighter() {
        let light = |error: f32| heat_colour(error)[..3].iter().map(|c| u32::from(*c)).sum::<u32>();
        assert!((0..20).all(|step| light(step as f32 / 20.0) < light((step + 1) as f32 / 20.0)));
        assert_eq!(heat_colour(0.0), [0, 0, 4, 255]);
        assert_eq!(heat_colour(7.0), [252, 253, 191, 255]);
    }
}
