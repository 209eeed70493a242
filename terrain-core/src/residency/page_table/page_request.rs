use std::collections::{BTreeMap, BTreeSet};

use super::{PageId, PageLayout};

/// A page that pixels asked for and how fine they wanted it, in two words: what a GPU reports. The twin of
/// `common/page_request.wgsl`.
///
/// The first word holds the page's level in its lowest 8 bits and [`Self::STEP_BITS`] bits above them, one
/// for each step of an eighth of a level that some pixel wanted; the second the row (high half) and the
/// column. All bits set stand for none.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, bytemuck::Pod, bytemuck::Zeroable,
)]
#[repr(C)]
pub struct PageRequest {
    level_and_steps: u32,
    row_and_column: u32,
}

impl PageRequest {
    /// What a pixel without texture, or one that always resident levels serve, holds.
    pub const NONE: Self = Self { level_and_steps: u32::MAX, row_and_column: u32::MAX };
    /// Steps that a level is told apart in.
    pub const STEPS: i32 = 8;
    /// Steps below level 0 that are told apart: so much finer than the texture pixels may want it and
    /// still be served exactly when all are served coarser.
    pub const STEPS_BELOW: i32 = 16;
    /// Bits of the steps: those below level 0, then those of the level itself.
    pub const STEP_BITS: u32 = 24;

    /// The request for a page by pixels that wanted it at these steps, a bit a step from
    /// [`Self::STEPS_BELOW`] below the level on.
    pub fn new(page: PageId, steps: u32) -> Self {
        Self {
            level_and_steps: u32::from(page.level) | (steps << 8),
            row_and_column: (page.row << 16) | (page.column & 0xffff),
        }
    }

    /// The page; `None` in [`Self::NONE`] and where the layout has no such page.
    pub fn page(self, layout: &PageLayout) -> Option<PageId> {
        let page = PageId {
            level: (self.level_and_steps & 0xff) as u8,
            row: self.row_and_column >> 16,
            column: self.row_and_column & 0xffff,
        };
        (self != Self::NONE && layout.contains(page)).then_some(page)
    }

    /// The steps' bits.
    pub fn steps(self) -> u32 {
        self.level_and_steps >> 8
    }
}

/// The pages that a picture's pixels asked for, each with the steps' bits of all who did.
pub type PagesAsked = BTreeMap<PageId, u32>;

/// The requests of pixels or of a GPU's list as one set: the second stage of the paper by sorting, as a CPU
/// does it.
pub fn unite(layout: &PageLayout, requests: impl IntoIterator<Item = PageRequest>) -> PagesAsked {
    let mut asked = PagesAsked::new();
    let mut before = PageRequest::NONE;
    for request in requests {
        // Neighbouring pixels mostly ask for the same.
        if request == before {
            continue;
        }
        before = request;
        if let Some(page) = request.page(layout) {
            *asked.entry(page).or_default() |= request.steps();
        }
    }
    asked
}

/// The pages to serve pixels with that asked for these, all of them `coarser_steps` eighths of a level coarser
/// than they asked: exactly the pages they would have asked for so, as long as none wanted more than
/// [`PageRequest::STEPS_BELOW`] steps below level 0. Pages that are always resident are left out.
pub fn coarsened(layout: &PageLayout, asked: &PagesAsked, coarser_steps: i32) -> BTreeSet<PageId> {
    let mut pages = BTreeSet::new();
    for (&page, &steps) in asked {
        let first = i32::from(page.level) * PageRequest::STEPS - PageRequest::STEPS_BELOW;
        for bit in (0..PageRequest::STEP_BITS as i32).filter(|bit| steps >> bit & 1 == 1) {
            let level = (first + bit + coarser_steps).max(0) / PageRequest::STEPS;
            let level = level.max(i32::from(page.level)).min(i32::from(layout.coarsest_level));
            let served = page.coarser(level as u8 - page.level);
            if !layout.is_always_resident(served) {
                pages.insert(served);
            }
        }
    }
    pages
}

