use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;
use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::{SampleFormat, Tag};
use tiff::{ColorType, TiffError};

use super::chunk_cache::ChunkCache;
use super::geo_keys::GeoTags;
use super::{RasterContent, RasterInfo, RasterSource, SourceError, Window};
use crate::dataset::HeightSamples;

/// Most bytes one strip or tile may decode to: it is the smallest part that can be read.
const MAX_CHUNK_BYTES: usize = 192 << 20;
/// Bytes of decoded strips and tiles kept. At least one full row of them is needed to read row by
/// row without decoding anything twice.
const CACHE_BYTES: usize = 160 << 20;

type FileDecoder = Decoder<BufReader<File>>;

/// A TIFF or BigTIFF of strips or tiles, georeferenced by GeoTIFF tags.
///
/// Chunks are decoded as windows ask for them, on all threads; each takes a decoder from a pool.
pub struct GeoTiffSource {
    path: PathBuf,
    info: RasterInfo,
    layout: ChunkLayout,
    nodata: Option<f64>,
    decoders: Mutex<Vec<FileDecoder>>,
    cache: ChunkCache<Chunk>,
}

/// How the raster is cut into chunks.
#[derive(Clone, Copy)]
struct ChunkLayout {
    chunk_size: (u32, u32),
    chunks_across: u32,
    colour: ColorType,
}

/// One decoded chunk, its padding removed.
struct Chunk {
    width: usize,
    samples: usize,
    data: DecodingResult,
}

impl GeoTiffSource {
    /// Opens the file and reads its tags.
    pub fn open(path: &Path) -> Result<Self, SourceError> {
        let mut decoder = open_decoder(path)?;
        let fault = |error: TiffError| fault_of(path, error);
        let (width, height) = decoder.dimensions().map_err(fault)?;
        if width == 0 || height == 0 {
            return Err(SourceError::not_a_raster(path, format!("{width} x {height} cells")));
        }
        let colour = decoder.colortype().map_err(fault)?;
        let chunk_size = decoder.chunk_dimensions();
        let layout =
            ChunkLayout { chunk_size, chunks_across: width.div_ceil(chunk_size.0), colour };
        check_layout(path, &mut decoder, &layout)?;
        let tags = geo_tags(&mut decoder);
        let nodata = nodata_of(&mut decoder);
        let info = RasterInfo {
            grid: tags.grid(path)?,
            size: [width, height],
            epsg: tags.epsg(),
            content: content_of(&mut decoder, colour),
            height_step_m: height_step_m(&mut decoder),
            notes: notes_of(path, &tags),
        };
        Ok(Self {
            path: path.to_owned(),
            info,
            layout,
            nodata,
            decoders: Mutex::new(vec![decoder]),
            cache: ChunkCache::new(CACHE_BYTES),
        })
    }

    /// Calls `visit` for every chunk the window meets, with the rows and columns they share. The
    /// chunks are decoded side by side.
    fn visit_chunks(
        &self,
        window: Window,
        mut visit: impl FnMut(&Chunk, Overlap),
    ) -> Result<(), SourceError> {
        let (chunk_width, chunk_height) = self.layout.chunk_size;
        let columns =
            window.column / chunk_width..=(window.column + window.width - 1) / chunk_width;
        let rows = window.row / chunk_height..=(window.row + window.height - 1) / chunk_height;
        let places: Vec<(u32, u32)> =
            rows.flat_map(|row| columns.clone().map(move |column| (column, row))).collect();
        let chunks: Vec<_> = places
            .par_iter()
            .map(|&(column, row)| {
                let index = row * self.layout.chunks_across + column;
                self.cache.get(index, || self.decode(index))
            })
            .collect::<Result<_, SourceError>>()?;
        for (chunk, (column, row)) in chunks.iter().zip(places) {
            let corner = (column * chunk_width, row * chunk_height);
            visit(chunk, Overlap::of(window, corner, self.layout.chunk_size));
        }
        Ok(())
    }

