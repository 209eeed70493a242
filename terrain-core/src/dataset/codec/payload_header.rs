use super::DamagedPayload;
use crate::dataset::HeightRange;

/// The form of a tile's body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum PayloadKind {
    /// Heights in steps: predicted, residuals compressed.
    HeightSteps = 1,
    /// Heights in metres, float32, compressed.
    HeightMetres = 2,
    /// BC1 blocks, deflated.
    Bc1 = 16,
    /// BC7 blocks, deflated.
    Bc7 = 17,
    /// RGBA8 texels, deflated.
    Rgba8 = 18,
    /// A JPEG picture and, where the tile is partly covered, its coverage.
    Jpeg = 19,
}

/// The first bytes of every stored tile, little-endian: kind (u8), version (u8), texels a side (u16),
/// CRC-32 of everything else (u32), lowest and highest height (f32 each; NaN where there is none).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PayloadHeader {
    /// Form of the body.
    pub kind: PayloadKind,
    /// Texels along one side, gutter counted.
    pub stored_size_texels: u16,
    /// Range of the heights; `None` for colours and for tiles without data.
    pub range: Option<HeightRange>,
}

impl PayloadHeader {
    /// Bytes of an encoded header.
    pub const LEN: usize = 16;
    const VERSION: u8 = 1;

    /// The payload of this header and a body.
    pub fn seal(&self, body: &[u8]) -> Vec<u8> {
        let range = self.range.unwrap_or(HeightRange { min_m: f32::NAN, max_m: f32::NAN });
        let mut bytes = Vec::with_capacity(Self::LEN + body.len());
        bytes.extend([self.kind as u8, Self::VERSION]);
        bytes.extend(self.stored_size_texels.to_le_bytes());
        bytes.extend([0; 4]);
        bytes.extend(range.min_m.to_le_bytes());
        bytes.extend(range.max_m.to_le_bytes());
        bytes.extend(body);
        let checksum = checksum(&bytes);
        bytes[4..8].copy_from_slice(&checksum.to_le_bytes());
        bytes
    }

    /// Reads the header of a payload, checks its checksum and returns the body.
    pub fn open(payload: &[u8]) -> Result<(Self, &[u8]), DamagedPayload> {
        let short = || DamagedPayload::new(format!("only {} bytes", payload.len()));
        let (head, body) = payload.split_at_checked(Self::LEN).ok_or_else(short)?;
        let word = |at: usize| [head[at], head[at + 1], head[at + 2], head[at + 3]];
        if u32::from_le_bytes(word(4)) != checksum(payload) {
            return Err(DamagedPayload::new("the checksum does not match"));
        }
        if head[1] != Self::VERSION {
            return Err(DamagedPayload::new(format!("payload version {} is unknown", head[1])));
        }
        let range =
            HeightRange { min_m: f32::from_le_bytes(word(8)), max_m: f32::from_le_bytes(word(12)) };
        let header = Self {
            kind: kind_of(head[0])?,
            stored_size_texels: u16::from_le_bytes([head[2], head[3]]),
            range: (range.min_m <= range.max_m).then_some(range),
        };
        Ok((header, body))
    }
}

/// CRC-32 of a payload, its checksum field left out.
fn checksum(payload: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&payload[..4]);
    hasher.update(&payload[8..]);
    hasher.finalize()
}

fn kind_of(tag: u8) -> Result<PayloadKind, DamagedPayload> {
    use PayloadKind::{Bc1, Bc7, HeightMetres, HeightSteps, Jpeg, Rgba8};
    [HeightSteps, HeightMetres, Bc1, Bc7, Rgba8, Jpeg]
        .into_iter()
        .find(|kind| *kind as u8 == tag)
        .ok_or_else(|| DamagedPayload::new(format!("payload kind {tag} is unknown")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_single_damaged_byte_is_found() {
        let header = PayloadHeader {
            kind: PayloadKind::HeightSteps,
            stored_size_texels: 136,
            range: Some(HeightRange { min_m: -3.5, max_m: 8848.0 }),
        };
        let payload = header.seal(&[7, 8, 9]);
        assert_eq!(PayloadHeader::open(&payload), Ok((header, &[7, 8, 9][..])));
        for index in 0..payload.len() {
            let mut damaged = payload.clone();
            damaged[index] ^= 0x10;
            assert!(PayloadHeader::open(&damaged).is_err(), "byte {index}");
        }
        for length in 0..payload.len() {
            assert!(PayloadHeader::open(&payload[..length]).is_err(), "length {length}");
        }
    }
}
