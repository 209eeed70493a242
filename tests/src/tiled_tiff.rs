use std::fs::File;
use std::path::Path;

use tiff::TiffResult;
use tiff::encoder::TiffEncoder;
use tiff::tags::Tag;

use crate::RasterFixture;

/// Columns and rows of a tile.
const TILE: [usize; 2] = [32, 48];

/// The number of a predictor, and what it makes of a row of a tile.
type Predictor<const BYTES: usize> = (u16, fn(&[[u8; BYTES]]) -> Vec<u8>);

/// How the cells of a tiled TIFF of `BYTES` bytes each are stored.
pub(crate) struct TileForm<const BYTES: usize> {
    /// Bits of each sample of a cell.
    pub bits: &'static [u16],
    /// SampleFormat: 1 unsigned, 2 signed, 3 floating point.
    pub sample_format: u16,
    /// Where there is one, tiles are deflated.
    pub predictor: Option<Predictor<BYTES>>,
}

impl RasterFixture {
    /// Writes cells, each as its bytes with the lowest first, in tiles.
    pub(crate) fn write_tiles<const BYTES: usize>(
        &self,
        path: &Path,
        cells: &[[u8; BYTES]],
        form: &TileForm<BYTES>,
    ) -> TiffResult<()> {
        let mut encoder = TiffEncoder::new(File::create(path)?)?;
        let mut directory = encoder.image_directory()?;
        let (mut offsets, mut lengths) = (Vec::new(), Vec::new());
        for tile in tiles_of(cells, self.size) {
            let bytes = form.bytes_of(&tile);
            offsets.push(directory.write_data(&bytes[..])? as u32);
            lengths.push(bytes.len() as u32);
        }
        let samples = form.bits.len() as u16;
        directory.write_tag(Tag::ImageWidth, self.size[0])?;
        directory.write_tag(Tag::ImageLength, self.size[1])?;
        directory.write_tag(Tag::BitsPerSample, form.bits)?;
        directory.write_tag(Tag::Compression, if form.predictor.is_some() { 8_u16 } else { 1 })?;
        // Black is zero, or red, green, blue.
        directory
            .write_tag(Tag::PhotometricInterpretation, if samples == 1 { 1_u16 } else { 2 })?;
        directory.write_tag(Tag::SamplesPerPixel, samples)?;
        directory.write_tag(Tag::SampleFormat, &vec![form.sample_format; form.bits.len()][..])?;
        directory.write_tag(Tag::TileWidth, TILE[0] as u32)?;
        directory.write_tag(Tag::TileLength, TILE[1] as u32)?;
        directory.write_tag(Tag::TileOffsets, &offsets[..])?;
        directory.write_tag(Tag::TileByteCounts, &lengths[..])?;
        if let Some((number, _)) = form.predictor {
            directory.write_tag(Tag::Predictor, number)?;
        }
        if samples == 4 {
            // Coverage that the colours are not multiplied by.
            directory.write_tag(Tag::ExtraSamples, 2_u16)?;
        }
        self.write_geo_tags(&mut directory)?;
        directory.finish()
    }
}

impl<const BYTES: usize> TileForm<BYTES> {
    fn bytes_of(&self, tile: &[[u8; BYTES]]) -> Vec<u8> {
        match self.predictor {
            None => tile.as_flattened().to_vec(),
            Some((_, predict)) => {
                stored_zlib(&tile.chunks(TILE[0]).flat_map(predict).collect::<Vec<_>>())
            }
        }
    }
}

/// The cells tile by tile, row by row; zero beyond the raster.
fn tiles_of<const BYTES: usize>(
    cells: &[[u8; BYTES]],
    size: [u32; 2],
) -> impl Iterator<Item = Vec<[u8; BYTES]>> {
    let [width, height] = size.map(|side| side as usize);
    let [across, down] = [width.div_ceil(TILE[0]), height.div_ceil(TILE[1])];
    (0..across * down).map(move |tile| {
        let cell = |index: usize| {
            let x = tile % across * TILE[0] + index % TILE[0];
            let y = tile / across * TILE[1] + index / TILE[0];
            if x < width && y < height { cells[y * width + x] } else { [0; BYTES] }
        };
        (0..TILE[0] * TILE[1]).map(cell).collect()
    })
}

/// Predictor 2 of 16-bit samples: differences along the row.
pub(crate) fn differences_of_u16(row: &[[u8; 2]]) -> Vec<u8> {
    let sample = |index: usize| u16::from_le_bytes(row[index]);
    let before = |index: usize| if index == 0 { 0 } else { sample(index - 1) };
    (0..row.len())
        .flat_map(|index| sample(index).wrapping_sub(before(index)).to_le_bytes())
        .collect()
}

/// Predictor 2 of cells of four samples of 8 bits.
pub(crate) fn differences_of_rgba(row: &[[u8; 4]]) -> Vec<u8> {
    let before = |index: usize| if index == 0 { [0; 4] } else { row[index - 1] };
    (0..row.len())
        .flat_map(|index| {
            std::array::from_fn::<u8, 4, _>(|c| row[index][c].wrapping_sub(before(index)[c]))
        })
        .collect()
}

/// Predictor 3: all highest bytes of a row, then all next ones, and so on; differences along all of them
/// (Adobe, "Adobe Photoshop TIFF Technical Note 3", 2005).
pub(crate) fn planes_of_f32(row: &[[u8; 4]]) -> Vec<u8> {
    let planes: Vec<u8> =
        (0..4).rev().flat_map(|byte| row.iter().map(move |cell| cell[byte])).collect();
    let before = |index: usize| if index == 0 { 0 } else { planes[index - 1] };
    (0..planes.len()).map(|index| planes[index].wrapping_sub(before(index))).collect()
}

/// A zlib stream of blocks that are stored as they are (Deutsch, "DEFLATE Compressed Data Format
/// Specification", RFC 1951, 1996; Deutsch and Gailly, "ZLIB", RFC 1950, 1996).
fn stored_zlib(data: &[u8]) -> Vec<u8> {
    let mut stream = vec![0x78, 0x01];
    let blocks = data.chunks(0xffff);
    let last = blocks.len().saturating_sub(1);
    for (index, block) in blocks.enumerate() {
        let length = block.len() as u16;
        stream.push(u8::from(index == last));
        stream.extend(length.to_le_bytes());
        stream.extend((!length).to_le_bytes());
        stream.extend(block);
    }
    let (a, b) = data.iter().fold((1, 0), |(a, b), &byte| {
        let a = (a + u32::from(byte)) % 65_521;
        (a, (b + a) % 65_521)
    });
    stream.extend(((b << 16) | a).to_be_bytes());
    stream
}
