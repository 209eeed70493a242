use flate2::Compression;

use super::block_compression::blocks_of_rgba;
use super::{
    DamagedPayload, PayloadHeader, PayloadKind, deflate, deflate_mask, inflate, inflate_mask,
};
use crate::dataset::{ColourEncoding, ColourFormat, ColourTile};
use crate::tiling::TileId;

/// Quality of JPEG tiles, of 100: no visible loss on imagery at a fifth of the size of BC7.
const JPEG_QUALITY: u8 = 88;

/// Encodes a square of RGBA8 texels (sRGB colour, linear coverage), a multiple of 4 a side.
pub fn encode_colours(
    rgba: &[u8],
    size_texels: u32,
    encoding: ColourEncoding,
) -> Result<Vec<u8>, DamagedPayload> {
    let blocks = |format| {
        deflate(&blocks_of_rgba(rgba, size_texels, format), Compression::new(BLOCK_EFFORT))
    };
    let (kind, body) = match encoding {
        ColourEncoding::Bc1 => (PayloadKind::Bc1, blocks(ColourFormat::Bc1)),
        ColourEncoding::Bc7 => (PayloadKind::Bc7, blocks(ColourFormat::Bc7)),
        ColourEncoding::Rgba8 => (PayloadKind::Rgba8, blocks(ColourFormat::Rgba8)),
        ColourEncoding::Jpeg => (PayloadKind::Jpeg, jpeg_body(rgba, size_texels)?),
    };
    let header = PayloadHeader { kind, stored_size_texels: size_texels as u16, range: None };
    Ok(header.seal(&body))
}

/// Effort of deflating blocks: theirs is the entropy of noise, more effort gains next to nothing.
const BLOCK_EFFORT: u32 = 1;

/// Decodes a tile to the format; only JPEG tiles are ever changed from one format to another.
pub fn decode_colours(
    payload: &[u8],
    id: TileId,
    size_texels: u32,
    format: ColourFormat,
) -> Result<ColourTile, DamagedPayload> {
    let (header, body) = PayloadHeader::open(payload)?;
    if u32::from(header.stored_size_texels) != size_texels {
        let size = header.stored_size_texels;
        return Err(DamagedPayload::new(format!("{size} texels a side, not {size_texels}")));
    }
    let length = format.byte_len(size_texels) as usize;
    let data = match (header.kind, format) {
        (PayloadKind::Bc1, ColourFormat::Bc1)
        | (PayloadKind::Bc7, ColourFormat::Bc7)
        | (PayloadKind::Rgba8, ColourFormat::Rgba8) => inflate(body, length)?,
        (PayloadKind::Jpeg, _) => {
            blocks_of_rgba(&rgba_of_jpeg_body(body, size_texels)?, size_texels, format)
        }
        (kind, _) => return Err(DamagedPayload::new(format!("{kind:?} is not {format:?}"))),
    };
    Ok(ColourTile { id, stored_size_texels: size_texels, format, data })
}

/// Length of the picture (u32), the picture, and the deflated coverage where there are gaps.
fn jpeg_body(rgba: &[u8], size_texels: u32) -> Result<Vec<u8>, DamagedPayload> {
    let mut picture = Vec::new();
    let side = size_texels as u16;
    jpeg_encoder::Encoder::new(&mut picture, JPEG_QUALITY)
        .encode(rgba, side, side, jpeg_encoder::ColorType::Rgba)
        .map_err(|error| DamagedPayload::new(error.to_string()))?;
    let mut body = (picture.len() as u32).to_le_bytes().to_vec();
    body.extend(picture);
    let coverage = || rgba.iter().skip(3).step_by(4).map(|&alpha| alpha >= 128);
    if !coverage().all(|covered| covered) {
        body.extend(deflate_mask(coverage()));
    }
    Ok(body)
}

