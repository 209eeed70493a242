use serde::{Deserialize, Serialize};

/// The deepest level an id may have: 2^24 tiles a side.
pub const MAX_LEVEL: u8 = 24;

/// The address of one tile in the pyramid; see the module's page for the order of rows and levels.
///
/// Ids order by level first (coarsest first), then row, then column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct TileId {
    /// 0 is the coarsest level.
    pub level: u8,
    /// 0 is the northernmost row.
    pub row: u32,
    /// 0 is the westernmost column.
    pub column: u32,
}

impl TileId {
    /// The one tile of level 0.
    pub const ROOT: Self = Self { level: 0, row: 0, column: 0 };

    /// The tile at this level, row and column. All three must be in range for the level.
    pub fn new(level: u8, row: u32, column: u32) -> Self {
        debug_assert!(level <= MAX_LEVEL && row < 1 << level && column < 1 << level);
        Self { level, row, column }
    }

    /// The tile one level coarser that holds this one; `None` for the root.
    pub fn parent(self) -> Option<Self> {
        (self.level > 0).then(|| Self::new(self.level - 1, self.row / 2, self.column / 2))
    }

    /// The four tiles one level finer, in the order north-west, north-east, south-west, south-east.
    /// The tile's level must be below [`MAX_LEVEL`].
    pub fn children(self) -> [Self; 4] {
        let (level, row, column) = (self.level + 1, 2 * self.row, 2 * self.column);
        [
            Self::new(level, row, column),
            Self::new(level, row, column + 1),
            Self::new(level, row + 1, column),
            Self::new(level, row + 1, column + 1),
        ]
    }

    /// The tile of `level` that holds this one; itself where `level` is its own or finer.
    pub fn ancestor_at(self, level: u8) -> Self {
        let up = self.level.saturating_sub(level);
        Self::new(self.level - up, self.row >> up, self.column >> up)
    }

    /// Whether this tile is `other` or one of its ancestors.
    pub fn covers(self, other: Self) -> bool {
        self.level <= other.level && other.ancestor_at(self.level) == self
    }

    /// Which child of its parent this is: 0 north-west, 1 north-east, 2 south-west, 3 south-east.
    pub fn quadrant(self) -> u32 {
        (self.row & 1) * 2 + (self.column & 1)
    }
}

impl std::fmt::Display for TileId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}/{}", self.level, self.row, self.column)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn children_and_parent_are_inverse() {
        let tile = TileId::new(5, 17, 30);
        for (index, child) in tile.children().into_iter().enumerate() {
            assert_eq!(child.parent(), Some(tile));
            assert_eq!(child.quadrant(), index as u32);
            assert!(tile.covers(child) && !child.covers(tile));
        }
        assert_eq!(TileId::ROOT.parent(), None);
    }

    #[test]
    fn an_ancestor_is_the_parent_taken_repeatedly() {
        let tile = TileId::new(9, 311, 77);
        let mut walk = tile;
        for level in (0..=9).rev() {
            assert_eq!(tile.ancestor_at(level), walk);
            walk = walk.parent().unwrap_or(walk);
        }
        assert_eq!(tile.ancestor_at(12), tile);
    }
}
