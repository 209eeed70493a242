use std::path::Path;

use terrain_core::gpu::{GpuContext, GpuError, OffscreenTarget};

/// A picture read back from the GPU: RGBA, 8 bits a channel, sRGB.
#[derive(Clone, PartialEq, Eq)]
pub struct Picture {
    /// Width and height in pixels.
    pub size_px: [u32; 2],
    /// Four bytes a pixel, first row on top.
    pub rgba: Vec<u8>,
}

impl Picture {
    /// Waits for the target's content.
    ///
    /// # Errors
    /// Where the device has failed.
    pub fn read(gpu: &GpuContext, target: &OffscreenTarget) -> Result<Self, GpuError> {
        Ok(Self { size_px: target.size_px(), rgba: target.read_rgba8(gpu)? })
    }

    /// The pixel at column `x`, row `y`.
    pub fn pixel(&self, x: u32, y: u32) -> [u8; 4] {
        let start = ((y * self.size_px[0] + x) * 4) as usize;
        [self.rgba[start], self.rgba[start + 1], self.rgba[start + 2], self.rgba[start + 3]]
    }

    /// Writes a PNG file.
    ///
    /// # Errors
    /// Where the file cannot be written.
    pub fn save(&self, path: &Path) -> image::ImageResult<()> {
        let [width, height] = self.size_px;
        image::save_buffer(path, &self.rgba, width, height, image::ExtendedColorType::Rgba8)
    }
}