fn rgba_of_jpeg_body(body: &[u8], size_texels: u32) -> Result<Vec<u8>, DamagedPayload> {
    let cut = || DamagedPayload::new("the picture is cut short");
    let (length, rest) = body.split_first_chunk::<4>().ok_or_else(cut)?;
    let (picture, mask) =
        rest.split_at_checked(u32::from_le_bytes(*length) as usize).ok_or_else(cut)?;
    let image = image::load_from_memory_with_format(picture, image::ImageFormat::Jpeg)
        .map_err(|error| DamagedPayload::new(error.to_string()))?;
    let mut rgba = image.into_rgba8();
    if rgba.dimensions() != (size_texels, size_texels) {
        return Err(DamagedPayload::new("the picture has another size"));
    }
    if !mask.is_empty() {
        let covered = inflate_mask(mask, (size_texels * size_texels) as usize)?;
        for (texel, covered) in rgba.pixels_mut().zip(covered) {
            texel.0[3] = if covered { 255 } else { 0 };
        }
    }
    Ok(rgba.into_raw())
}

#[cfg(test)]
mod tests {
    use block_compression::CompressionVariant;
    use block_compression::decode::decompress_blocks_as_rgba8;

    use super::*;

    const SIZE: u32 = 32;

    fn picture(gaps: bool) -> Vec<u8> {
        (0..SIZE * SIZE)
            .flat_map(|index| {
                let (row, column) = (index / SIZE, index % SIZE);
                let covered = !gaps || row + column < SIZE;
                [4 * row as u8, 8 * column as u8, 120, if covered { 255 } else { 0 }]
            })
            .collect()
    }

    fn rgba_of(tile: &ColourTile) -> Vec<u8> {
        let variant = match tile.format {
            ColourFormat::Rgba8 => return tile.data.clone(),
            ColourFormat::Bc1 => CompressionVariant::BC1,
            ColourFormat::Bc7 => {
                CompressionVariant::BC7(block_compression::BC7Settings::alpha_basic())
            }
        };
        let mut rgba = vec![0; (SIZE * SIZE * 4) as usize];
        decompress_blocks_as_rgba8(variant, SIZE, SIZE, &tile.data, &mut rgba);
        rgba
    }

    #[test]
    fn every_encoding_comes_back_near_and_keeps_its_coverage() {
        use ColourEncoding::{Bc1, Bc7, Jpeg, Rgba8};
        let cases = [
            (Bc1, ColourFormat::Bc1, 24.0),
            // Blocks on the border of the imagery share their one line with coverage.
            (Bc7, ColourFormat::Bc7, 16.0),
            (Rgba8, ColourFormat::Rgba8, 0.0),
            (Jpeg, ColourFormat::Rgba8, 12.0),
            (Jpeg, ColourFormat::Bc7, 20.0),
        ];
        for gaps in [false, true] {
            let rgba = picture(gaps);
            for (encoding, format, tolerance) in cases {
                let payload = encode_colours(&rgba, SIZE, encoding).unwrap();
                let tile = decode_colours(&payload, TileId::ROOT, SIZE, format).unwrap();
                assert_eq!(tile.data.len() as u64, format.byte_len(SIZE));
                let got = rgba_of(&tile);
                for (index, (a, b)) in rgba.chunks(4).zip(got.chunks(4)).enumerate() {
                    assert_eq!(a[3] >= 128, b[3] >= 128, "{encoding:?} coverage of {index}");
                    let worst = a[..3].iter().zip(b).map(|(&a, &b)| a.abs_diff(b)).max();
                    // One line through colour and coverage cannot follow both where they part.
                    let slack = if gaps { 12.0 } else { 0.0 };
                    let near = f64::from(worst.unwrap_or(0)) <= tolerance + slack;
                    assert!(near || a[3] == 0, "{encoding:?} {gaps} texel {index}: {a:?} {b:?}");
                }
            }
        }
    }

    #[test]
    fn a_tile_of_another_kind_or_size_is_refused() {
        let payload = encode_colours(&picture(false), SIZE, ColourEncoding::Bc7).unwrap();
        assert!(decode_colours(&payload, TileId::ROOT, SIZE, ColourFormat::Bc1).is_err());
        assert!(decode_colours(&payload, TileId::ROOT, 64, ColourFormat::Bc7).is_err());
    }
}
