use glam::{DVec2, IVec2};

use crate::dataset::Shape;
use crate::tiling::{Extent, TileId, TilingScheme};

/// The address of one tile of a virtual texture.
///
/// Counted as the paper counts: level 0 is the *finest* (its q), row is i and column is j. Addresses
/// order finest level first, then by row and column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct PageId {
    /// q: 0 is the finest level.
    pub level: u8,
    /// i: 0 is the northernmost row.
    pub row: u32,
    /// j: 0 is the westernmost column.
    pub column: u32,
}

impl PageId {
    /// The page so many levels coarser that holds this one.
    #[must_use]
    pub fn coarser(self, levels: u8) -> Self {
        Self { level: self.level + levels, row: self.row >> levels, column: self.column >> levels }
    }
}

/// How a virtual texture is cut into pages, and where each page stands in tables over all of them.
///
/// Level 0 has `columns` x `rows` pages, every further level half as many a side, rounded up. Neither
/// number need be a power of two, and what of the outermost pages lies beyond the texture is not sampled.
#[derive(Clone, Debug, PartialEq)]
pub struct PageLayout {
    /// Pages of level 0 from west to east; at least 1.
    pub columns: u32,
    /// Pages of level 0 from north to south; at least 1.
    pub rows: u32,
    /// Texels along a side of a page, gutter not counted.
    pub tile_size_texels: u32,
    /// Texels that a page repeats from its neighbours on every side.
    pub gutter_texels: u32,
    /// L: the coarsest level.
    pub coarsest_level: u8,
    /// L': so many of the coarsest levels are always resident (the paper's group G1); at least 1.
    pub resident_levels: u8,
    /// First texel of level 0 that holds data.
    pub data_first: IVec2,
    /// Texel of level 0 after the last that holds data.
    pub data_end: IVec2,
    /// Texels of level 0 once round, where what leaves the texture in the east comes back in the west; 0 where the
    /// texture ends there. If not 0, level 0 is a power of two of whole pages wide, and so all levels go round too.
    pub round_texels: i32,
    /// Where each level begins in a table over all pages, finest level first.
    level_starts: Vec<u32>,
}

impl PageLayout {
    /// Most pages of all levels together: tables of 4 bytes a page then have 32 MiB at the most. With
    /// pages of 384 texels that is a texture of 900,000 texels a side.
    pub const MOST_PAGES: u32 = 1 << 23;
    /// Most rows or columns of level 0: requests hold either in 16 bits.
    pub const MOST_A_SIDE: u32 = 1 << 16;

    /// The layout of a texture of so many texels, whose coarsest level is one page.
    ///
    /// `size_texels`, `tile_size_texels` and `resident_levels` of 0 are taken as 1. `None` where there
    /// would be more pages than [`Self::MOST_PAGES`] or [`Self::MOST_A_SIDE`].
    pub fn of_texture(
        size_texels: [u32; 2],
        (tile_size_texels, gutter_texels): (u32, u32),
        resident_levels: u8,
    ) -> Option<Self> {
        let tile = tile_size_texels.max(1);
        let size_texels = size_texels.map(|size| size.max(1));
        let [columns, rows] = size_texels.map(|size| size.div_ceil(tile));
        let coarsest_level = columns.max(rows).next_power_of_two().ilog2() as u8;
        let mut layout = Self {
            columns,
            rows,
            tile_size_texels: tile,
            gutter_texels,
            coarsest_level,
            resident_levels: resident_levels.clamp(1, coarsest_level + 1),
            data_first: IVec2::ZERO,
            data_end: IVec2::new(size_texels[0] as i32, size_texels[1] as i32),
            round_texels: 0,
            level_starts: Vec::new(),
        };
        layout.number_levels().then_some(layout)
    }

