use glam::{DVec2, IVec2, Vec2};

use super::{PageId, PageLayout, PageRequest};

/// A place in a virtual texture: a texel of level 0 and the part of the way across it, so that no place
/// loses precision however large the texture is. The twin of `TexturePlace` in `common/page_table.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TexturePlace {
    /// The texel, x to the east (along s), y to the south (along t).
    pub texel: IVec2,
    /// Within the texel, each in [0, 1).
    pub part: Vec2,
}

impl TexturePlace {
    /// The place at texture coordinates (s, t), both in [0, 1] over all that holds data.
    pub fn from_coordinates(layout: &PageLayout, st: DVec2) -> Self {
        let texels = st * (layout.data_end - layout.data_first).as_dvec2();
        Self::from_offset(layout, layout.data_first, texels)
    }

    /// The place so many texels of level 0 from a texel's north-west corner; where the texture goes round, in its own
    /// turn.
    pub fn from_offset(layout: &PageLayout, texel: IVec2, offset_texels: DVec2) -> Self {
        let whole = offset_texels.floor();
        let texel = layout.turned(texel + whole.as_ivec2());
        Self { texel, part: (offset_texels - whole).as_vec2() }
    }

    /// The page of a level that holds the place; places beyond the texture belong to its outermost pages,
    /// so that s = 1 and t = 1 have one.
    pub fn page(self, layout: &PageLayout, level: u8) -> PageId {
        let tile = (self.texel / layout.tile_size_texels as i32).max(IVec2::ZERO).as_uvec2();
        let (column, row) = (tile.x.min(layout.columns - 1), tile.y.min(layout.rows - 1));
        PageId { level: 0, row, column }.coarser(level)
    }

    /// Where the place lies in a page that holds it, in texels of the page's level from its north-west
    /// corner: the paper's (s', t'), in texels.
    pub fn in_page(self, layout: &PageLayout, page: PageId) -> Vec2 {
        let corner = IVec2::new(page.column as i32, page.row as i32)
            * (layout.tile_size_texels << page.level) as i32;
        ((self.texel - corner).as_vec2() + self.part) * (-f32::from(page.level)).exp2()
    }
}

/// What of a texture lies under a pixel: how it is to be filtered. The twin of `PageFootprint` in
/// `common/page_table.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint {
    /// The level whose texels are as large as a tap, a fraction and below 0 where texels are magnified: the
    /// paper's e.
    pub level: f32,
    /// Taps along the longer side: the paper's n_A.
    pub taps: f32,
}

impl Footprint {
    /// The footprint of a pixel whose sides are `span_x` and `span_y` texels of level 0 long, filtered with
    /// `most_taps` taps at the most (the paper's N_A; 1 filters isotropically).
    ///
    /// Step 2 of the paper's first algorithm: d_max and d_min are the longer and the shorter side,
    /// n_A = min(ceil(d_max / d_min), N_A), e = log2(d_max / n_A). Departure: a side shorter than a texel
    /// counts as a texel, since taps closer than that find nothing new.
    pub fn new(span_x: Vec2, span_y: Vec2, most_taps: u32) -> Self {
        let (square_x, square_y) = (span_x.length_squared(), span_y.length_squared());
        let major = square_x.max(square_y).max(1.0e-12);
        let minor = square_x.min(square_y).max(1.0);
        let taps = (major / minor).sqrt().ceil().clamp(1.0, most_taps.max(1) as f32);
        Self { level: 0.5 * major.log2() - taps.log2(), taps }
    }

    /// The request of a pixel with this footprint at the place, `bias` levels coarser than it is; `None` where
    /// always resident levels serve it. The paper's triple (q, i, j), with the page's own i and j instead of
    /// those of level 0, so that a page comes up once however many pages of level 0 it covers.
    pub fn request(
        self,
        layout: &PageLayout,
        place: TexturePlace,
        bias: f32,
    ) -> Option<PageRequest> {
        let steps = PageRequest::STEPS;
        let wanted = ((self.level + bias) * steps as f32).floor() as i32;
        let wanted = wanted.max(-PageRequest::STEPS_BELOW);
        let level = wanted.max(0) / steps;
        if level >= i32::from(layout.first_resident_level()) {
            return None;
        }
        let bit = wanted - level * steps + PageRequest::STEPS_BELOW;
        Some(PageRequest::new(place.page(layout, level as u8), 1 << bit))
    }
}

