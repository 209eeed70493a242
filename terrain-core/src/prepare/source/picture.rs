use std::io::{Read, Seek, SeekFrom};
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
        check_end(path)?;
        let (width, height) = decoder.dimensions();
        let content = match decoder.color_type() {
            ColorType::L8 | ColorType::L16 | ColorType::La8 | ColorType::La16 => {
                RasterContent::SingleBand
            }
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

/// Decoders fill what is missing of a JPEG with grey; a whole one has an end marker.
fn check_end(path: &Path) -> Result<(), SourceError> {
    const START: [u8; 2] = [0xff, 0xd8];
    const END: [u8; 2] = [0xff, 0xd9];
    /// Some programs write a little after the end.
    const TAIL_BYTES: u64 = 4096;
    let read = || -> std::io::Result<([u8; 2], Vec<u8>)> {
        let mut file = std::fs::File::open(path)?;
        let (mut start, mut tail) = ([0; 2], Vec::new());
        file.read_exact(&mut start)?;
        let length = file.metadata()?.len();
        file.seek(SeekFrom::Start(length.saturating_sub(TAIL_BYTES)))?;
        file.read_to_end(&mut tail)?;
        Ok((start, tail))
    };
    let (start, tail) = read().map_err(|error| SourceError::io(path, &error))?;
    if start == START && !tail.windows(2).any(|pair| pair == END) {
        return Err(SourceError::damaged(path, "the JPEG ends before its end marker".to_owned()));
    }
    Ok(())
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
            // Grey with a clear value, as GDAL writes "no data".
            DynamicImage::ImageLumaA8(image) => {
                let height = |[value, coverage]: [u8; 2]| held(f32::from(value), coverage > 0);
                Ok(positions.map(|(x, y)| height(image.get_pixel(x, y).0)).collect())
            }
            DynamicImage::ImageLumaA16(image) => {
                let height = |[value, coverage]: [u16; 2]| held(f32::from(value), coverage > 0);
                Ok(positions.map(|(x, y)| height(image.get_pixel(x, y).0)).collect())
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

fn held(height_m: f32, is_held: bool) -> f32 {
    if is_held { height_m } else { f32::NAN }
}

fn positions(window: Window) -> impl Iterator<Item = (u32, u32)> {
    let columns = window.column..window.column + window.width;
    let rows = window.row..window.row + window.height;
    rows.flat_map(move |row| columns.clone().map(move |column| (column, row)))
}
