//! Tiles and their squared distances in units as integers that order as selection wants them: comparing two of these
//! takes no branch, which makes sorting twice as fast.

use crate::tiling::TileId;

/// Bits of a row or a column: [`MAX_LEVEL`](crate::tiling::MAX_LEVEL).
const PLACE_BITS: u32 = 24;
const PLACE_MASK: u128 = (1 << PLACE_BITS) - 1;
const LEVEL_BITS: u32 = 5;
const LEVEL_MASK: u8 = (1 << LEVEL_BITS) - 1;

/// Nearest first; at equal distance by level, row and column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct FarthestOrder(u128);

impl FarthestOrder {
    pub fn new(distance: u64, tile: TileId) -> Self {
        let distance = u128::from(distance) << (LEVEL_BITS + 2 * PLACE_BITS);
        Self(distance | u128::from(tile.level) << (2 * PLACE_BITS) | place_bits(tile))
    }

    /// The tile the key was made of.
    pub fn tile(self) -> TileId {
        let level = (self.0 >> (2 * PLACE_BITS)) as u8 & LEVEL_MASK;
        TileId::new(level, row_of(self.0), column_of(self.0))
    }
}

/// Coarsest level first, within a level nearest first, at equal distance by row and column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct PriorityOrder(u128);

impl PriorityOrder {
    pub fn new(distance: u64, tile: TileId) -> Self {
        let level = u128::from(tile.level) << (64 + 2 * PLACE_BITS);
        Self(level | u128::from(distance) << (2 * PLACE_BITS) | place_bits(tile))
    }

    /// The tile the key was made of.
    pub fn tile(self) -> TileId {
        let level = (self.0 >> (64 + 2 * PLACE_BITS)) as u8;
        TileId::new(level, row_of(self.0), column_of(self.0))
    }
}

fn row_of(key: u128) -> u32 {
    (key >> PLACE_BITS & PLACE_MASK) as u32
}

fn column_of(key: u128) -> u32 {
    (key & PLACE_MASK) as u32
}

fn place_bits(tile: TileId) -> u128 {
    u128::from(tile.row) << PLACE_BITS | u128::from(tile.column)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::tiling::MAX_LEVEL;

    fn tiles() -> impl Strategy<Value = TileId> {
        (0..=MAX_LEVEL, any::<u32>(), any::<u32>()).prop_map(|(level, row, column)| {
            TileId::new(level, row % (1 << level), column % (1 << level))
        })
    }

    fn distances() -> impl Strategy<Value = u64> {
        prop_oneof![Just(0), Just(1), Just(u64::MAX), any::<u64>()]
    }

    proptest! {
        #[test]
        fn keys_order_as_their_parts_do(a in (distances(), tiles()), b in (distances(), tiles())) {
            let by_distance = || a.0.cmp(&b.0);
            let farthest = FarthestOrder::new(a.0, a.1).cmp(&FarthestOrder::new(b.0, b.1));
            prop_assert_eq!(farthest, by_distance().then(a.1.cmp(&b.1)));
            let priority = PriorityOrder::new(a.0, a.1).cmp(&PriorityOrder::new(b.0, b.1));
            let expected = a.1.level.cmp(&b.1.level).then_with(by_distance).then(a.1.cmp(&b.1));
            prop_assert_eq!(priority, expected);
            prop_assert_eq!(PriorityOrder::new(a.0, a.1).tile(), a.1);
            prop_assert_eq!(FarthestOrder::new(a.0, a.1).tile(), a.1);
        }
    }
}
