use std::io::{Seek, Write};

use tiff::TiffResult;
use tiff::encoder::colortype::ColorType;
use tiff::encoder::{ImageEncoder, TiffEncoder, TiffKindStandard, TiffValue};
use tiff::tags::Tag;

/// Rows of a strip.
pub const STRIP_ROWS: usize = 16;

/// Where a north-up raster lies and what it is.
pub struct GeoTiffHeader {
    /// Columns and rows.
    pub side: usize,
    /// Easting and northing of the north-west corner in metres.
    pub corner_m: [f64; 2],
    /// Side of a cell in metres.
    pub cell_m: f64,
    /// EPSG code of a projected CRS.
    pub epsg: u16,
    /// What the file holds, in plain words.
    pub description: String,
}

impl GeoTiffHeader {
    /// Starts a raster that is then written strip by strip, not compressed.
    pub fn start<'w, C: ColorType, W: Write + Seek>(
        &self,
        encoder: &'w mut TiffEncoder<W>,
    ) -> TiffResult<ImageEncoder<'w, W, C, TiffKindStandard>>
    where
        [C::Inner]: TiffValue,
    {
        let mut image = encoder.new_image::<C>(self.side as u32, self.side as u32)?;
        image.rows_per_strip(STRIP_ROWS as u32)?;
        let [x, y] = self.corner_m;
        let directory = image.encoder();
        directory.write_tag(Tag::ImageDescription, &self.description[..])?;
        directory.write_tag(Tag::Software, "terrain")?;
        directory.write_tag(Tag::ModelPixelScaleTag, &[self.cell_m, self.cell_m, 0.0][..])?;
        directory.write_tag(Tag::ModelTiepointTag, &[0.0, 0.0, 0.0, x, y, 0.0][..])?;
        directory.write_tag(Tag::GeoKeyDirectoryTag, &geo_keys(self.epsg)[..])?;
        Ok(image)
    }
}

/// Keys of GeoTIFF 1.1 (OGC 19-008r4): a projected model, cells that are areas, metres.
fn geo_keys(epsg: u16) -> [u16; 20] {
    let keys = [[1024, 0, 1, 1], [1025, 0, 1, 1], [3072, 0, 1, epsg], [3076, 0, 1, 9001]];
    let header = [1, 1, 1, keys.len() as u16];
    let mut directory = [0; 20];
    directory[..4].copy_from_slice(&header);
    directory[4..].copy_from_slice(keys.as_flattened());
    directory
}
