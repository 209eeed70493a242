use super::eye_units::{EyeUnits, SplitDistances};
use super::ground_units::GroundUnits;
use super::selection_params::eye_ground;
use super::{CoordinateImage, TileTree};
use crate::tiling::{FixedPosition, MAX_LEVEL, TileId};

/// The tiles that the pixels of a coordinate image saw: what is visible exactly, up to the size of a
/// pixel, where the box round all of it holds what mountains hide as well.
///
/// A tile is seen where a pixel lies on it. A pixel stands for the ground around it, so the ground
/// between neighbours is seen too, as the smallest rectangle round each two by two of them, while that
/// is at most [`Self::MOST_TILES_ACROSS`] tiles across: between ground and the far side of what hides the
/// ground behind it, nothing is known to be visible. Of each level only children of tiles that
/// subdivision would split are kept; their ancestors are seen with them.
///
/// The twin of `mark_seen_tiles.wgsl`, tile for tile.
#[derive(Clone, Debug)]
pub(crate) struct SeenTiles {
    /// A table with open addressing: keys of tiles, 0 where free; its length a power of two.
    slots: Vec<u32>,
    count: u32,
    eye_ground: [i32; 2],
}

/// Ground in units, both corners part of it.
#[derive(Clone, Copy)]
struct Ground {
    first: [u32; 2],
    last: [u32; 2],
}

/// What marking goes by.
struct Marker<'a> {
    tree: &'a TileTree,
    eye: &'a EyeUnits,
    split_below: &'a SplitDistances,
    /// Where the ground last marked ended: one tile, not split.
    last_leaf: Option<TileId>,
}

impl SeenTiles {
    /// Tiles across that ground between neighbouring pixels may be.
    pub const MOST_TILES_ACROSS: u32 = 3;
    /// Tiles that are kept at the most.
    pub const MOST_TILES: u32 = 1 << 15;
    /// Rows and columns from the eye's tile that a tile may lie away.
    const KEY_REACH: i32 = 4_096;

    /// The tiles the image saw that subdivision could ask for; `None` where they are too many to keep,
    /// or too far away to tell.
    pub fn of_image(
        image: &CoordinateImage,
        tree: &TileTree,
        eye: &EyeUnits,
        split_below: &SplitDistances,
    ) -> Option<Self> {
        let units = GroundUnits::new(&tree.scheme, image.origin);
        let mut seen = Self { slots: vec![0; 1 << 11], count: 0, eye_ground: eye_ground(eye) };
        let mut marker = Marker { tree, eye, split_below, last_leaf: None };
        let unit_of = |&offset: &[f32; 2]| {
            offset.iter().all(|metres| metres.is_finite()).then(|| units.unit_at(offset))
        };
        let positions: Vec<_> = image.offsets.iter().map(unit_of).collect();
        let rows: Vec<_> = positions.chunks_exact(image.width.max(1) as usize).collect();
        let at = |row: &[Option<FixedPosition>], x: usize| row.get(x).copied().flatten();
        for (y, row) in rows.iter().enumerate() {
            let below = rows.get(y + 1).copied().unwrap_or_default();
            for x in 0..row.len() {
                let own = at(row, x);
                let corners = [own, at(row, x + 1), at(below, x), at(below, x + 1)];
                let Some(ground) = Ground::round(&corners) else { continue };
                if !marker.mark(&mut seen, ground)?
                    && let Some(ground) = Ground::round(&[own])
                {
                    marker.mark(&mut seen, ground)?;
                }
            }
        }
        Some(seen)
    }

    /// Number of tiles.
    #[cfg(test)]
    pub fn len(&self) -> u32 {
        self.count
    }

    /// Whether a tile of level 1 or finer, whose parent subdivision would split, was seen.
    pub fn contains(&self, tile: TileId) -> bool {
        self.key(tile).is_some_and(|key| self.slots[self.slot(key)] == key)
    }