    fn decode(&self, index: u32) -> Result<(Chunk, usize), SourceError> {
        let pooled = self.decoders.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let mut decoder = match pooled {
            Some(decoder) => decoder,
            None => open_decoder(&self.path)?,
        };
        let (width, height) = decoder.chunk_data_dimensions(index);
        let data = decoder.read_chunk(index).map_err(|error| fault_of(&self.path, error))?;
        self.decoders.lock().unwrap_or_else(PoisonError::into_inner).push(decoder);
        let count = sample_count(&data);
        let texels = width as usize * height as usize;
        if texels == 0 || !count.is_multiple_of(texels) || count == 0 {
            return Err(SourceError::damaged(&self.path, format!("chunk {index} is incomplete")));
        }
        let bytes = count * sample_bytes(&data);
        Ok((Chunk { width: width as usize, samples: count / texels, data }, bytes))
    }
}

/// What a window and a chunk share.
struct Overlap {
    /// First column and row within the chunk.
    in_chunk: (usize, usize),
    /// First column and row within the window.
    in_window: (usize, usize),
    /// Columns and rows shared.
    size: (usize, usize),
}

impl Overlap {
    fn of(window: Window, corner: (u32, u32), chunk_size: (u32, u32)) -> Self {
        let axis = |first: u32, length: u32, corner: u32, chunk: u32| {
            let start = first.max(corner);
            let end = (first + length).min(corner.saturating_add(chunk));
            ((start - corner) as usize, (start - first) as usize, (end - start) as usize)
        };
        let x = axis(window.column, window.width, corner.0, chunk_size.0);
        let y = axis(window.row, window.height, corner.1, chunk_size.1);
        Self { in_chunk: (x.0, y.0), in_window: (x.1, y.1), size: (x.2, y.2) }
    }
}

impl RasterSource for GeoTiffSource {
    fn path(&self) -> &Path {
        &self.path
    }

    fn info(&self) -> &RasterInfo {
        &self.info
    }

    fn read_heights(&self, window: Window) -> Result<Vec<f32>, SourceError> {
        let mut out = vec![f32::NAN; window.len()];
        let width = window.width as usize;
        let nodata = self.nodata;
        self.visit_chunks(window, |chunk, overlap| {
            for row in 0..overlap.size.1 {
                let from = (overlap.in_chunk.1 + row) * chunk.width + overlap.in_chunk.0;
                let to = (overlap.in_window.1 + row) * width + overlap.in_window.0;
                let target = &mut out[to..to + overlap.size.0];
                copy_heights(&chunk.data, from, chunk.samples, nodata, target);
            }
        })?;
        Ok(out)
    }

    fn read_colours(&self, window: Window) -> Result<Vec<[u8; 4]>, SourceError> {
        let mut out = vec![[0; 4]; window.len()];
        let width = window.width as usize;
        let reader = PixelReader { colour: self.layout.colour, nodata: self.nodata };
        self.visit_chunks(window, |chunk, overlap| {
            for row in 0..overlap.size.1 {
                let from = (overlap.in_chunk.1 + row) * chunk.width + overlap.in_chunk.0;
                let to = (overlap.in_window.1 + row) * width + overlap.in_window.0;
                reader.copy(chunk, from, &mut out[to..to + overlap.size.0]);
            }
        })?;
        Ok(out)
    }
}

/// Turns stored samples into sRGB and coverage.
struct PixelReader {
    colour: ColorType,
    nodata: Option<f64>,
}

impl PixelReader {
    fn copy(&self, chunk: &Chunk, first: usize, out: &mut [[u8; 4]]) {
        let samples = chunk.samples;
        match &chunk.data {
            DecodingResult::U8(data) => {
                let texels = data[first * samples..].chunks_exact(samples);
                for (target, texel) in out.iter_mut().zip(texels) {
                    *target = self.pixel(texel);
                }
            }
            DecodingResult::U16(data) => {
                let texels = data[first * samples..].chunks_exact(samples);
                for (target, texel) in out.iter_mut().zip(texels) {
                    let high = |sample: &u16| (sample >> 8) as u8;
                    let bytes: [u8; 4] = std::array::from_fn(|c| texel.get(c).map_or(255, high));
                    *target = self.pixel(&bytes[..samples.min(4)]);
                }
            }
            _ => {}
        }
    }

