use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use image::{ColorType, DynamicImage, ImageDecoder, ImageReader};

use super::world_file::grid_beside;
use super::{RasterContent, RasterInfo, RasterSource, SourceError, Window};

/// Most pixels of a picture: PNG and JPEG are decoded whole.
const MAX_PIXELS: u64 = 100_000_000;

/// A PNG or JPEG, placed by a world file beside it. Decoded whole when first read.
pub struct PictureSource {
    path: PathBuf,
    info: RasterInfo,
    pixels: OnceLock<Result<DynamicImage, SourceError>>,
}

impl PictureSource {
    /// Reads the size of the picture and its world file.
    pub fn open(path: &Path) -> Result<Self, SourceError> {
        let decoder = reader(path)?
            .into_decoder()
            .map_err(|error| SourceError::damaged(path, error.to_string()))?;
        let (width, height) = decoder.dimensions();
        let content = match decoder.color_type() {
            ColorType::L8 | ColorType::L16 => RasterContent::SingleBand,
            _ => RasterContent::Picture,
        };
        if width == 0 || height == 0 {
            return Err(SourceError::not_a_raster(path, format!("{width} x {height} pixels")));
        }
        if u64::from(width) * u64::from(height) > MAX_PIXELS {
            let way_out = format!(
                "{width} x {height} pixels are too many to decode at once; \
                 `gdal_translate -co TILED=YES` to GeoTIFF makes it readable in parts"
            );
            return Err(SourceError::unsupported(path, way_out));
        }
        let info = RasterInfo {
            grid: grid_beside(path)?,
            size: [width, height],
            epsg: None,
            content,
            height_step_m: 1.0,
            notes: Vec::new(),
        };
        Ok(Self { path: path.to_owned(), info, pixels: OnceLock::new() })
    }

    fn pixels(&self) -> Result<&DynamicImage, SourceError> {
        self.pixels.get_or_init(|| decode(&self.path)).as_ref().map_err(Clone::clone)
    }
}

fn reader(path: &Path) -> Result<ImageReader<std::io::BufReader<std::fs::File>>, SourceError> {
    let mut reader = ImageReader::open(path)
        .and_then(ImageReader::with_guessed_format)
        .map_err(|error| SourceError::io(path, &error))?;
    // The size is limited in pixels, above.
    reader.no_limits();
    Ok(reader)
}

fn decode(path: &Path) -> Result<DynamicImage, SourceError> {
    reader(path)?.decode().map_err(|error| SourceError::damaged(path, error.to_string()))
}

impl RasterSource for PictureSource {
    fn path(&self) -> &Path {
        &self.path
    }

    fn info(&self) -> &RasterInfo {
        &self.info
    }

    fn read_heights(&self, window: Window) -> Result<Vec<f32>, SourceError> {
        let positions = positions(window);
        match self.pixels()? {
            DynamicImage::ImageLuma8(image) => {
                Ok(positions.map(|(x, y)| f32::from(image.get_pixel(x, y).0[0])).collect())
            }
            DynamicImage::ImageLuma16(image) => {
                Ok(positions.map(|(x, y)| f32::from(image.get_pixel(x, y).0[0])).collect())
            }
            _ => Err(SourceError::unsupported(
                &self.path,
                "heights need one band; this picture has several",
            )),
        }
    }

    fn read_colours(&self, window: Window) -> Result<Vec<[u8; 4]>, SourceError> {
        use image::GenericImageView;
        let positions = positions(window);
        Ok(match self.pixels()? {
            DynamicImage::ImageRgb8(image) => positions
                .map(|(x, y)| image.get_pixel(x, y).0)
                .map(|[r, g, b]| [r, g, b, 255])
                .collect(),
            other => positions.map(|(x, y)| other.get_pixel(x, y).0).collect(),
        })
    }
}

fn positions(window: Window) -> impl Iterator<Item = (u32, u32)> {
    let columns = window.column..window.column + window.width;
    let rows = window.row..window.row + window.height;
    rows.flat_map(move |row| columns.clone().map(move |column| (column, row)))
}
