//! How one tile is turned into bytes and back.
//!
//! Every stored tile is a [`PayloadHeader`] and a body. The header names the form of the body and
//! holds a checksum over all the rest, so that a damaged tile is found before it is drawn.

mod bc7;
mod block_compression;
mod colours;
mod heights;
mod lanes;
mod linear_predictor;
mod payload_header;

pub use colours::{decode_colours, encode_colours};
pub use heights::{
    EXACT_STEPS, NO_DATA_STEPS, decode_heights, encode_height_steps, encode_heights_m,
};
pub use payload_header::{PayloadHeader, PayloadKind};

/// Why the bytes of a tile cannot be decoded. The caller knows which file and tile.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct DamagedPayload(pub String);

impl DamagedPayload {
    fn new(reason: impl Into<String>) -> Self {
        Self(reason.into())
    }
}

/// Packs one bit a sample, first sample in the lowest bit, and deflates the result.
fn deflate_mask(mask: impl Iterator<Item = bool>) -> Vec<u8> {
    let mut packed = Vec::new();
    for (index, bit) in mask.enumerate() {
        if index % 8 == 0 {
            packed.push(0);
        }
        if let Some(byte) = packed.last_mut() {
            *byte |= u8::from(bit) << (index % 8);
        }
    }
    deflate(&packed, flate2::Compression::best())
}

/// The inverse of [`deflate_mask`] for `count` samples.
fn inflate_mask(bytes: &[u8], count: usize) -> Result<Vec<bool>, DamagedPayload> {
    let packed = inflate(bytes, count.div_ceil(8))?;
    Ok((0..count).map(|index| packed[index / 8] >> (index % 8) & 1 == 1).collect())
}

fn deflate(bytes: &[u8], level: flate2::Compression) -> Vec<u8> {
    use std::io::Write;
    let mut encoder = flate2::write::DeflateEncoder::new(Vec::new(), level);
    // Writing to a vector cannot fail; were it to, the short body is caught by its reader.
    let _ = encoder.write_all(bytes);
    encoder.finish().unwrap_or_default()
}

/// Inflates to exactly `length` bytes.
fn inflate(bytes: &[u8], length: usize) -> Result<Vec<u8>, DamagedPayload> {
    use std::io::Read;
    let mut out = Vec::with_capacity(length);
    flate2::read::DeflateDecoder::new(bytes)
        .take(length as u64 + 1)
        .read_to_end(&mut out)
        .map_err(|error| DamagedPayload::new(error.to_string()))?;
    if out.len() == length {
        Ok(out)
    } else {
        Err(DamagedPayload::new(format!("{} bytes where {length} were expected", out.len())))
    }
}