    fn pixel(&self, texel: &[u8]) -> [u8; 4] {
        let covered = |parts: &[u8]| match self.nodata {
            Some(nodata) if parts.iter().all(|&part| f64::from(part) == nodata) => 0,
            _ => 255,
        };
        match (self.colour, texel) {
            (ColorType::YCbCr(_), &[y, cb, cr, ..]) => rgb_of_ycbcr(y, cb, cr),
            (ColorType::RGBA(_), &[r, g, b, a, ..]) => [r, g, b, a],
            (_, &[r, g, b, ..]) => [r, g, b, covered(&[r, g, b])],
            (ColorType::GrayA(_), &[grey, a]) => [grey, grey, grey, a],
            (_, &[grey, ..]) => [grey, grey, grey, covered(&[grey])],
            _ => [0; 4],
        }
    }
}

/// ITU-R BT.601 over the full range, as JPEG uses it.
fn rgb_of_ycbcr(y: u8, cb: u8, cr: u8) -> [u8; 4] {
    let (y, cb, cr) = (f32::from(y), f32::from(cb) - 128.0, f32::from(cr) - 128.0);
    let byte = |value: f32| (value + 0.5).clamp(0.0, 255.0) as u8;
    [byte(y + 1.402 * cr), byte(y - 0.344_136 * cb - 0.714_136 * cr), byte(y + 1.772 * cb), 255]
}

fn copy_heights(
    data: &DecodingResult,
    first: usize,
    samples: usize,
    nodata: Option<f64>,
    out: &mut [f32],
) {
    fn copy<T: Copy>(
        data: &[T],
        (first, samples): (usize, usize),
        nodata: Option<f64>,
        out: &mut [f32],
        as_f64: impl Fn(T) -> f64,
    ) {
        let values = data[first * samples..].iter().step_by(samples);
        for (target, &value) in out.iter_mut().zip(values) {
            let value = as_f64(value);
            let held = nodata.is_none_or(|nodata| value != nodata)
                && HeightSamples::is_height(value as f32);
            *target = if held { value as f32 } else { f32::NAN };
        }
    }
    let at = (first, samples);
    match data {
        DecodingResult::U8(data) => copy(data, at, nodata, out, f64::from),
        DecodingResult::I8(data) => copy(data, at, nodata, out, f64::from),
        DecodingResult::U16(data) => copy(data, at, nodata, out, f64::from),
        DecodingResult::I16(data) => copy(data, at, nodata, out, f64::from),
        DecodingResult::U32(data) => copy(data, at, nodata, out, f64::from),
        DecodingResult::I32(data) => copy(data, at, nodata, out, f64::from),
        // A float "no data" value is written as text; it is compared as the f32 it stands for.
        DecodingResult::F32(data) => {
            let nodata = nodata.map(|nodata| f64::from(nodata as f32));
            copy(data, at, nodata, out, f64::from);
        }
        DecodingResult::F64(data) => copy(data, at, nodata, out, |value| value),
        _ => {}
    }
}

fn open_decoder(path: &Path) -> Result<FileDecoder, SourceError> {
    let file = File::open(path).map_err(|error| SourceError::io(path, &error))?;
    let mut limits = Limits::default();
    limits.decoding_buffer_size = MAX_CHUNK_BYTES;
    limits.intermediate_buffer_size = MAX_CHUNK_BYTES;
    // A large raster of small chunks has long tables of where they are.
    limits.ifd_value_size = 64 << 20;
    let decoder = Decoder::new(BufReader::new(file)).map_err(|error| fault_of(path, error))?;
    Ok(decoder.with_limits(limits))
}

fn fault_of(path: &Path, error: TiffError) -> SourceError {
    match error {
        TiffError::UnsupportedError(error) => SourceError::unsupported(
            path,
            format!(
                "this form of TIFF is not supported ({error}); `gdal_translate` can rewrite it"
            ),
        ),
        TiffError::LimitsExceeded => SourceError::unsupported(
            path,
            "its strips are too large to read in parts; `gdal_translate -co TILED=YES` can cut them",
        ),
        error => SourceError::damaged(path, error.to_string()),
    }
}

