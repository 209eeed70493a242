use std::fs::File;
use std::path::Path;

use tiff::encoder::colortype::{ColorType, Gray16, Gray32Float, GrayI16, RGB8};
use tiff::encoder::compression::DeflateLevel;
use tiff::encoder::{
    Compression, DirectoryEncoder, Predictor, TiffEncoder, TiffKind, TiffKindBig, TiffKindStandard,
    TiffValue,
};
use tiff::tags::Tag;

use crate::tiled_tiff::{TileForm, differences_of_rgba, differences_of_u16, planes_of_f32};

/// How a GeoTIFF is written for a case, and where it says it lies.
#[derive(Clone, Debug)]
pub struct RasterFixture {
    /// Columns and rows.
    pub size: [u32; 2],
    /// North-west corner of the first cell, or its centre with `is_point`.
    pub tie: [f64; 2],
    /// Width and height of a cell.
    pub cell: [f64; 2],
    /// EPSG code; codes from 4000 to 5000 are written as geographic.
    pub epsg: u16,
    /// PixelIsPoint instead of PixelIsArea.
    pub is_point: bool,
    /// The text of GDAL_NODATA.
    pub nodata: Option<&'static str>,
    /// How samples are stored.
    pub storage: Storage,
}

/// The forms a TIFF may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Storage {
    /// Strips of 16 rows, not compressed.
    Plain,
    /// Deflate with differences along rows.
    Deflate,
    /// LZW with differences along rows.
    Lzw,
    /// Runs of equal bytes.
    PackBits,
    /// BigTIFF, deflated.
    Big,
    /// Tiles of 32 x 48 texels, not compressed.
    Tiled,
    /// The same deflated, with the predictor that suits the samples. Pictures without coverage are not
    /// written in tiles.
    DeflatedTiles,
}

impl Storage {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Plain,
        Self::Deflate,
        Self::Lzw,
        Self::PackBits,
        Self::Big,
        Self::Tiled,
        Self::DeflatedTiles,
    ];
}

type WriteResult = tiff::TiffResult<()>;

impl RasterFixture {
    /// A raster in UTM zone 32 N with square cells.
    pub fn utm(size: [u32; 2], tie: [f64; 2], cell_m: f64) -> Self {
        let cell = [cell_m, cell_m];
        let storage = Storage::Deflate;
        Self { size, tie, cell, epsg: 32632, is_point: false, nodata: None, storage }
    }

    /// Writes 16-bit heights.
    ///
    /// # Errors
    /// Where the file cannot be written.
    pub fn write_i16(&self, path: &Path, heights: &[i16]) -> WriteResult {
        let Some(predictor) = self.tile_predictor((2, differences_of_u16 as _)) else {
            return self.write::<GrayI16>(path, heights);
        };
        let cells = heights.iter().map(|height| height.to_le_bytes()).collect::<Vec<_>>();
        self.write_tiles(path, &cells, &TileForm { bits: &[16], sample_format: 2, predictor })
    }

    /// Writes 16-bit heights without a sign.
    ///
    /// # Errors
    /// Where the file cannot be written.
    pub fn write_u16(&self, path: &Path, heights: &[u16]) -> WriteResult {
        let Some(predictor) = self.tile_predictor((2, differences_of_u16 as _)) else {
            return self.write::<Gray16>(path, heights);
        };
        let cells = heights.iter().map(|height| height.to_le_bytes()).collect::<Vec<_>>();
        self.write_tiles(path, &cells, &TileForm { bits: &[16], sample_format: 1, predictor })
    }

    /// Writes float heights; in deflated tiles by the predictor for floats.
    ///
    /// # Errors
    /// Where the file cannot be written.
    pub fn write_f32(&self, path: &Path, heights: &[f32]) -> WriteResult {
        let Some(predictor) = self.tile_predictor((3, planes_of_f32 as _)) else {
            return self.write::<Gray32Float>(path, heights);
        };
        let cells = heights.iter().map(|height| height.to_le_bytes()).collect::<Vec<_>>();
        self.write_tiles(path, &cells, &TileForm { bits: &[32], sample_format: 3, predictor })
    }