#[cfg(test)]
mod tests {
    use glam::{dvec2, ivec2, vec2};

    use super::*;

    fn layout() -> PageLayout {
        PageLayout::of_texture([1_000, 700], (128, 4), 1).unwrap()
    }

    #[test]
    fn the_far_edges_belong_to_the_outermost_pages() {
        let layout = layout();
        let corner = TexturePlace::from_coordinates(&layout, dvec2(1.0, 1.0));
        assert_eq!(corner.texel, ivec2(1_000, 700));
        assert_eq!(corner.page(&layout, 0), PageId { level: 0, row: 5, column: 7 });
        let origin = TexturePlace::from_coordinates(&layout, DVec2::ZERO);
        assert_eq!(origin.page(&layout, 0), PageId { level: 0, row: 0, column: 0 });
        let full = PageLayout::of_texture([1_024, 512], (128, 4), 1).unwrap();
        let corner = TexturePlace::from_coordinates(&full, dvec2(1.0, 1.0));
        assert_eq!(corner.page(&full, 0), PageId { level: 0, row: 3, column: 7 });
        assert_eq!(corner.in_page(&full, corner.page(&full, 0)), vec2(128.0, 128.0));
        assert_eq!(corner.in_page(&full, corner.page(&full, 2)), vec2(128.0, 128.0));
    }

    #[test]
    fn a_place_in_a_coarser_page_is_the_same_place() {
        let layout = layout();
        let place = TexturePlace::from_coordinates(&layout, dvec2(0.437, 0.811));
        for level in 0..=layout.coarsest_level {
            let page = place.page(&layout, level);
            let within = place.in_page(&layout, page);
            let size = layout.tile_size_texels as f32;
            let corner = vec2(page.column as f32, page.row as f32) * size;
            let back = (corner + within) * f32::from(level).exp2();
            assert!((back - vec2(437.0, 567.7)).length() < 1.0e-3, "level {level}: {back}");
        }
    }

    #[test]
    fn the_level_is_the_paper_s() {
        let level = |x: Vec2, y: Vec2, taps| Footprint::new(x, y, taps);
        assert_eq!(level(vec2(4.0, 0.0), vec2(0.0, 4.0), 16), Footprint { level: 2.0, taps: 1.0 });
        assert_eq!(level(vec2(16.0, 0.0), vec2(0.0, 4.0), 16), Footprint { level: 2.0, taps: 4.0 });
        assert_eq!(level(vec2(16.0, 0.0), vec2(0.0, 4.0), 2), Footprint { level: 3.0, taps: 2.0 });
        assert_eq!(level(vec2(16.0, 0.0), vec2(0.0, 4.0), 1), Footprint { level: 4.0, taps: 1.0 });
        let magnified = level(vec2(0.25, 0.0), vec2(0.0, 0.25), 16);
        assert_eq!(magnified, Footprint { level: -2.0, taps: 1.0 });
    }

    #[test]
    fn always_resident_levels_are_not_asked_for() {
        let layout = layout();
        let place = TexturePlace::from_coordinates(&layout, dvec2(0.5, 0.5));
        let request =
            |level: f32, bias| Footprint { level, taps: 1.0 }.request(&layout, place, bias);
        assert_eq!(request(2.99, 0.0).unwrap().page(&layout).unwrap().level, 2);
        assert_eq!(request(3.0, 0.0), None);
        assert_eq!(request(2.0, 1.5), None);
        let steps = |level, bias| request(level, bias).unwrap().steps();
        assert_eq!((steps(0.0, 0.0), steps(0.99, 0.0)), (1 << 16, 1 << 23));
        assert_eq!((steps(-9.0, 0.0), steps(-0.1, 0.0)), (1, 1 << 15));
    }
}