fn check_layout(
    path: &Path,
    decoder: &mut FileDecoder,
    layout: &ChunkLayout,
) -> Result<(), SourceError> {
    let planar = decoder.find_tag_unsigned::<u16>(Tag::PlanarConfiguration).ok().flatten();
    let several = !matches!(layout.colour, ColorType::Gray(_));
    if planar == Some(2) && several {
        let way_out = "its bands lie apart; `gdal_translate -co INTERLEAVE=PIXEL` can join them";
        return Err(SourceError::unsupported(path, way_out));
    }
    match layout.colour {
        ColorType::Gray(8 | 16 | 32 | 64)
        | ColorType::GrayA(8 | 16)
        | ColorType::RGB(8 | 16)
        | ColorType::RGBA(8 | 16)
        | ColorType::YCbCr(8)
        | ColorType::Multiband { .. } => Ok(()),
        other => Err(SourceError::unsupported(
            path,
            format!("{other:?} cells are not supported; `gdal_translate -expand rgb` may help"),
        )),
    }
}

fn content_of(decoder: &mut FileDecoder, colour: ColorType) -> RasterContent {
    match colour {
        ColorType::RGB(_) | ColorType::RGBA(_) | ColorType::YCbCr(_) => RasterContent::Picture,
        _ if sample_format(decoder) == SampleFormat::Uint && colour.bit_depth() <= 16 => {
            RasterContent::SingleBand
        }
        _ => RasterContent::Measurements,
    }
}

fn height_step_m(decoder: &mut FileDecoder) -> f64 {
    if sample_format(decoder) == SampleFormat::IEEEFP { 0.0 } else { 1.0 }
}

/// Of the first band; whole numbers without a sign where nothing is said.
fn sample_format(decoder: &mut FileDecoder) -> SampleFormat {
    let formats = decoder.find_tag_unsigned_vec::<u16>(Tag::SampleFormat).ok().flatten();
    let first = formats.and_then(|formats| formats.first().copied());
    first.and_then(SampleFormat::from_u16).unwrap_or(SampleFormat::Uint)
}

fn geo_tags(decoder: &mut FileDecoder) -> GeoTags {
    GeoTags {
        pixel_scale: decoder.get_tag_f64_vec(Tag::ModelPixelScaleTag).ok(),
        tie_points: decoder.get_tag_f64_vec(Tag::ModelTiepointTag).ok(),
        transformation: decoder.get_tag_f64_vec(Tag::ModelTransformationTag).ok(),
        key_directory: decoder.get_tag_u16_vec(Tag::GeoKeyDirectoryTag).ok(),
    }
}

fn nodata_of(decoder: &mut FileDecoder) -> Option<f64> {
    let text = decoder.get_tag_ascii_string(Tag::GdalNodata).ok()?;
    text.trim_matches(['\0', ' ']).parse().ok()
}

fn notes_of(path: &Path, tags: &GeoTags) -> Vec<String> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let mut notes = Vec::new();
    if tags.is_pixel_is_point() {
        notes.push(format!(
            "{name}: heights stand for points (PixelIsPoint); cells centred on them"
        ));
    }
    if tags.has_other_crs() {
        notes.push(format!("{name}: its CRS is given without an EPSG code"));
    }
    notes
}

fn sample_count(data: &DecodingResult) -> usize {
    match data {
        DecodingResult::U8(data) => data.len(),
        DecodingResult::I8(data) => data.len(),
        DecodingResult::U16(data) => data.len(),
        DecodingResult::I16(data) => data.len(),
        DecodingResult::U32(data) => data.len(),
        DecodingResult::I32(data) => data.len(),
        DecodingResult::F32(data) => data.len(),
        DecodingResult::F64(data) => data.len(),
        _ => 0,
    }
}

fn sample_bytes(data: &DecodingResult) -> usize {
    match data {
        DecodingResult::U8(_) | DecodingResult::I8(_) => 1,
        DecodingResult::U16(_) | DecodingResult::I16(_) => 2,
        DecodingResult::F64(_) => 8,
        _ => 4,
    }
}
