use crate::tiling::TileId;

/// The lowest and highest height in a tile, metres above the datum.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct HeightRange {
    /// Lowest height, metres.
    pub min_m: f32,
    /// Highest height, metres.
    pub max_m: f32,
}

/// A decoded height tile, ready for the GPU.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightTile {
    /// Which tile this is.
    pub id: TileId,
    /// Texels along one side, gutter counted.
    pub stored_size_texels: u32,
    /// Row-major from the north-west corner of the gutter, `stored_size_texels` squared samples.
    pub samples: HeightSamples,
    /// Range of the samples that hold data; `None` where the tile has no data at all.
    pub range: Option<HeightRange>,
}

/// The two ways in which heights are stored, both decodable without loss on CPU and GPU alike.
#[derive(Clone, Debug, PartialEq)]
pub enum HeightSamples {
    /// height = (base_steps + word) * step_m. The step is a power of two and the same for every
    /// tile of a layer, so that a sample two neighbours share decodes to the same f32 in both.
    Steps {
        /// Height of word 0, in steps. `|base_steps| + 65535` stays below 2^24: exact in f32.
        base_steps: i32,
        /// Metres a step; a power of two.
        step_m: f32,
        /// One word a sample; [`HeightSamples::NO_DATA_WORD`] marks a sample without data.
        words: Vec<u16>,
    },
    /// Heights in metres; NaN, or anything beyond [`HeightSamples::MOST_HEIGHT_M`], marks a sample
    /// without data.
    Metres(Vec<f32>),
}

impl HeightSamples {
    /// The word of a sample without data.
    pub const NO_DATA_WORD: u16 = u16::MAX;

    /// Heights farther than this above or below the datum, in metres, are no heights: no solid body
    /// known has such relief, and files mark voids with the largest floats without saying so.
    pub const MOST_HEIGHT_M: f32 = 1.0e6;

    /// Whether a float is a height, and no mark of a void or a failed computation.
    pub fn is_height(height_m: f32) -> bool {
        height_m.abs() <= Self::MOST_HEIGHT_M
    }

    /// Height of the sample at `index` in metres; `None` where there is no data.
    pub fn height_m(&self, index: usize) -> Option<f32> {
        match self {
            Self::Steps { base_steps, step_m, words } => {
                let word = words[index];
                (word != Self::NO_DATA_WORD).then(|| (base_steps + i32::from(word)) as f32 * step_m)
            }
            Self::Metres(heights_m) => {
                Some(heights_m[index]).filter(|&height_m| Self::is_height(height_m))
            }
        }
    }

    /// Bytes that go to the GPU for these samples.
    pub fn byte_len(&self) -> u64 {
        match self {
            Self::Steps { words, .. } => 2 * words.len() as u64,
            Self::Metres(heights_m) => 4 * heights_m.len() as u64,
        }
    }
}

/// The texel format of decoded colour tiles. All hold sRGB-encoded colour and linear coverage
/// (alpha: 1 where there is imagery, 0 where there is none).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ColourFormat {
    /// 4 bits a texel in 4 x 4 blocks, one-bit coverage.
    Bc1,
    /// 8 bits a texel in 4 x 4 blocks.
    Bc7,
    /// 32 bits a texel.
    Rgba8,
}

impl ColourFormat {
    /// Bytes of a square of `size_texels` (a multiple of 4) texels a side.
    pub fn byte_len(self, size_texels: u32) -> u64 {
        let texels = u64::from(size_texels) * u64::from(size_texels);
        match self {
            Self::Bc1 => texels / 2,
            Self::Bc7 => texels,
            Self::Rgba8 => texels * 4,
        }
    }
}

/// A decoded colour tile, ready for the GPU.
#[derive(Clone, Debug, PartialEq)]
pub struct ColourTile {
    /// Which tile this is.
    pub id: TileId,
    /// Texels along one side, gutter counted; a multiple of 4.
    pub stored_size_texels: u32,
    /// Format of `data`.
    pub format: ColourFormat,
    /// Rows of texels (RGBA8) or of 4 x 4 blocks (BC1, BC7) from the north-west corner.
    pub data: Vec<u8>,
}
