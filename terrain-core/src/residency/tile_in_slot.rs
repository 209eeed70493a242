use crate::tiling::TileId;

/// A tile and the slot it has or is to get, in two words: what crosses the bus about tiles where the
/// GPU keeps the cache. The twin of `common/packed_tile.wgsl`.
///
/// The first word holds the level (5 bits), the slot (11) and the low half of the column, the second the
/// row (24 bits) and the rest of the column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(transparent)]
pub(crate) struct TileInSlot([u32; 2]);

impl TileInSlot {
    /// The pair in two words. The slot is below 2048.
    pub fn new(tile: TileId, slot: u32) -> Self {
        debug_assert!(slot < 1 << 11, "slot {slot}");
        let low = u32::from(tile.level) | (slot << 5) | (tile.column << 16);
        Self([low, tile.row | ((tile.column >> 16) << 24)])
    }

    /// The tile.
    pub fn tile(self) -> TileId {
        let [low, high] = self.0;
        let column = (low >> 16) | ((high >> 24) << 16);
        TileId::new((low & 0x1f) as u8, high & 0xff_ffff, column)
    }

    /// The slot.
    pub fn slot(self) -> u32 {
        self.0[0] >> 5 & 0x7ff
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::tiling::MAX_LEVEL;

    proptest! {
        #[test]
        fn what_is_packed_comes_out_again(
            level in 0..=MAX_LEVEL, row: u32, column: u32, slot in 0u32..2048,
        ) {
            let side = 1 << level;
            let tile = TileId::new(level, row % side, column % side);
            let packed = TileInSlot::new(tile, slot);
            prop_assert_eq!((packed.tile(), packed.slot()), (tile, slot));
        }
    }
}