    fn insert(&mut self, tile: TileId) -> Option<()> {
        let key = self.key(tile)?;
        let slot = self.slot(key);
        if self.slots[slot] == key {
            return Some(());
        }
        self.slots[slot] = key;
        self.count += 1;
        if 2 * self.count as usize > self.slots.len() {
            self.grow();
        }
        (self.count <= Self::MOST_TILES).then_some(())
    }

    fn grow(&mut self) {
        let keys = std::mem::take(&mut self.slots);
        self.slots = vec![0; 2 * keys.len()];
        for key in keys.into_iter().filter(|&key| key != 0) {
            let slot = self.slot(key);
            self.slots[slot] = key;
        }
    }

    /// The key's slot, or the free one where it would be.
    fn slot(&self, key: u32) -> usize {
        let mask = self.slots.len() - 1;
        let mut slot = (key.wrapping_mul(0x9e37_79b9) >> 8) as usize & mask;
        while self.slots[slot] != 0 && self.slots[slot] != key {
            slot = (slot + 1) & mask;
        }
        slot
    }

    /// The tile by its level and where it lies from the eye's: never 0. `None` where that is too far.
    fn key(&self, tile: TileId) -> Option<u32> {
        let side = 30 - u32::from(tile.level);
        let from_eye = |index: u32, eye: i32| {
            let place = index as i32 - (eye >> side) + Self::KEY_REACH;
            (0..2 * Self::KEY_REACH).contains(&place).then_some(place as u32)
        };
        let column = from_eye(tile.column, self.eye_ground[0])?;
        let row = from_eye(tile.row, self.eye_ground[1])?;
        Some(u32::from(tile.level) << 26 | row << 13 | column)
    }
}

impl Marker<'_> {
    /// Marks the tiles of the ground. False where it is too many tiles across; `None` where they are
    /// too many to keep.
    fn mark(&mut self, seen: &mut SeenTiles, ground: Ground) -> Option<bool> {
        if self.last_leaf.is_some_and(|leaf| ground.lies_in(leaf)) {
            return Some(true);
        }
        for level in 1..=MAX_LEVEL {
            let [columns, rows] = ground.tiles(level);
            if [&columns, &rows].iter().any(|r| r.end() - r.start() >= SeenTiles::MOST_TILES_ACROSS)
            {
                return Some(false);
            }
            let mut goes_on = false;
            for row in rows {
                for column in columns.clone() {
                    let tile = TileId::new(level, row, column);
                    if self.is_split(tile.ancestor_at(level - 1)) {
                        seen.insert(tile)?;
                        goes_on = true;
                    }
                }
            }
            if !goes_on {
                let leaf = ground.tiles(level - 1).map(|range| *range.start());
                let leaf = TileId::new(level - 1, leaf[1], leaf[0]);
                self.last_leaf = Some(leaf).filter(|&leaf| ground.lies_in(leaf));
                break;
            }
        }
        Some(true)
    }

    fn is_split(&self, tile: TileId) -> bool {
        let below = self.split_below[usize::from(tile.level)];
        below > 0 && self.tree.squared_distance(tile, self.eye) < below
    }
}

impl Ground {
    /// The smallest round the positions there are.
    fn round(positions: &[Option<FixedPosition>]) -> Option<Self> {
        let of_one = |position: &FixedPosition| {
            let corner = [position.x as u32, position.y as u32];
            Self { first: corner, last: corner }
        };
        positions.iter().flatten().map(of_one).reduce(|a, b| Self {
            first: [a.first[0].min(b.first[0]), a.first[1].min(b.first[1])],
            last: [a.last[0].max(b.last[0]), a.last[1].max(b.last[1])],
        })
    }

    /// The columns and the rows of the level that it lies in.
    fn tiles(&self, level: u8) -> [std::ops::RangeInclusive<u32>; 2] {
        let side = 30 - u32::from(level);
        [0, 1].map(|axis| self.first[axis] >> side..=self.last[axis] >> side)
    }

    fn lies_in(&self, tile: TileId) -> bool {
        self.tiles(tile.level) == [tile.column..=tile.column, tile.row..=tile.row]
    }
}
