//! Rasters as they come: one trait over every file format, read window by window.

mod breaklines;
mod chunk_cache;
mod error;
mod geo_keys;
mod geotiff;
mod hgt;
mod picture;
mod points;
mod raster_grid;
mod world_file;

use std::path::Path;

pub use breaklines::read_breaklines;
pub use error::SourceError;
pub use geotiff::GeoTiffSource;
pub use hgt::HgtSource;
pub use picture::PictureSource;
pub use points::{GROUND_CLASS, PointCloud, PointRaster, is_point_file, read_points};
pub use raster_grid::{RasterGrid, Window};

/// What a raster is.
#[derive(Clone, Debug, PartialEq)]
pub struct RasterInfo {
    /// Where the cells lie; `None` where the file does not say.
    pub grid: Option<RasterGrid>,
    /// Width and height in cells, both at least 1.
    pub size: [u32; 2],
    /// The EPSG code of the grid's coordinates; `None` where the file does not say.
    pub epsg: Option<u32>,
    /// Whether the raster holds one band of heights or a picture.
    pub content: RasterContent,
    /// The smallest difference between two heights the format can tell, in metres: 1 for integer
    /// heights, 0 for floats (and for pictures).
    pub height_step_m: f64,
    /// What a user should know: how the file was understood where it leaves a choice.
    pub notes: Vec<String>,
}

/// What the cells of a raster mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RasterContent {
    /// One band of numbers with a sign or a fraction: heights, never a picture.
    Measurements,
    /// One band that can be read as heights, or as a grey picture.
    SingleBand,
    /// Red, green, blue and perhaps coverage, 8 bits each.
    Picture,
}

/// A raster file, read window by window: never more of it in memory than the windows need.
///
/// Windows lie within the raster. Rows come north first, cells west first.
pub trait RasterSource: Send + Sync {
    /// The file.
    fn path(&self) -> &Path;

    /// What the raster is.
    fn info(&self) -> &RasterInfo;

    /// Reads heights in metres; NaN where the file holds no data.
    fn read_heights(&self, window: Window) -> Result<Vec<f32>, SourceError>;

    /// Reads sRGB colours and coverage (255 where there is a picture, 0 where not).
    fn read_colours(&self, window: Window) -> Result<Vec<[u8; 4]>, SourceError>;
}

/// Opens a raster of any supported format, told by its first bytes (and, for SRTM, its name).
pub fn open_raster(path: &Path) -> Result<Box<dyn RasterSource>, SourceError> {
    use std::io::Read;
    let is_hgt = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("hgt"));
    if is_hgt {
        return Ok(Box::new(HgtSource::open(path)?));
    }
    let mut magic = Vec::new();
    std::fs::File::open(path)
        .and_then(|file| file.take(8).read_to_end(&mut magic))
        .map_err(|error| SourceError::io(path, &error))?;
    match magic.as_slice() {
        [] => Err(SourceError::not_a_raster(path, "the file is empty")),
        [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] => {
            Ok(Box::new(GeoTiffSource::open(path)?))
        }
        [0x89, b'P', b'N', b'G', ..] | [0xff, 0xd8, 0xff, ..] => {
            Ok(Box::new(PictureSource::open(path)?))
        }
        _ => Err(SourceError::not_a_raster(path, "neither TIFF, PNG, JPEG nor .hgt")),
    }
}