    /// The layout of the ground of a tiling, from its root's north-west corner to where its data ends,
    /// with pages that are its tiles. Those of a globe go round.
    ///
    /// `finest_level` is the finest level of tiles there is. Where that would make more pages than
    /// there may be, the layout ends at the finest level that does not.
    pub fn of_ground(
        scheme: &TilingScheme,
        (data_extent, shape): (&Extent, Shape),
        finest_level: u8,
        (tile_size_texels, gutter_texels): (u32, u32),
    ) -> Self {
        let mut finest_level = finest_level;
        loop {
            let texel_m = scheme.tile_size_m(finest_level) / f64::from(tile_size_texels);
            let texel =
                |x: f64, y: f64| DVec2::new(x - scheme.origin.x, scheme.origin.y - y) / texel_m;
            let first = texel(data_extent.min.x, data_extent.max.y);
            let end = texel(data_extent.max.x, data_extent.min.y);
            let tiles = |texels: f64| {
                let tiles = (texels / f64::from(tile_size_texels) - 1.0e-6).ceil();
                (tiles.max(1.0) as u32).min(1 << finest_level)
            };
            let mut layout = Self {
                columns: tiles(end.x),
                rows: tiles(end.y),
                tile_size_texels,
                gutter_texels,
                coarsest_level: finest_level,
                resident_levels: 1,
                data_first: first.round().as_ivec2(),
                data_end: end.round().as_ivec2(),
                round_texels: match shape {
                    Shape::Plane => 0,
                    Shape::Globe => (tile_size_texels << finest_level) as i32,
                },
                level_starts: Vec::new(),
            };
            // A layout of one page always fits.
            if layout.number_levels() || finest_level == 0 {
                return layout;
            }
            finest_level -= 1;
        }
    }

    /// Says where each level begins; false where there are too many pages.
    fn number_levels(&mut self) -> bool {
        let mut start = 0_u64;
        self.level_starts.clear();
        for level in 0..=self.coarsest_level {
            self.level_starts.push(start as u32);
            start += u64::from(self.columns_at(level)) * u64::from(self.rows_at(level));
        }
        start <= u64::from(Self::MOST_PAGES) && self.columns.max(self.rows) <= Self::MOST_A_SIDE
    }

    /// The texel of level 0 that stands for this one, which may lie beyond the texture: where the texture goes round,
    /// the same in its own turn.
    pub fn turned(&self, texel: IVec2) -> IVec2 {
        match self.round_texels {
            0 => texel,
            round => IVec2::new(texel.x.rem_euclid(round), texel.y),
        }
    }

    /// Columns of a level.
    pub fn columns_at(&self, level: u8) -> u32 {
        self.columns.div_ceil(1 << level)
    }

    /// Rows of a level.
    pub fn rows_at(&self, level: u8) -> u32 {
        self.rows.div_ceil(1 << level)
    }

    /// Pages of all levels.
    pub fn page_count(&self) -> u32 {
        let last = self.coarsest_level;
        self.level_start(last) + self.columns_at(last) * self.rows_at(last)
    }

    /// Where the level begins in a table over all pages; levels that are not there begin at 0.
    pub fn level_start(&self, level: u8) -> u32 {
        self.level_starts.get(usize::from(level)).copied().unwrap_or(0)
    }

    /// Whether there is such a page.
    pub fn contains(&self, page: PageId) -> bool {
        page.level <= self.coarsest_level
            && page.row < self.rows_at(page.level)
            && page.column < self.columns_at(page.level)
    }

    /// Where the page stands in a table over all pages, for a page that there is.
    pub fn address(&self, page: PageId) -> u32 {
        self.level_start(page.level) + page.row * self.columns_at(page.level) + page.column
    }

    /// The first of the levels that are always resident: the paper's L - L' + 1.
    pub fn first_resident_level(&self) -> u8 {
        self.coarsest_level + 1 - self.resident_levels
    }

    /// Whether the page is one of those that are always resident.
    pub fn is_always_resident(&self, page: PageId) -> bool {
        page.level >= self.first_resident_level()
    }

    /// The pages that are always resident, coarsest first.
    pub fn resident_pages(&self) -> impl Iterator<Item = PageId> + '_ {
        (self.first_resident_level()..=self.coarsest_level).rev().flat_map(move |level| {
            let columns = self.columns_at(level);
            (0..self.rows_at(level) * columns).map(move |index| PageId {
                level,
                row: index / columns,
                column: index % columns,
            })
        })
    }

    /// The tile that is the page: **the** place where levels that count from the finest meet levels that
    /// count from the coarsest.
    pub fn tile_of(&self, page: PageId) -> TileId {
        TileId::new(self.coarsest_level - page.level, page.row, page.column)
    }

    /// The page that is the tile; the reverse of [`Self::tile_of`]. `None` for a tile finer than any
    /// page or beyond the texture.
    pub fn page_of(&self, tile: TileId) -> Option<PageId> {
        let level = self.coarsest_level.checked_sub(tile.level)?;
        let page = PageId { level, row: tile.row, column: tile.column };
        self.contains(page).then_some(page)
    }
}

