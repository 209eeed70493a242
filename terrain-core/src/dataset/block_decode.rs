use super::{ColourFormat, ColourTile};

impl ColourTile {
    /// The same tile with its blocks decoded to plain RGBA8.
    pub fn into_rgba8(self) -> Self {
        let decode: fn(&[u8], &mut [u8], usize) = match self.format {
            ColourFormat::Rgba8 => return self,
            ColourFormat::Bc1 => bcdec_rs::bc1,
            ColourFormat::Bc7 => bcdec_rs::bc7,
        };
        let block_bytes = if self.format == ColourFormat::Bc1 { 8 } else { 16 };
        let size = self.stored_size_texels as usize;
        let pitch = size * 4;
        let mut data = vec![0; pitch * size];
        for (index, block) in self.data.chunks_exact(block_bytes).enumerate() {
            let (row, column) = (index / (size / 4) * 4, index % (size / 4) * 4);
            decode(block, &mut data[row * pitch + column * 4..], pitch);
        }
        Self { format: ColourFormat::Rgba8, data, ..self }
    }
}