    /// Writes a picture of colours and coverage, in deflated tiles whatever the storage.
    ///
    /// # Errors
    /// Where the file cannot be written.
    pub fn write_rgba(&self, path: &Path, rgba: &[[u8; 4]]) -> WriteResult {
        let predictor = Some((2, differences_of_rgba as _));
        self.write_tiles(path, rgba, &TileForm { bits: &[8; 4], sample_format: 1, predictor })
    }

    /// What becomes of the rows of tiles: this where they are deflated, nothing where they are not; `None`
    /// where there are no tiles.
    fn tile_predictor<P>(&self, predictor: P) -> Option<Option<P>> {
        match self.storage {
            Storage::Tiled => Some(None),
            Storage::DeflatedTiles => Some(Some(predictor)),
            _ => None,
        }
    }

    /// Writes a picture of three bytes a pixel.
    ///
    /// # Errors
    /// Where the file cannot be written.
    pub fn write_rgb(&self, path: &Path, rgb: &[u8]) -> WriteResult {
        self.write::<RGB8>(path, rgb)
    }

    fn write<C: ColorType>(&self, path: &Path, samples: &[C::Inner]) -> WriteResult
    where
        [C::Inner]: TiffValue,
    {
        let file = File::create(path)?;
        match self.storage {
            Storage::Big => self.encode::<C, TiffKindBig>(TiffEncoder::new_big(file)?, samples),
            _ => self.encode::<C, TiffKindStandard>(TiffEncoder::new(file)?, samples),
        }
    }

    fn encode<C: ColorType, K: TiffKind>(
        &self,
        encoder: TiffEncoder<File, K>,
        samples: &[C::Inner],
    ) -> WriteResult
    where
        [C::Inner]: TiffValue,
    {
        let deflate = Compression::Deflate(DeflateLevel::Fast);
        let is_float = C::SAMPLE_FORMAT[0] == tiff::tags::SampleFormat::IEEEFP;
        let predictor = if is_float { Predictor::None } else { Predictor::Horizontal };
        let mut encoder = match self.storage {
            Storage::Plain | Storage::Tiled | Storage::DeflatedTiles => encoder,
            Storage::Deflate => encoder.with_compression(deflate).with_predictor(predictor),
            Storage::Lzw => encoder.with_compression(Compression::Lzw).with_predictor(predictor),
            Storage::PackBits => encoder.with_compression(Compression::Packbits),
            Storage::Big => encoder.with_compression(deflate),
        };
        let mut image = encoder.new_image::<C>(self.size[0], self.size[1])?;
        image.rows_per_strip(16)?;
        self.write_geo_tags(image.encoder())?;
        image.write_data(samples)
    }

    pub(crate) fn write_geo_tags<K: TiffKind>(
        &self,
        directory: &mut DirectoryEncoder<'_, File, K>,
    ) -> WriteResult {
        let geographic = (4000..5000).contains(&self.epsg);
        let (model, crs_key) = if geographic { (2, 2048) } else { (1, 3072) };
        let raster_type = if self.is_point { 2 } else { 1 };
        let keys: [u16; 16] =
            [1, 1, 0, 3, 1024, 0, 1, model, 1025, 0, 1, raster_type, crs_key, 0, 1, self.epsg];
        let scale = [self.cell[0], self.cell[1], 0.0];
        let tie_point = [0.0, 0.0, 0.0, self.tie[0], self.tie[1], 0.0];
        directory.write_tag(Tag::ModelPixelScaleTag, &scale[..])?;
        directory.write_tag(Tag::ModelTiepointTag, &tie_point[..])?;
        directory.write_tag(Tag::GeoKeyDirectoryTag, &keys[..])?;
        if let Some(nodata) = self.nodata {
            directory.write_tag(Tag::GdalNodata, nodata)?;
        }
        Ok(())
    }
}