#[cfg(test)]
mod tests {
    use glam::dvec2;
    use proptest::prelude::*;

    use super::*;
    use crate::geodesy::PlateCarree;

    proptest! {
        #[test]
        fn addresses_number_all_pages_without_gap(
            width in 1_u32..3_000, height in 1_u32..3_000, tile in 1_u32..300, resident in 0_u8..4,
        ) {
            let Some(layout) = PageLayout::of_texture([width, height], (tile, 4), resident) else {
                return Ok(());
            };
            let mut next = 0;
            for level in 0..=layout.coarsest_level {
                for row in 0..layout.rows_at(level) {
                    for column in 0..layout.columns_at(level) {
                        let page = PageId { level, row, column };
                        prop_assert_eq!(layout.address(page), next);
                        prop_assert!(layout.contains(page));
                        prop_assert_eq!(layout.page_of(layout.tile_of(page)), Some(page));
                        next += 1;
                    }
                }
            }
            prop_assert_eq!(layout.page_count(), next);
            let coarsest = layout.coarsest_level;
            prop_assert_eq!((layout.rows_at(coarsest), layout.columns_at(coarsest)), (1, 1));
            let resident = layout.resident_pages().collect::<Vec<_>>();
            prop_assert!(resident.iter().all(|page| layout.is_always_resident(*page)));
            let first = layout.level_start(layout.first_resident_level());
            prop_assert_eq!(resident.len() as u32, next - first);
        }
    }

    #[test]
    fn the_pages_of_ground_are_its_tiles_as_far_as_data_goes() {
        let scheme = TilingScheme { origin: dvec2(1_000.0, 9_000.0), root_size_m: 4_096.0 };
        let extent = Extent::new(dvec2(1_100.0, 6_000.0), dvec2(4_000.0, 8_900.0));
        let layout = PageLayout::of_ground(&scheme, (&extent, Shape::Plane), 5, (128, 4));
        // Tiles of 128 m: 3,000 m east and south of the corner.
        assert_eq!((layout.columns, layout.rows, layout.coarsest_level), (24, 24, 5));
        assert_eq!(layout.data_first, IVec2::new(100, 100));
        assert_eq!(layout.data_end, IVec2::new(3_000, 3_000));
        let page = PageId { level: 2, row: 5, column: 3 };
        assert_eq!(layout.tile_of(page), TileId::new(3, 5, 3));
        assert_eq!(layout.page_of(TileId::new(6, 0, 0)), None, "finer than any page");
        assert_eq!(layout.page_of(TileId::new(5, 0, 24)), None, "beyond the data");
        assert_eq!(page.coarser(2), PageId { level: 4, row: 1, column: 0 });
    }

    #[test]
    fn ground_deeper_than_tables_can_be_ends_at_a_coarser_level() {
        let scheme = TilingScheme { origin: DVec2::ZERO, root_size_m: 1.0e6 };
        let layout =
            PageLayout::of_ground(&scheme, (&scheme.root_extent(), Shape::Plane), 20, (384, 4));
        assert_eq!((layout.coarsest_level, layout.columns), (11, 2_048));
        assert!(layout.page_count() <= PageLayout::MOST_PAGES);
        assert_eq!(layout.tile_of(PageId { level: 0, row: 7, column: 9 }), TileId::new(11, 7, 9));
    }

    #[test]
    fn the_paper_s_globe_fits_and_goes_round() {
        let (scheme, extent) = (PlateCarree::scheme(), PlateCarree::extent());
        let ground = PageLayout::of_ground(&scheme, (&extent, Shape::Globe), 9, (512, 4));
        assert_eq!((ground.columns, ground.rows, ground.coarsest_level), (512, 256, 9));
        assert_eq!(
            (ground.data_first, ground.data_end),
            (IVec2::ZERO, IVec2::new(1 << 18, 1 << 17))
        );
        assert_eq!(ground.turned(IVec2::new(1 << 18, 5)), IVec2::new(0, 5));
        assert_eq!(ground.turned(IVec2::new(-1, 5)), IVec2::new((1 << 18) - 1, 5));
        let layout = PageLayout::of_texture([1 << 18, 1 << 17], (512, 4), 3).unwrap();
        assert_eq!((layout.columns, layout.rows, layout.coarsest_level), (512, 256, 9));
        assert_eq!(layout.first_resident_level(), 7);
        assert_eq!(PageLayout::of_texture([1 << 31, 1 << 31], (512, 4), 1), None);
    }
}
