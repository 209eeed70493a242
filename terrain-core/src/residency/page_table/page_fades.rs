use std::collections::BTreeMap;

use super::PageId;

/// How far the pages that have just become resident have faded in over what showed in their place.
///
/// A page shows in [`Self::PARTS`] steps, one a frame.
#[derive(Clone, Debug, Default)]
pub(super) struct PageFades {
    parts: BTreeMap<PageId, u32>,
}

impl PageFades {
    /// Steps in which a page comes to show as a whole.
    pub const PARTS: u32 = 4;

    /// The page is resident from now on, and shows the first part of itself.
    pub fn begin(&mut self, page: PageId) {
        self.parts.insert(page, 1);
    }

    /// The page is not resident any more.
    pub fn forget(&mut self, page: PageId) {
        self.parts.remove(&page);
    }

    /// One frame has passed: returns the pages that show more of themselves than before.
    pub fn advance(&mut self) -> Vec<PageId> {
        let changed = self.parts.keys().copied().collect();
        self.parts.retain(|_, part| {
            *part += 1;
            *part < Self::PARTS
        });
        changed
    }

    /// How many of all parts of a resident page show.
    pub fn part(&self, page: PageId) -> u32 {
        self.parts.get(&page).copied().unwrap_or(Self::PARTS)
    }

    /// Whether any page does not show as a whole yet.
    pub fn is_fading(&self) -> bool {
        !self.parts.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_shows_a_part_more_each_frame() {
        let page = PageId { level: 1, row: 2, column: 3 };
        let mut fades = PageFades::default();
        assert_eq!(fades.part(page), PageFades::PARTS, "what does not fade shows");
        fades.begin(page);
        let mut parts = vec![fades.part(page)];
        while fades.is_fading() {
            assert_eq!(fades.advance(), [page]);
            parts.push(fades.part(page));
        }
        assert_eq!(parts, [1, 2, 3, 4]);
        assert_eq!(fades.advance(), []);
    }
}