/// The least eighths of a level that all must be served coarser for what they need, `serve` being what
/// serves each page, to be at most `most_pages`; and what they need then, finest first.
///
/// It depends on what was asked alone, so that a still camera always ends with the same pages however it
/// came there.
pub fn fitting(
    layout: &PageLayout,
    asked: &PagesAsked,
    most_pages: usize,
    serve: impl Fn(PageId) -> PageId,
) -> (i32, Vec<PageId>) {
    // From here on all pages are always resident.
    let last =
        (i32::from(layout.coarsest_level) + 1) * PageRequest::STEPS + PageRequest::STEPS_BELOW;
    for coarser_steps in 0..last {
        let pages = coarsened(layout, asked, coarser_steps).into_iter().map(&serve);
        let pages = pages.filter(|&page| !layout.is_always_resident(page)).collect::<BTreeSet<_>>();
        if pages.len() <= most_pages {
            return (coarser_steps, pages.into_iter().collect());
        }
    }
    (last, Vec::new())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn layout() -> PageLayout {
        PageLayout::of_texture([20 * 64, 13 * 64], (64, 4), 1).unwrap()
    }

    /// A pixel: a page of level 0 and the level it wants, in steps.
    fn pixels() -> impl Strategy<Value = Vec<(u32, u32, i32)>> {
        prop::collection::vec((0_u32..13, 0_u32..20, -16_i32..48), 1..60)
    }

    /// What a pixel asks for, one level or step at a time instead of by bits.
    fn page_for((row, column, wanted): (u32, u32, i32), layout: &PageLayout) -> PageId {
        let level = wanted.div_euclid(8).clamp(0, i32::from(layout.coarsest_level)) as u8;
        PageId { level: 0, row, column }.coarser(level)
    }

    fn request(pixel: (u32, u32, i32), layout: &PageLayout) -> PageRequest {
        let page = page_for(pixel, layout);
        let bit = (pixel.2 - 8 * i32::from(page.level) + 16).min(23);
        PageRequest::new(page, 1 << bit)
    }

    proptest! {
        #[test]
        fn serving_coarser_is_asking_for_coarser(pixels in pixels(), coarser in 0_i32..40) {
            let layout = layout();
            let asked = unite(&layout, pixels.iter().map(|&pixel| request(pixel, &layout)));
            let expected = pixels
                .iter()
                .map(|&(row, column, wanted)| page_for((row, column, wanted + coarser), &layout))
                .filter(|page| !layout.is_always_resident(*page))
                .collect::<BTreeSet<_>>();
            prop_assert_eq!(coarsened(&layout, &asked, coarser), expected);
        }

        #[test]
        fn what_fits_is_the_finest_that_does(pixels in pixels(), most in 0_usize..30) {
            let layout = layout();
            let asked = unite(&layout, pixels.iter().map(|&pixel| request(pixel, &layout)));
            let (steps, pages) = fitting(&layout, &asked, most, |page| page);
            prop_assert!(pages.len() <= most);
            prop_assert!(pages.is_sorted());
            for finer in 0..steps {
                prop_assert!(coarsened(&layout, &asked, finer).len() > most);
            }
        }
    }

    #[test]
    fn a_request_in_two_words_is_read_as_it_was_written() {
        let layout = layout();
        let page = PageId { level: 3, row: 1, column: 2 };
        let request = PageRequest::new(page, 0x80_0001);
        assert_eq!((request.page(&layout), request.steps()), (Some(page), 0x80_0001));
        assert_eq!(PageRequest::NONE.page(&layout), None);
        let beyond = PageId { level: 3, row: 2, column: 0 };
        assert_eq!(PageRequest::new(beyond, 1).page(&layout), None, "no such page");
    }

    #[test]
    fn what_another_page_serves_counts_once() {
        let layout = layout();
        let pixels = (0..8).map(|column| request((0, column, 0), &layout));
        let asked = unite(&layout, pixels);
        // Nothing finer than level 2 exists.
        let serve = |page: PageId| page.coarser(2_u8.saturating_sub(page.level));
        let (steps, pages) = fitting(&layout, &asked, 2, serve);
        assert_eq!((steps, pages.len()), (0, 2));
    }
}
